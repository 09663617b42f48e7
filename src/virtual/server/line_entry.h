#pragma once

#include "base/pose.h"
#include "zone/traffic_zone.h"

namespace cosiva::virtual_side {

/// How a vehicle that stands beside the line goes onto it: it turns on the spot, drives straight, turns again
/// (aiv::Manoeuvre), `to` being where it is then, along the line.
struct LineEntry {
  Pose2 from;
  Pose2 to;
};
/// What stays free on all sides of a body that goes onto the line; it covers what reports are wrong by.
inline constexpr double entry_clear_m = 0.02;

/// Whether a vehicle that stands at X_MB is touched on the way, or nearly: body against body, all along. Where it is
/// not sure which way round the vehicle will turn, as it stands almost on the line or with its back to it, both count.
[[nodiscard]] bool near_body(const LineEntry& entry, const zone::VehicleShape& shape, const Pose2& X_MB,
                             double clear_m = entry_clear_m);
/// Whether what two of them sweep may touch, whenever they go: half a diagonal about the way of their middles.
[[nodiscard]] bool near_entry(const LineEntry& a, const zone::VehicleShape& shape, const LineEntry& b);

}  // namespace cosiva::virtual_side
