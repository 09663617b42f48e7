#include "cosiva/app/traffic/traffic_command.h"

#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/thread_pool.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/app/traffic/site_command.h"
#include "cosiva/app/traffic/traffic_terms.h"
#include "cosiva/experiments/transport/traffic/traffic.h"
#include "cosiva/experiments/transport/traffic/traffic_report.h"

namespace cosiva::app {
namespace {

using experiments::TrafficMetrics;
using experiments::TrafficOptions;
using experiments::TrafficRun;

Result<std::vector<experiments::Job>> jobs_for(const FleetTrafficArguments& arguments, const zone::TrafficZone& zone) {
  if (!arguments.jobs_file.empty()) {
    const auto text = adapters::read_file(arguments.jobs_file);
    if (!text) return tl::unexpected(text.error());
    return experiments::jobs_from_csv(zone, *text, arguments.jobs_file);
  }
  if (!arguments.jobs_per_hour) return std::vector<experiments::Job>{};
  return experiments::poisson_jobs(zone, *arguments.jobs_per_hour, arguments.warm_up_s + arguments.duration_s,
                                   arguments.seed);
}

Result<TrafficOptions> options_from(const FleetTrafficArguments& arguments) {
  const auto rtm = open_zone(arguments.zone, arguments.sidecar);
  if (!rtm) return tl::unexpected(rtm.error());
  auto terms = terms_from(arguments);
  if (!terms) return tl::unexpected(terms.error());
  TrafficOptions options;
  static_cast<experiments::TrafficTerms&>(options) = std::move(*terms);
  options.zone = rtm->shared_zone();
  options.aivs = arguments.aivs;
  auto jobs = jobs_for(arguments, *options.zone);
  if (!jobs) return tl::unexpected(jobs.error());
  options.jobs = std::move(*jobs);
  return options;
}

/// The command line that reproduces the result.
std::string command_of(const FleetTrafficArguments& arguments) {
  std::string command = "cosiva traffic --zone " + arguments.zone + " --aivs " + std::to_string(arguments.aivs) +
                        " --duration " + decimals(arguments.duration_s, 0) + " --warm-up " +
                        decimals(arguments.warm_up_s, 0) + " --seed " + std::to_string(arguments.seed);
  if (arguments.jobs_per_hour) command += " --jobs-per-hour " + decimals(*arguments.jobs_per_hour, 3);
  if (!arguments.jobs_file.empty()) command += " --jobs " + arguments.jobs_file;
  if (arguments.jobs_per_hour || !arguments.jobs_file.empty())
    command += " --handling " + decimals(arguments.handling_s, 1);
  return command + " --rules " + arguments.rules + " --step " + decimals(arguments.step_s, 3);
}

Result<void> write_all(const FleetTrafficArguments& arguments, const TrafficRun& run, const TrafficMetrics& metrics) {
  const zone::TrafficZone& zone = run.fleet().zone();
  JsonWriter json{2};
  experiments::write_json(json, metrics);
  return adapters::write_files(arguments.out_directory,
                               {{"report.html", experiments::to_html(zone, metrics, command_of(arguments))},
                                {"result.json", json.take() + "\n"},
                                {"jobs.csv", experiments::jobs_csv(zone, run.dispatcher(), run.time_s())}});
}

}  // namespace

int run_traffic(const FleetTrafficArguments& arguments) {
  if (!arguments.zones.empty()) return run_site(arguments);
  auto options = options_from(arguments);
  if (!options) return report_error(options.error());
  auto run = TrafficRun::make(std::move(*options));
  if (!run) return report_error(run.error());
  Progress progress{"traffic"};
  adapters::ThreadPool workers{arguments.threads};
  while (run->advance(10.0, workers)) progress.at(run->time_s(), run->end_s());
  const TrafficMetrics metrics = run->metrics();
  if (!arguments.out_directory.empty()) {
    if (auto written = write_all(arguments, *run, metrics); !written) return report_error(written.error());
    print_info("report: " + arguments.out_directory + "/report.html");
  }
  if (arguments.json) {
    JsonWriter json;
    experiments::write_json(json, metrics);
    print(json.take());
  } else {
    std::string text = experiments::to_text(metrics);
    text += "  took    " + decimals(progress.real_s(), 2) + " s, " + decimals(run->time_s() / progress.real_s(), 0) +
            " times real time; digest " + metrics.digest;
    print(text);
  }
  return metrics.good() ? exit_done : exit_check_failed;
}

}  // namespace cosiva::app
