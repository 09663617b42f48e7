#include "cosiva/app/agent/agent_measure_command.h"

#include <algorithm>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/thread_pool.h"
#include "cosiva/app/agent/fleet_arguments.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/cli/seed_range.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/experiments/agents/fleet_report.h"

namespace cosiva::app {
namespace {

Result<experiments::FleetPlan> plan_of(const AgentMeasureArguments& arguments) {
  const auto seeds = read_seed_range(arguments.seeds, "--seeds", "agent.seeds");
  if (!seeds) return tl::unexpected<Error>(seeds.error());
  if (seeds->count() < 2) return fail("agent.seeds", "an interval needs two seeds or more, such as 1..20", "--seeds");
  auto rules = load_speed_rules(arguments.rules);
  if (!rules) return tl::unexpected<Error>(rules.error());
  auto zone = open_zone(arguments.zone);
  if (!zone) return tl::unexpected<Error>(zone.error());
  experiments::FleetPlan plan;
  plan.rtm = std::make_shared<const zone::Rtm>(std::move(*zone));
  plan.rules = std::move(*rules);
  plan.vehicles = arguments.vehicles;
  plan.persons = arguments.persons;
  plan.first_seed = seeds->first;
  plan.last_seed = seeds->last;
  plan.duration = from_seconds(60.0 * arguments.minutes);
  return plan;
}

std::string command_of(const AgentMeasureArguments& arguments) {
  return "cosiva agent measure " + options_text(arguments) + " --fewer-stops " +
         decimals(arguments.fewer_stops_percent, 0) + " --out " + arguments.out_folder;
}

}  // namespace

int run_agent_measure(const AgentMeasureArguments& arguments) {
  const auto plan = plan_of(arguments);
  if (!plan) return report_error(plan.error());
  adapters::ThreadPool pool{arguments.jobs > 0 ? arguments.jobs : std::max(1U, std::thread::hardware_concurrency())};
  SecondsTicker ticker;
  const auto comparison = experiments::compare_fleets(*plan, pool, [&](std::size_t done, std::size_t all) {
    if (ticker.ticks()) print_info(std::to_string(done) + " of " + std::to_string(all) + " runs");
  });
  if (!comparison) return report_error(comparison.error());
  JsonWriter json;
  write_json(json, *plan, *comparison);
  const std::string written = json.take();
  if (!arguments.out_folder.empty()) {
    const std::string page = to_html(*plan, *comparison, arguments.fewer_stops_percent, command_of(arguments));
    const auto stored =
        adapters::write_files(arguments.out_folder, {{"report.json", written + "\n"}, {"report.html", page}});
    if (!stored) return report_error(stored.error());
  }
  if (arguments.json) {
    print(written);
  } else {
    std::string text = to_text(*plan, *comparison);
    text.pop_back();  // print ends the line
    print(text);
  }
  const auto violations = violations_of(*comparison, arguments.fewer_stops_percent);
  for (const std::string& violation : violations) print_info(violation);
  return violations.empty() ? exit_done : exit_check_failed;
}

}  // namespace cosiva::app
