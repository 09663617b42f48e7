#include "cosiva/virtual/server/missions/mission.h"

#include <algorithm>
#include <cmath>

namespace cosiva::virtual_side {
namespace {

/// Maximum distance between a station and its waypoint, which is rounded.
constexpr double station_m = 0.02;

}  // namespace

std::vector<WaypointIndex> goals_of(const WaypointGraph& map, std::string_view name) {
  std::vector<WaypointIndex> found;
  std::string_view id = name;
  if (const zone::Station* station = map.zone().find_station(name)) {
    const auto& waypoints = map.zone().waypoints;
    const auto section_of = [](const zone::Waypoint& waypoint) { return waypoint.position.section; };
    WaypointIndex nearest = no_waypoint;
    double off_m = station_m;
    auto it = std::ranges::lower_bound(waypoints, station->position.section, {}, section_of);
    for (; it != waypoints.end() && it->position.section == station->position.section; ++it) {
      const double here_m = std::fabs(it->position.s_m - station->position.s_m);
      if (here_m > off_m) continue;
      nearest = static_cast<WaypointIndex>(it - waypoints.begin());
      off_m = here_m;
    }
    if (nearest == no_waypoint) return found;
    id = map.waypoint(nearest).id;
  }
  const auto all = map.find(id);
  found.assign(all.begin(), all.end());
  return found;
}

const zone::Loop* loop_of(const WaypointGraph& map, const Mission& mission) {
  const auto& loops = map.zone().loops;
  if (mission.name.empty()) return loops.empty() ? nullptr : &loops.front();
  return map.zone().find_loop(mission.name);
}

bool is_known(const WaypointGraph& map, const Mission& mission) {
  if (mission.kind == Mission::Kind::go) return !goals_of(map, mission.name).empty();
  return mission.name.empty() || map.zone().find_loop(mission.name) != nullptr;
}

}  // namespace cosiva::virtual_side
