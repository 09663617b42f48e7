#pragma once

#include <string>

namespace cosiva::app {

/// The options of `cosiva scenario`.
struct ScenarioArguments {
  std::string scenario;
  bool json{false};
};

/// `cosiva scenario check`: checks a scenario, and prints its steps. Gives the exit status: 0 done, 1 the run's own
/// checks failed, 2 bad usage or bad input.
int run_scenario_check(const ScenarioArguments& arguments);
/// `cosiva scenario list`: lists the ready scenarios. Gives the exit status as run_scenario_check does.
int run_scenario_list(const ScenarioArguments& arguments);

}  // namespace cosiva::app
