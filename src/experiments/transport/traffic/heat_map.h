#pragma once

#include <string>

#include "cosiva/experiments/transport/traffic/metrics.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// The circuit as it is driven, as SVG, y up: each cell in the colour of how much of the time a vehicle stood in it
/// that had not arrived (`standing`), or of how much it was taken at all.
/// @param figures  its `cells` by section
[[nodiscard]] std::string heat_map(const zone::TrafficZone& zone, const TrafficMetrics& metrics, bool stopped);

}  // namespace cosiva::experiments
