#include "cosiva/app/agent/agent_search_command.h"

#include <algorithm>
#include <memory>
#include <string>
#include <thread>
#include <utility>

#include "cosiva/adapters/files.h"
#include "cosiva/adapters/thread_pool.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/seed_range.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/experiments/agents/rule_search_report.h"

namespace cosiva::app {
namespace {

Result<experiments::SearchPlan> plan_of(const AgentSearchArguments& arguments) {
  const auto seeds = read_seed_range(arguments.seeds, "--seeds", "agent.seeds");
  if (!seeds) return tl::unexpected<Error>(seeds.error());
  auto rules = load_speed_rules(arguments.rules);
  if (!rules) return tl::unexpected<Error>(rules.error());
  if (rules->kind == aiv::SpeedRules::Kind::crisp)
    return fail("agent.search", "the crisp rules have no numbers to change: state fuzzy or a file", "--rules");
  auto zone = open_zone(arguments.zone);
  if (!zone) return tl::unexpected<Error>(zone.error());
  const bool built_in = rules->kind == aiv::SpeedRules::Kind::fuzzy;
  experiments::SearchPlan plan;
  plan.rtm = std::make_shared<const zone::Rtm>(std::move(*zone));
  plan.fll = built_in ? std::string(aiv::built_in_rules_text()) : std::move(rules->fll);
  plan.origin = built_in ? "rules/agent.fll" : std::move(rules->origin);
  plan.vehicles = arguments.vehicles;
  plan.persons = arguments.persons;
  plan.first_seed = seeds->first;
  plan.last_seed = seeds->last;
  plan.duration = from_seconds(60.0 * arguments.minutes);
  plan.variables = arguments.variables;
  plan.seed = arguments.seed;
  plan.budget = arguments.budget;
  return plan;
}

std::string command_of(const AgentSearchArguments& arguments) {
  std::string variables;
  for (const std::string& name : arguments.variables) variables += (variables.empty() ? " --variables " : ",") + name;
  return "cosiva agent search " + options_text(arguments) + " --seed " + std::to_string(arguments.seed) + " --budget " +
         std::to_string(arguments.budget) + variables + " --out " + arguments.out_folder;
}

}  // namespace

int run_agent_search(const AgentSearchArguments& arguments) {
  const auto plan = plan_of(arguments);
  if (!plan) return report_error(plan.error());
  adapters::ThreadPool pool{arguments.jobs > 0 ? arguments.jobs : std::max(1U, std::thread::hardware_concurrency())};
  const auto result = experiments::search_rules(*plan, pool, [](std::size_t done, std::size_t all, double cost) {
    print_info(std::to_string(done) + " of " + std::to_string(all) + " candidates, lowest cost " + decimals(cost, 4));
  });
  if (!result) return report_error(result.error());
  JsonWriter json;
  write_json(json, *plan, *result);
  if (auto written = adapters::write_files(arguments.out_folder,
                                           {{"agent.fll", result->fll},
                                            {"report.json", json.take() + "\n"},
                                            {"report.html", to_html(*plan, *result, command_of(arguments))}});
      !written)
    return report_error(written.error());
  print("cost " + decimals(result->candidates.front().cost, 4) + " of the initial rules, " +
        decimals(result->candidates[result->best].cost, 4) + " of candidate " +
        std::to_string(result->candidates[result->best].number) + "; written to " + arguments.out_folder);
  return exit_done;
}

}  // namespace cosiva::app
