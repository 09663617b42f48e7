#pragma once

#include <cmath>

#include "cosiva/base/math_inline.h"
#include "cosiva/zone/layout/traffic_zone.h"

/// The arithmetic of the agent and the envelope, number by number and without branches: the agent of one vehicle calls
/// a function for one result, and a pass over a whole fleet (virtual/fleet) becomes vector instructions. No decision is
/// computed anywhere else.
namespace cosiva::aiv {

/// Delay until the wheels obey a command: the tick of the on-board program, the board's cycle, and the age of the
/// odometry.
inline constexpr double reaction_s = 0.08;
/// An obstacle is accepted at its second frame out of three, 60 ms apart.
inline constexpr double obstacle_reaction_s = 0.15;
/// Distance from the stop line at standstill: the stopping accuracy, so that not even an overshoot enters the crossing.
inline constexpr double stop_line_m = 0.01;
/// Clearance between the front of a vehicle and the obstacle ahead of it.
inline constexpr double clearance_m = 0.12;
/// A vehicle below this speed counts as stopped.
inline constexpr double stopped_mps = 0.01;
/// Value of a rule input that is absent: no instruction.
inline constexpr double no_instruction = 4.0;

namespace plain {

/// stoppable_speed (speed.h) for finite numbers, braking and reaction above 0: the positive root of v²/(2b) + t·v − d,
/// written without the difference of two nearly equal numbers.
[[nodiscard]] COSIVA_INLINE double stoppable_speed(double distance_m, double braking_mps2, double late_s) noexcept {
  const double d = distance_m > 0.0 ? distance_m : 0.0;
  return 2.0 * d / (late_s + std::sqrt(late_s * late_s + 2.0 * d / braking_mps2));
}

/// Highest speed now that reaches a position `ahead_m` away at no more than `limit_mps`.
[[nodiscard]] COSIVA_INLINE double speed_before(double limit_mps, double ahead_m, double braking_mps2) noexcept {
  const double path_distance_m = ahead_m - limit_mps * reaction_s;
  const double d_m = path_distance_m > 0.0 ? path_distance_m : 0.0;
  return std::sqrt(limit_mps * limit_mps + 2.0 * braking_mps2 * d_m);
}

/// Whether `braking_mps2` no longer suffices to stop within `path_distance_m`; the vehicle then brakes as hard as
/// possible.
[[nodiscard]] COSIVA_INLINE bool brakes_hard(double speed_mps, double path_distance_m, double braking_mps2) noexcept {
  const double d_m = path_distance_m > 0.0 ? path_distance_m : 0.0;
  return speed_mps * speed_mps > 2.0 * braking_mps2 * d_m;
}

/// The rules' `gap`: the distance that remains before the vehicle has to stop, in braking distances (agent_rules.h).
[[nodiscard]] COSIVA_INLINE double gap_input(double obstacle_ahead_m, double braking_distance_m) noexcept {
  return (obstacle_ahead_m - clearance_m) / braking_distance_m;
}
/// The rules' `base` and `crossing`.
[[nodiscard]] COSIVA_INLINE double path_input(double path_distance_m, double braking_distance_m) noexcept {
  return path_distance_m / braking_distance_m;
}
/// The rules' `closing`.
[[nodiscard]] COSIVA_INLINE double closing_input(double closing_mps, double medium_mps) noexcept {
  return 100.0 * closing_mps / medium_mps;
}

/// nearest_profile (agent_rules.h), profiles as numbers 0…3.
/// @param present  below 0: none
[[nodiscard]] COSIVA_INLINE double nearest_profile(double speed, double present) noexcept {
  // A result nearer than this to the present profile keeps the present profile; the next profile begins at a half.
  constexpr double stays_within = 0.7;
  const double low = speed < 0.5 ? 0.0 : 1.0;
  const double high = speed < 2.5 ? 2.0 : 3.0;
  const double nearest = speed < 1.5 ? low : high;
  return ((present >= 0.0) & (std::fabs(speed - present) < stays_within)) ? present : nearest;
}

/// The choice of the crisp rules among the moving profiles, as a number; the stop at the end of the base and an
/// instruction take precedence. Distant obstacles are followed at the profile's own speed; near obstacles and a low
/// charge select the slow profile.
[[nodiscard]] COSIVA_INLINE double crisp_profile(double charge, double obstacle_ahead_m) noexcept {
  constexpr double near_m = 0.35;
  constexpr double low_charge = 0.10;
  return ((charge < low_charge) | (obstacle_ahead_m < near_m)) ? 1.0 : 2.0;
}

/// The rate of a manoeuvre's leg after the next step, from which the leg can still stop in time: rate·dt + rate²/2a =
/// left (Manoeuvre::step).
[[nodiscard]] COSIVA_INLINE double manoeuvre_rate(double rate, double most, double left, double per_s2,
                                                  double dt_s) noexcept {
  const double in_time = per_s2 * (std::sqrt(dt_s * dt_s + 2.0 * left / per_s2) - dt_s);
  const double change = most - rate;
  const double up = change > per_s2 * dt_s ? per_s2 * dt_s : change;
  const double next = rate + (up < -per_s2 * dt_s ? -per_s2 * dt_s : up);
  return in_time < next ? in_time : next;
}

}  // namespace plain
}  // namespace cosiva::aiv
