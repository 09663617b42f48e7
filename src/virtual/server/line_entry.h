#pragma once

#include "base/pose.h"
#include "zone/traffic_zone.h"

namespace cosiva::virtual_side {

/// How a vehicle that stands beside the line goes onto it: it turns on the spot, drives straight, turns again. What it
/// sweeps is a capsule, half its diagonal wide.
struct LineEntry {
  Point2 from;
  Point2 to;
};
/// Whether a vehicle that stands at X_MB is touched by it, or nearly.
[[nodiscard]] bool near_body(const LineEntry& entry, const zone::VehicleShape& shape, const Pose2& X_MB);
/// Whether two of them touch, or nearly.
[[nodiscard]] bool near_entry(const LineEntry& a, const zone::VehicleShape& shape, const LineEntry& b);

}  // namespace cosiva::virtual_side
