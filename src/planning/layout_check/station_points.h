#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "cosiva/planning/track/track_floor.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::planning {

/// One point with stations, and the states in which vehicles arrive there.
struct StationPoint {
  std::vector<std::size_t> stations;  ///< indices into the zone's
  std::vector<StateId> states;
  std::vector<CellId> cells;  ///< of a body in any of these states, ascending
};

inline constexpr std::size_t no_point = std::numeric_limits<std::size_t>::max();

/// The stations of a zone that a move leads to, those at one point as one point, in the order of the stations.
[[nodiscard]] std::vector<StationPoint> station_points(const zone::TrafficZone& zone, const TrackFloor& tracks);

}  // namespace cosiva::planning
