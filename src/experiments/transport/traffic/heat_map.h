#pragma once

#include <string>

#include "cosiva/experiments/transport/traffic/metrics.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// Draws the circuit as SVG, y up: each cell in the colour of the ratio of time that a vehicle was stopped in it
/// without having arrived (`standing`), or of the ratio of time that the cell was occupied.
/// @param metrics  its `cells` by section
[[nodiscard]] std::string heat_map(const zone::TrafficZone& zone, const TrafficMetrics& metrics, bool stopped);

}  // namespace cosiva::experiments
