#pragma once

#include "cosiva/aiv/decision/agent.h"
#include "cosiva/aiv/order/crossing_finder.h"
#include "cosiva/wire/own/v2x.h"

namespace cosiva::aiv {

/// So far ahead a vehicle says which crossings it comes to.
inline constexpr double intent_reach_m = 3.0;

/// The shortest time in which a vehicle comes so far, from its speed now and speeding up as `by` says [s].
/// @param by  its speed is positive, as its acceleration
[[nodiscard]] double earliest_s(double distance_m, double speed_mps, const zone::SpeedProfile& by);

/// What the vehicle has to say of itself now, but for header and identity. Lengths and times are rounded to
/// thousandths. Only for one whose pose is known. One that is held or has no order names the crossings that are its own
/// already, and wants none.
[[nodiscard]] wire::Intent compose_intent(const Agent& agent, const zone::TrafficZone& zone,
                                          const CrossingFinder& crossing_spans);

/// Whether compose_intent would say something else now that others act upon at once: whether it brakes, its map,
/// whether it is on a line, and which crossings it comes to or may enter. Asked fifty times a second, so it composes
/// nothing.
[[nodiscard]] bool is_news(const wire::Intent& published, const Agent& agent, const zone::TrafficZone& zone,
                           const CrossingFinder& crossing_spans);

}  // namespace cosiva::aiv
