#include "cosiva/app/platform/scenario_commands.h"

#include <algorithm>

#include "cosiva/app/cli/console.h"
#include "cosiva/app/resources/resource_paths.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/runs/scenario/scenario_check.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::app {
namespace {

/// Loads a scenario, and checks that it fits its zone.
Result<LoadedScenario> load_checked(const std::string& name_or_file) {
  auto loaded = load_scenario(name_or_file);
  if (!loaded) return loaded;
  const auto rtm = open_zone(loaded->scenario.zone);
  if (!rtm) return tl::unexpected(rtm.error());
  if (auto good = experiments::check(loaded->scenario, rtm->zone(), loaded->file); !good)
    return tl::unexpected(good.error());
  loaded->scenario.zone = rtm->zone().name;  // the zone's name is printed, wherever its file was found
  return loaded;
}

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::string json_of(const LoadedScenario& loaded) {
  const experiments::Scenario& scenario = loaded.scenario;
  JsonWriter json;
  json.begin_object().field("scenario", scenario.name).field("file", loaded.file);
  json.field("description", scenario.description).field("zone", scenario.zone).field("aivs", scenario.aivs);
  json.field("seed", scenario.seed).key("duration_s");
  if (scenario.duration_s)
    json.value(*scenario.duration_s);
  else
    json.null();
  json.key("steps").begin_array();
  for (const auto& step : scenario.steps) {
    json.begin_object().field("t_s", to_seconds(step.at)).field("what", step.what).field("line", step.line);
    json.key("command");
    // A switch command contains a whole file, which is not printed.
    if (step.zone.empty())
      json.raw(step.command);
    else
      json.begin_object().field("command", "switch").field("zone", step.zone).end_object();
    json.end_object();
  }
  json.end_array().end_object();
  return json.take();
}

/// Prints one line for each step, in the order of execution.
std::string timeline(const experiments::Scenario& scenario) {
  std::string text = scenario.name + ": good\n";
  std::string_view rest{scenario.description};
  while (!rest.empty()) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    text.append("  ").append(rest.substr(0, end)).append("\n");
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  text += "  " + std::to_string(scenario.aivs) + (scenario.aivs == 1 ? " AIV on " : " AIVs on ") + scenario.zone +
          ", seed " + std::to_string(scenario.seed) +
          (scenario.duration_s ? ", " + decimals(*scenario.duration_s, 0) + " s" : ", until it is ended");
  for (const auto& step : scenario.steps) {
    text += "\n" + step_line(to_seconds(step.at), step.what);
  }
  return text;
}

}  // namespace

int run_scenario_check(const ScenarioArguments& arguments) {
  const auto loaded = load_checked(arguments.scenario);
  if (!loaded) return report_error(loaded.error());
  print(arguments.json ? json_of(*loaded) : timeline(loaded->scenario));
  return exit_done;
}

int run_scenario_list(const ScenarioArguments& arguments) {
  const std::vector<std::string> names = ready_scenarios();
  std::size_t width = 0;
  for (const std::string& name : names) width = std::max(width, name.size());
  JsonWriter json;
  json.begin_object().key("scenarios").begin_array();
  std::string text;
  for (const std::string& name : names) {
    const auto loaded = load_scenario(name);
    // One bad file does not hide the others.
    const std::string what = loaded ? first_line(loaded->scenario.description) : to_string(loaded.error());
    json.begin_object().field("name", name).field("description", what).field("good", loaded.has_value()).end_object();
    if (!text.empty()) text += '\n';
    text.append(name).append(width - name.size() + 2, ' ').append(what);
  }
  json.end_array().end_object();
  if (arguments.json) {
    print(json.text());
  } else if (names.empty()) {
    print_info("there are no ready scenarios; `cosiva up --scenario FILE` runs a scenario of your own");
  } else {
    print(text);
  }
  return exit_done;
}

}  // namespace cosiva::app
