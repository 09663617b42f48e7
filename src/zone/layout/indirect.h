#pragma once

#include "cosiva/zone/layout/traffic_zone.h"
#include "cosiva/zone/layout/waypoints.h"

namespace cosiva::zone {

/// Makes a zone one whose vehicles travel in indirect direction (A32): the circuit becomes the reversed one, and what
/// the format has laid on it stays at its points. To be called before crossings and waypoints are found, which depend
/// on the direction.
/// @param zone   not indirect yet; its crossings, waypoints, tags and starts are empty
/// @param rules  the format's; the ids at the ends of a section change their ends with it
void make_indirect(TrafficZone& zone, WaypointRules& rules);

}  // namespace cosiva::zone
