#pragma once

#include "cosiva/aiv/estimation/algorithm.h"
#include "cosiva/aiv/estimation/track.h"
#include "cosiva/base/pose.h"

namespace cosiva::estimation {

/// The estimated pose X_MB at the end of a move (A33, A35: nextEstimatedPosition): the present estimate, moved by the
/// distance along the track, with its lateral offset and heading error. Straight on where there is no track, or where
/// the estimate is too far from it.
/// @param track    null: the vehicle follows none
/// @param near_m   arc length at which the vehicle is approximately, for an estimate that states none [m]
/// @param move_m   distance of the move, not negative [m]
[[nodiscard]] Pose2 next_position(const Estimate& estimate, const Track* track, double near_m, double move_m);

}  // namespace cosiva::estimation
