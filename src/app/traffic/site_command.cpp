#include "cosiva/app/traffic/site_command.h"

#include <filesystem>
#include <map>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/thread_pool.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/resources/ranks.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/app/traffic/traffic_terms.h"
#include "cosiva/experiments/transport/site/site.h"
#include "cosiva/experiments/transport/site/site_report.h"

namespace cosiva::app {
namespace {

using experiments::SiteMetrics;
using experiments::SiteOptions;
using experiments::SitePlan;
using experiments::SiteRun;

bool is_file(const std::string& text) { return text.ends_with(".toml"); }

Result<SitePlan> plan_from(const FleetTrafficArguments& arguments) {
  if (!is_file(arguments.zones))
    return experiments::site_plan_of_list(arguments.zones, arguments.aivs, arguments.transfer_s);
  const auto text = adapters::read_file(arguments.zones);
  if (!text) return tl::unexpected(text.error());
  auto plan = experiments::read_site_plan(*text, arguments.zones);
  if (!plan) return plan;
  // A zone file's path is relative to the site file's folder.
  const auto folder = std::filesystem::path(arguments.zones).parent_path();
  for (SitePlan::Zone& zone : plan->zones)
    if (std::filesystem::exists(folder / zone.file)) zone.file = (folder / zone.file).string();
  return plan;
}

Result<SiteOptions> options_from(const FleetTrafficArguments& arguments) {
  auto plan = plan_from(arguments);
  if (!plan) return tl::unexpected(plan.error());
  auto terms = terms_from(arguments);
  if (!terms) return tl::unexpected(terms.error());
  SiteOptions options{std::move(*terms), std::move(*plan), {}};
  std::map<std::string, std::shared_ptr<const zone::TrafficZone>> loaded;
  for (const SitePlan::Zone& zone : options.plan.zones) {
    auto& known = loaded[zone.file];
    if (!known) {
      const auto rtm = open_zone(zone.file);
      if (!rtm) return tl::unexpected(rtm.error());
      known = rtm->shared_zone();
    }
    options.zones.push_back(known);
  }
  options.jobs_per_hour = arguments.jobs_per_hour.value_or(0.0);
  options.away_ratio = arguments.away_ratio;
  return options;
}

struct Speed {
  std::size_t ranks;
  std::uint32_t threads;
  double real_s;
  double vehicle_steps_per_s;
};

std::string json_of(const SiteMetrics& metrics, const Speed& speed) {
  JsonWriter json;
  json.begin_object().field("ranks", speed.ranks).field("threads", speed.threads).field("took_s", speed.real_s);
  json.field("vehicle_steps_per_s", speed.vehicle_steps_per_s).field("digest", metrics.digest).key("site");
  experiments::write_json(json, metrics);
  json.end_object();
  return json.take();
}

/// The command line that reproduces the result.
std::string command_of(const FleetTrafficArguments& arguments) {
  std::string command = "cosiva traffic --zones " + arguments.zones + " --aivs " + std::to_string(arguments.aivs) +
                        " --duration " + decimals(arguments.duration_s, 0) + " --warm-up " +
                        decimals(arguments.warm_up_s, 0) + " --seed " + std::to_string(arguments.seed);
  if (arguments.jobs_per_hour)
    command += " --jobs-per-hour " + decimals(*arguments.jobs_per_hour, 3) + " --away " +
               decimals(arguments.away_ratio, 3) + " --handling " + decimals(arguments.handling_s, 1);
  return command + " --transfer-time " + decimals(arguments.transfer_s, 1) + " --rules " + arguments.rules +
         " --step " + decimals(arguments.step_s, 3);
}

}  // namespace

int run_site(const FleetTrafficArguments& arguments) {
  if (!arguments.jobs_file.empty())
    return report_error({"traffic.options", "--jobs names the stations of one zone, and --zones has many", "--jobs"});
  // File errors are found before MPI begins, because then each rank can end by itself.
  auto options = options_from(arguments);
  if (!options) return report_error(options.error());
  auto ranks = start_ranks();
  if (!ranks) return report_error(ranks.error());
  const bool speaks = (*ranks)->rank() == 0;
  auto run = SiteRun::make(std::move(*options), **ranks);
  if (!run) return speaks ? report_error(run.error()) : exit_bad_input;
  Progress progress{"traffic"};
  adapters::ThreadPool workers{arguments.threads};
  while (run->advance(workers))
    if (speaks) progress.at(run->time_s(), run->end_s());
  const double real_s = progress.real_s();
  const SiteMetrics metrics = run->metrics();
  const int code = metrics.good() ? exit_done : exit_check_failed;
  if (!speaks) return code;
  const Speed speed{(*ranks)->size(), arguments.threads, real_s, static_cast<double>(metrics.vehicle_steps) / real_s};
  const std::string json = json_of(metrics, speed);
  if (!arguments.out_directory.empty()) {
    const auto written = adapters::write_files(
        arguments.out_directory,
        {{"report.html", experiments::to_html(metrics, command_of(arguments))}, {"result.json", json + "\n"}});
    if (!written) return report_error(written.error());
    print_info("report: " + arguments.out_directory + "/report.html");
  }
  if (arguments.json) {
    print(json);
    return code;
  }
  print(experiments::to_text(metrics) + "  took " + decimals(real_s, 2) + " s on " + std::to_string(speed.ranks) +
        (speed.ranks == 1 ? " process, " : " processes, ") + decimals(speed.vehicle_steps_per_s / 1e6, 2) +
        " million vehicle-steps a second; digest " + metrics.digest);
  return code;
}

}  // namespace cosiva::app
