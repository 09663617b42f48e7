#pragma once

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

/// The minimum distance along an arc, in metres, between the body origins of two vehicles whose bodies do not touch:
/// 2R·atan(L / (2R − W)), because in a bend the inner corners are nearer to each other than on a straight. The length L
/// of the vehicle if the curvature is 0. @param curvature_per_m  1/R ≥ 0, less than 2/W
[[nodiscard]] double bodies_apart_m(const zone::VehicleShape& shape, double curvature_per_m);

/// Arc length that one vehicle occupies in this zone, in metres: its length, or more if the zone has a bend so tight
/// that inner corners would be less than a centimetre apart. Two vehicles whose body origins are this and
/// aiv::clearance_m apart do not touch anywhere in the zone.
[[nodiscard]] double occupied_m(const zone::TrafficZone& zone);

}  // namespace cosiva::virtual_side
