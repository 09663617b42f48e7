#pragma once

#include "cosiva/app/agent/fleet_arguments.h"

/// `cosiva agent measure`.
namespace cosiva::app {

/// Compares a rule file with the crisp rules. 0: no fewer laps, no more stops, no collision; 1: one of them does not
/// hold; 2: bad input.
[[nodiscard]] int run_agent_measure(const AgentMeasureArguments& arguments);

}  // namespace cosiva::app
