#pragma once

#include <cstdint>
#include <optional>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// A grid that passes through `through`, turned by `rotation_rad`, and covers every section and half a vehicle on each
/// side of it. Nothing when that takes more than `beacons_max` beacons.
[[nodiscard]] std::optional<BeaconGrid> covering_grid(const Circuit& circuit, const VehicleShape& shape, double pitch_m,
                                                      Point2 through, std::uint32_t beacons_max,
                                                      double rotation_rad = 0.0);

}  // namespace cosiva::zone
