#pragma once

#include <string>

#include "cosiva/experiments/transport/traffic/metrics.h"
#include "cosiva/experiments/transport/traffic/traffic.h"

namespace cosiva::experiments {

/// Writes the run as one HTML page: metrics, heat maps, curves, tables, and the command that reproduces it.
/// @param command  as given
[[nodiscard]] std::string to_html(const zone::TrafficZone& zone, const TrafficMetrics& metrics,
                                  const std::string& command);
/// "due_s,from,to,priority,vehicle,given_s,fetched_s,done_s", a line per job that was due; empty: not yet.
[[nodiscard]] std::string jobs_csv(const zone::TrafficZone& zone, const Dispatcher& dispatcher, double until_s);

}  // namespace cosiva::experiments
