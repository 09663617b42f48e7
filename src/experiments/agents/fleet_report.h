#pragma once

#include <string>

#include "cosiva/experiments/agents/fleet_comparison.h"

namespace cosiva::experiments {

/// One HTML page: each quantity of each case with its interval, the violations (violations_of), and the command.
/// @param command  that repeats the measurement
[[nodiscard]] std::string to_html(const FleetPlan& plan, const FleetComparison& comparison, double fewer_stops_percent,
                                  const std::string& command);

}  // namespace cosiva::experiments
