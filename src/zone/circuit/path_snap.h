#pragma once

#include <optional>

#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::zone {

/// Further than this from every section of a new zone, a vehicle is off-route: it is given no order.
inline constexpr double snap_within_m = 0.30;

/// The weight of a radian of heading in metres where an off-path vehicle chooses among sections. So small that it only
/// decides where sections cross, meet or overlap: any heading will do, a vehicle turns on the spot.
inline constexpr double snap_m_per_rad = 0.05;

/// The position where a vehicle that is stopped at X_MB, off-path, enters the circuit: of each section within
/// `within_m` its nearest position; of these the one for which distance + snap_m_per_rad · |heading difference| is
/// smallest, the lower section where two are equal. Nothing: no section is that near. The boards, the agent and the
/// server all call this function, so that they agree.
[[nodiscard]] std::optional<Circuit::Located> snap_to_path(const Circuit& circuit, const Pose2& X_MB,
                                                           double within_m = snap_within_m);

}  // namespace cosiva::zone
