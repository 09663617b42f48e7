#pragma once

#include "cosiva/aiv/decision/agent.h"
#include "cosiva/aiv/order/crossing_finder.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/own/v2x.h"

namespace cosiva::aiv {

/// Distance ahead within which a vehicle lists the crossings that it approaches.
inline constexpr double intent_reach_m = 3.0;

/// The shortest time in which a vehicle covers the distance, from its present speed and with the acceleration of `by`
/// [s].
/// @param by  its speed and its acceleration are positive
[[nodiscard]] double earliest_s(double distance_m, double speed_mps, const zone::SpeedProfile& by);

/// The vehicle's present intent, without header and identity. Lengths and times are rounded to thousandths. The
/// vehicle's pose must be known. A vehicle that is held or has no order lists the crossings that are already its own,
/// and requests none.
[[nodiscard]] wire::Intent compose_intent(const Agent& agent, const zone::TrafficZone& zone,
                                          const CrossingFinder& crossing_spans);

/// Whether compose_intent would now differ from `said` in what other vehicles react to at once: whether the vehicle
/// brakes, its map, whether it is on the path, and which crossings it approaches or may enter. The function is called
/// fifty times a second and therefore composes nothing.
[[nodiscard]] bool is_news(const wire::Intent& published, const Agent& agent, const zone::TrafficZone& zone,
                           const CrossingFinder& crossing_spans);

/// The body of the sender, whose vehicle is of this zone, and its motion.
[[nodiscard]] wire::Body body_of(const wire::Intent& intent, const zone::VehicleShape& shape);

}  // namespace cosiva::aiv
