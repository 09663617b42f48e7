#pragma once

#include <string>

#include "cosiva/experiments/transport/traffic/metrics.h"
#include "cosiva/experiments/transport/traffic/traffic.h"

namespace cosiva::experiments {

/// The run as one HTML page: figures, heat maps, curves, tables, and how to do it again.
/// @param command  as it was given
[[nodiscard]] std::string to_html(const zone::TrafficZone& zone, const TrafficMetrics& metrics,
                                  const std::string& command);
/// "due_s,from,to,priority,vehicle,given_s,fetched_s,done_s", a line per job that was due; empty: not yet.
[[nodiscard]] std::string jobs_csv(const zone::TrafficZone& zone, const Dispatcher& dispatcher, double until_s);

}  // namespace cosiva::experiments
