#pragma once

#include <optional>

#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::zone {

/// Further than this from every way of a new zone, a vehicle is parked: it is given no order.
inline constexpr double snap_within_m = 0.30;

/// What a radian of heading is worth in metres where a vehicle off the line chooses among ways. So small that it only
/// decides where ways cross, meet or run over one another: any heading will do, a vehicle turns on the spot.
inline constexpr double snap_m_per_rad = 0.05;

/// Where a vehicle that stands at X_MB, off the line, goes onto the circuit: of each section within `within_m` its
/// nearest place; of these the one for which distance + snap_m_per_rad · |heading difference| is smallest, the lower
/// section where two are equal. Nothing: no section is that near. The boards, the agent and the server all ask here, so
/// that they agree.
[[nodiscard]] std::optional<Circuit::Located> snap_to_path(const Circuit& circuit, const Pose2& X_MB,
                                                           double within_m = snap_within_m);

}  // namespace cosiva::zone
