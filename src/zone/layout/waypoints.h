#pragma once

#include <string>
#include <vector>

#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// Waypoints at joints, at each crossing's stop line and exit, and between them no further apart than `spacing_m`, none
/// inside a crossing's span. Ids are "<section>@<millimetres>", stable as long as the geometry is.
/// @param room_m  where the free path between two spans is shorter than this a vehicle cannot stop, so no waypoint lies
[[nodiscard]] std::vector<Waypoint> lay_waypoints(const Circuit& circuit, const std::vector<Crossing>& crossings,
                                                  double spacing_m = 0.30, double room_m = 0.30);

/// Waypoints in addition to those that follow from the geometry.
struct WaypointRules {
  double spacing_m{0.30};
  double room_m{0.30};
  bool nodes_only{false};  ///< none between those of joints, dead ends, stop lines, exits and `at`
  /// One lies at each of these in any case, inside crossings too; a waypoint nearer than 2 cm on the same section
  /// serves.
  std::vector<TrackPosition> at{};
  /// By section: the id of the waypoint at its start, which exists in any case. Empty: no id of its own. The vector may
  /// be empty, too.
  std::vector<std::string> start_ids{};
  /// By section: likewise at its end, of sections without successor.
  std::vector<std::string> end_ids{};
};
/// Sorted by (section, s). Ids of `start_ids` and `end_ids` may occur several times; all others are
/// "<section>@<millimetres>".
[[nodiscard]] std::vector<Waypoint> lay_waypoints(const Circuit& circuit, const std::vector<Crossing>& crossings,
                                                  const WaypointRules& rules);

/// A waypoint of the zone lies at this position, or at most 2 cm from it on the same section.
[[nodiscard]] bool is_at_waypoint(const TrafficZone& zone, TrackPosition position);

}  // namespace cosiva::zone
