#pragma once

#include "cosiva/wire/messages/board.h"

/// The travel frame of a vehicle in indirect direction (A32): its body frame turned by π, so that its x axis is the
/// direction of travel. Boards measure and act in the body frame. Each function is its own inverse.
namespace cosiva::wire {

[[nodiscard]] Manoeuvre turned_round(const Manoeuvre& manoeuvre);
[[nodiscard]] Odometry turned_round(const Odometry& odometry);
[[nodiscard]] Drive turned_round(const Drive& drive);
/// The bearings stay within one turn: the fan of a sensor at the rear points forwards in the travel frame.
[[nodiscard]] Ranges turned_round(const Ranges& ranges);

/// Whether a fan points forwards in its frame: its centre is within a right angle of the x axis.
[[nodiscard]] bool points_forwards(const Ranges& ranges);

}  // namespace cosiva::wire
