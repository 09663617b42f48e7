#include "cosiva/app/platform/run_plan.h"

#include <algorithm>
#include <filesystem>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/platform/direct_link.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/app/resources/rule_files.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/experiments/runs/scenario/scenario_check.h"

namespace cosiva::app {
namespace {

std::string absolute(const std::string& file) {
  std::error_code error;
  const std::filesystem::path path = std::filesystem::absolute(file, error);
  return error ? file : path.lexically_normal().string();
}

void report_precedence(const std::string& what, const std::string& given, const std::string& scenario_s) {
  if (given != scenario_s) print_info("--" + what + " " + given + " overrides the scenario's " + scenario_s);
}

/// The scenario's value is used where the command line has none.
void merge(UpArguments& arguments, const experiments::Scenario& scenario) {
  const UpArguments::Given& given = arguments.given;
  if (given.zone)
    report_precedence("zone", arguments.zone, scenario.zone);
  else
    arguments.zone = scenario.zone;
  if (given.aivs)
    report_precedence("aivs", std::to_string(arguments.aivs), std::to_string(scenario.aivs));
  else
    arguments.aivs = scenario.aivs;
  if (given.seed)
    report_precedence("seed", std::to_string(arguments.seed), std::to_string(scenario.seed));
  else
    arguments.seed = scenario.seed;
  if (given.duration && scenario.duration_s)
    report_precedence("duration", decimals(*arguments.duration_s, 1) + " s", decimals(*scenario.duration_s, 1) + " s");
  else if (!given.duration)
    arguments.duration_s = scenario.duration_s;
  if (!given.crossing_units) arguments.crossing_units = scenario.crossing_units;
}

/// Each unit is a process.
constexpr std::size_t units_max = 64;

Result<std::vector<experiments::WorldUnit>> units_of(const UpArguments& arguments,
                                                     const std::optional<experiments::Scenario>& scenario,
                                                     const zone::TrafficZone& zone) {
  std::vector<experiments::WorldUnit> units;
  const auto add = [&](const std::string& crossing, bool off) {
    if (std::ranges::find(units, crossing, &experiments::WorldUnit::crossing) == units.end())
      units.push_back({crossing, off});
  };
  std::string names;
  for (const zone::Crossing& one : zone.crossings) names.append(names.empty() ? "" : ", ").append(one.name);
  for (const std::string& given : arguments.crossing_units) {
    const bool known = std::ranges::find(zone.crossings, given, &zone::Crossing::name) != zone.crossings.end();
    if (given != "all" && !known)
      return fail("up.crossing_units",
                  zone.name + " has no crossing '" + given + "'; " +
                      (names.empty() ? "it has none at all" : "give all, or one of " + names),
                  "--crossing-units");
    for (const zone::Crossing& one : zone.crossings)
      if (given == "all" || given == one.name) add(one.name, false);
  }
  if (scenario)
    for (const std::string& crossing : scenario->switched_units) add(crossing, true);
  if (units.size() > units_max)
    return fail("up.crossing_units",
                "at most " + std::to_string(units_max) + " units can be started, not " + std::to_string(units.size()) +
                    "; name the crossings that need one",
                "--crossing-units");
  return units;
}

}  // namespace

Result<RunPlan> plan_run(const UpArguments& arguments) {
  UpArguments merged = arguments;
  std::optional<experiments::Scenario> scenario;
  std::string scenario_file;
  if (!arguments.scenario.empty()) {
    auto loaded = load_scenario(arguments.scenario);
    if (!loaded) return tl::unexpected(loaded.error());
    merge(merged, loaded->scenario);
    scenario_file = absolute(loaded->file);
    scenario = std::move(loaded->scenario);
  }

  // Each vehicle opens the link; a bad key is reported here, once.
  if (const auto direct = direct_link_options(merged.direct, {}); !direct) return tl::unexpected(direct.error());
  if (!merged.direct.multicast.empty() && !merged.v2x)
    return fail("up.v2x", "is off, and a direct link carries V2X messages only", "--v2x");

  std::optional<aiv::SpeedRules> rules;
  if (!merged.rules.empty()) {
    auto loaded = load_speed_rules(merged.rules);
    if (!loaded) return tl::unexpected(loaded.error());
    rules = std::move(*loaded);
  }

  auto configuration = load_zone(merged.zone);
  if (!configuration) return tl::unexpected(configuration.error());
  configuration->origin = absolute(configuration->origin);
  auto rtm = zone::Rtm::initialise(std::move(*configuration));
  if (!rtm) return tl::unexpected(rtm.error());
  if (const std::size_t room = rtm->zone().start_positions(merged.aivs).size(); room < merged.aivs) {
    return fail("up.aivs",
                "this zone has room for " + std::to_string(room) + " AIVs to start, not " + std::to_string(merged.aivs),
                "--aivs");
  }
  auto equipment = physical::read_equipment(merged.aivs, merged.line_tracking, merged.without_rali);
  if (!equipment) return tl::unexpected(equipment.error());
  auto units = units_of(merged, scenario, rtm->zone());
  if (!units) return tl::unexpected(units.error());
  if (!units->empty() && !merged.v2x)
    return fail("up.v2x", "is off, and crossing units receive V2X messages only", "--v2x");
  if (scenario) {
    // The scenario is validated as it will run. A run that the command line shortens is no error of the file.
    experiments::Scenario evaluated = *scenario;
    evaluated.aivs = merged.aivs;
    if (merged.given.duration) evaluated.duration_s.reset();
    if (auto good = experiments::check(evaluated, rtm->zone(), scenario_file); !good)
      return tl::unexpected(good.error());
  }

  if (const std::string own = own_folder("zones");
      !is_like_a_file(merged.zone) && !own.empty() && rtm->configuration().origin.starts_with(own + "/"))
    print_info("the zone " + merged.zone + " is your own: " + rtm->configuration().origin);
  std::string name = merged.name.empty() ? default_run_name(scenario ? scenario->name : rtm->zone().name) : merged.name;
  std::string zone_file = is_like_a_file(merged.zone) ? rtm->configuration().origin : std::string{};
  return RunPlan{std::move(merged),   std::move(name),          std::move(*rtm),
                 std::move(scenario), std::move(scenario_file), std::move(zone_file),
                 std::move(rules),    std::move(*equipment),    std::move(*units)};
}

}  // namespace cosiva::app
