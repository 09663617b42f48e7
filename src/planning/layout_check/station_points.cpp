#include "cosiva/planning/layout_check/station_points.h"

#include <algorithm>
#include <map>
#include <utility>

namespace cosiva::planning {

std::vector<StationPoint> station_points(const zone::TrafficZone& zone, const TrackFloor& tracks) {
  const Floor& floor = tracks.floor();
  std::vector<StationPoint> points;
  std::map<StateId, std::size_t> by_state;
  for (std::size_t station = 0; station < zone.stations.size(); ++station) {
    const auto goal = tracks.goal(zone.stations[station].name);
    if (!goal) continue;
    std::vector<StateId> states;
    for (const StateId state : floor.goal(*goal))
      if (!floor.predecessors(state).empty()) states.push_back(state);
    if (states.empty()) continue;
    const auto known = std::ranges::find_if(states, [&](StateId state) { return by_state.contains(state); });
    if (known != states.end()) {
      points[by_state[*known]].stations.push_back(station);
      continue;
    }
    for (const StateId state : states) by_state[state] = points.size();
    StationPoint point{{station}, std::move(states), {}};
    for (const StateId state : point.states)
      point.cells.insert(point.cells.end(), floor.footprint(state).begin(), floor.footprint(state).end());
    std::ranges::sort(point.cells);
    point.cells.erase(std::unique(point.cells.begin(), point.cells.end()), point.cells.end());
    points.push_back(std::move(point));
  }
  return points;
}

}  // namespace cosiva::planning
