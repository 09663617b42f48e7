#include "cosiva/planning/layout_check/well_formed.h"

#include <algorithm>
#include <iterator>
#include <span>
#include <utility>

#include "cosiva/base/components.h"
#include "cosiva/base/expect.h"
#include "cosiva/planning/layout_check/reach.h"
#include "cosiva/planning/layout_check/station_points.h"

namespace cosiva::planning {

/// Fills the findings. Invariant: `point_of_` names for each state the point that it belongs to.
class WellFormed::Search {
 public:
  Search(const zone::TrafficZone& zone, WellFormed& found);

  void run(const WellFormedLimits& limits);

 private:
  using Move = std::pair<StateId, StateId>;

  void index_cells();
  void find_exits();
  void find_groups();
  void find_others();
  void find_cuts(std::size_t point);
  [[nodiscard]] bool may_part(StateId state, std::size_t point);
  [[nodiscard]] bool is_reached(StateId state) const;
  [[nodiscard]] bool add_exits(StateId state, std::vector<StateId>& states) const;
  [[nodiscard]] std::optional<std::vector<StateId>> boundary(StateId state) const;
  [[nodiscard]] bool occupies_another(StateId state, std::size_t point) const;
  [[nodiscard]] std::vector<std::size_t> cut_off_by(std::size_t point);
  [[nodiscard]] std::vector<std::size_t> parted(std::size_t group, std::size_t point);
  void find_obstructed();
  [[nodiscard]] StrongComponents open_parts() const;
  [[nodiscard]] std::vector<std::uint32_t> parts_at_first(const StrongComponents& parts);
  [[nodiscard]] std::optional<std::size_t> first_off(std::span<const StateId> part);
  [[nodiscard]] static bool both(const StationPoint& point, const Reach::Reached& a, const Reach::Reached& b) {
    return std::ranges::any_of(point.states, [&](StateId state) { return a[state] != 0 && b[state] != 0; });
  }

  WellFormed& found_;
  TrackFloor tracks_;
  Floor floor_;  // without what is closed
  std::vector<StationPoint> points_;
  Reach reach_;
  std::vector<std::size_t> point_of_;              // by state
  std::vector<std::vector<StateId>> states_on_;    // by cell
  std::vector<std::vector<Move>> moves_over_;      // by cell that they sweep
  std::vector<std::size_t> group_;                 // by point: those that can all be reached from each other
  std::vector<std::vector<std::size_t>> members_;  // by group
};

WellFormed::Search::Search(const zone::TrafficZone& zone, WellFormed& found)
    : found_{found},
      tracks_{TrackFloor::make(zone)},
      floor_{tracks_.floor().without({{}, tracks_.moves_into(zone.closed)})},
      points_{station_points(zone, tracks_)},
      reach_{floor_},
      point_of_(floor_.states(), no_point),
      states_on_(floor_.cells()),
      moves_over_(floor_.cells()),
      group_(points_.size(), no_point) {
  for (std::size_t point = 0; point < points_.size(); ++point) {
    for (const StateId state : points_[point].states) {
      COSIVA_EXPECT(point_of_[state] == no_point);
      point_of_[state] = point;
    }
    for (const std::size_t station : points_[point].stations) found_.stations_[station].is_entered = true;
  }
  index_cells();
}

void WellFormed::Search::index_cells() {
  for (StateId state = 0; state < floor_.states(); ++state) {
    for (const CellId cell : floor_.footprint(state)) states_on_[cell].push_back(state);
    if (!floor_.has_sweeps()) continue;
    const auto next = floor_.successors(state);
    for (std::size_t move = 0; move < next.size(); ++move)
      for (const CellId cell : floor_.sweep(state, move)) moves_over_[cell].emplace_back(state, next[move]);
  }
}

/// A vehicle that reaches a round trip can go on for ever.
void WellFormed::Search::find_exits() {
  StrongComponents components;
  components.find(floor_.states(), [&](StateId state) { return floor_.successors(state); });
  std::vector<StateId> round;
  for (StateId state = 0; state < floor_.states(); ++state)
    if (components.members(components.component_of(state)).size() > 1) round.push_back(state);
  const Reach::Reached& goes_on = reach_.to(round);
  for (const StationPoint& point : points_) {
    const bool is_left = std::ranges::any_of(point.states, [&](StateId state) { return goes_on[state] != 0; });
    for (const std::size_t station : point.stations) found_.stations_[station].is_left = is_left;
  }
}

void WellFormed::Search::find_groups() {
  for (std::size_t first = 0; first < points_.size(); ++first) {
    if (group_[first] != no_point) continue;
    const std::size_t group = members_.size();
    group_[first] = group;
    members_.push_back({first});
    const Reach::Reached& there = reach_.from(points_[first].states);
    const Reach::Reached& back = reach_.to(points_[first].states);
    for (std::size_t other = first + 1; other < points_.size(); ++other) {
      if (group_[other] != no_point || !both(points_[other], there, back)) continue;
      group_[other] = group;
      members_[group].push_back(other);
    }
  }
}

void WellFormed::Search::find_others() {
  for (std::size_t i = 0; i < points_.size(); ++i) {
    bool another = members_[group_[i]].size() > 1;
    if (!another) {
      const Reach::Reached& reached = reach_.from(points_[i].states);
      for (StateId state = 0; state < floor_.states() && !another; ++state)
        another = reached[state] != 0 && point_of_[state] != no_point && point_of_[state] != i;
    }
    for (const std::size_t station : points_[i].stations) {
      Finding& finding = found_.stations_[station];
      finding.is_left = finding.is_left || another;
      finding.reaches_another = another || points_[i].stations.size() > 1;
    }
  }
}

// --- what one stopped vehicle parts ---------------------------------------------------------------------------------

/// A move from a free state leads there.
bool WellFormed::Search::is_reached(StateId state) const {
  return std::ranges::any_of(floor_.predecessors(state),
                             [&](StateId before) { return reach_.is_free(before) && reach_.is_open(before, state); });
}

/// Adds states by which a route goes on that has led through occupied cells to `state`. False: there are none at the
/// station's point there.
bool WellFormed::Search::add_exits(StateId state, std::vector<StateId>& states) const {
  if (!reach_.is_free(state)) return true;
  if (is_reached(state)) {
    states.push_back(state);
    return true;
  }
  // A vehicle arrives in this state from occupied cells alone; one that is led round them arrives in others.
  for (const StateId next : floor_.successors(state))
    if (reach_.is_free(next) && reach_.is_open(state, next)) states.push_back(next);
  if (point_of_[state] == no_point) return true;
  const std::size_t before = states.size();
  std::ranges::copy_if(points_[point_of_[state]].states, std::back_inserter(states),
                       [&](StateId other) { return reach_.is_free(other) && is_reached(other); });
  return states.size() > before;
}

/// The free states at which routes enter or leave what a body in this state obstructs, with its cells occupied.
/// Nothing: a station there cannot be reached.
std::optional<std::vector<StateId>> WellFormed::Search::boundary(StateId state) const {
  std::vector<StateId> states;
  bool is_complete = true;
  const auto add_entry = [&](StateId from) {
    if (reach_.is_free(from) && is_reached(from)) states.push_back(from);
  };
  const auto add_exit = [&](StateId to) { is_complete = add_exits(to, states) && is_complete; };
  for (const CellId cell : floor_.footprint(state)) {
    for (const StateId occupied : states_on_[cell]) {
      std::ranges::for_each(floor_.predecessors(occupied), add_entry);
      std::ranges::for_each(floor_.successors(occupied), add_exit);
    }
    for (const auto& [from, to] : moves_over_[cell]) {
      add_entry(from);
      add_exit(to);
    }
  }
  if (!is_complete) return std::nullopt;
  std::ranges::sort(states);
  states.erase(std::unique(states.begin(), states.end()), states.end());
  return states;
}

bool WellFormed::Search::occupies_another(StateId state, std::size_t point) const {
  return std::ranges::any_of(floor_.footprint(state), [&](CellId cell) {
    return std::ranges::any_of(
        states_on_[cell], [&](StateId other) { return point_of_[other] != no_point && point_of_[other] != point; });
  });
}

/// False: wherever a route is obstructed there is another one nearby, so that nothing is parted.
bool WellFormed::Search::may_part(StateId state, std::size_t point) {
  if (occupies_another(state, point)) return true;
  const auto states = boundary(state);
  if (!states) return true;
  if (states->size() < 2) return false;
  Reach::Reached wanted(floor_.states(), 0);
  for (const StateId other : *states) wanted[other] = 1;
  const std::span first{states->data(), 1};
  return reach_.count(first, Reach::Direction::from, wanted, states->size()) < states->size() ||
         reach_.count(first, Reach::Direction::to, wanted, states->size()) < states->size();
}

/// Of a group's points, without `point`: those outside the largest part whose members reach each other.
std::vector<std::size_t> WellFormed::Search::parted(std::size_t group, std::size_t point) {
  std::vector<std::size_t> rest;
  std::ranges::copy_if(members_[group], std::back_inserter(rest), [&](std::size_t other) { return other != point; });
  std::vector<std::size_t> largest;
  // A part with half of them is the largest one; before, each search leaves one point less.
  for (std::vector<std::size_t> left = rest; largest.size() < left.size() && 2 * largest.size() < rest.size();) {
    const Reach::Reached& there = reach_.from(points_[left.front()].states);
    const Reach::Reached& back = reach_.to(points_[left.front()].states);
    const std::size_t first = left.front();
    std::vector<std::size_t> part;
    std::erase_if(left, [&](std::size_t other) {
      const bool is_with = other == first || both(points_[other], there, back);
      if (is_with) part.push_back(other);
      return is_with;
    });
    if (part.size() > largest.size()) largest = std::move(part);
  }
  std::erase_if(rest, [&](std::size_t other) { return std::ranges::binary_search(largest, other); });
  return rest;
}

std::vector<std::size_t> WellFormed::Search::cut_off_by(std::size_t point) {
  std::vector<std::size_t> stations;
  for (std::size_t group = 0; group < members_.size(); ++group)
    for (const std::size_t other : parted(group, point))
      stations.insert(stations.end(), points_[other].stations.begin(), points_[other].stations.end());
  std::ranges::sort(stations);
  return stations;
}

void WellFormed::Search::find_cuts(std::size_t point) {
  for (const StateId state : points_[point].states) {
    const auto cells = floor_.footprint(state);
    reach_.occupy(cells);
    const auto stations = may_part(state, point) ? cut_off_by(point) : std::vector<std::size_t>{};
    reach_.release(cells);
    if (stations.empty()) continue;
    for (const std::size_t station : points_[point].stations) found_.stations_[station].cut_off = stations;
    return;
  }
}

// --- with vehicles at all stations ----------------------------------------------------------------------------------

/// Of the states that no stopped vehicle obstructs, those that can all be reached from each other.
StrongComponents WellFormed::Search::open_parts() const {
  std::vector<std::vector<StateId>> next(floor_.states());
  for (StateId state = 0; state < floor_.states(); ++state) {
    if (!reach_.is_free(state)) continue;
    for (const StateId to : floor_.successors(state))
      if (reach_.is_free(to) && reach_.is_open(state, to)) next[state].push_back(to);
  }
  StrongComponents parts;
  parts.find(floor_.states(), [&](StateId state) -> const std::vector<StateId>& { return next[state]; });
  return parts;
}

/// The open parts that the first point leads to and back from while vehicles are stopped at all others, largest first.
std::vector<std::uint32_t> WellFormed::Search::parts_at_first(const StrongComponents& parts) {
  std::vector<std::uint32_t> found;
  reach_.release(points_.front().cells);
  const Reach::Reached& there = reach_.from(points_.front().states);
  const Reach::Reached& back = reach_.to(points_.front().states);
  reach_.occupy(points_.front().cells);
  for (StateId state = 0; state < floor_.states(); ++state)
    if (there[state] != 0 && back[state] != 0 && reach_.is_free(state)) found.push_back(parts.component_of(state));
  std::ranges::sort(found, {}, [&](std::uint32_t part) { return std::pair{-std::ssize(parts.members(part)), part}; });
  found.erase(std::unique(found.begin(), found.end()), found.end());
  return found;
}

/// The first point that is not connected to this part while vehicles are stopped at all others.
std::optional<std::size_t> WellFormed::Search::first_off(std::span<const StateId> part) {
  Reach::Reached inside(floor_.states(), 0);
  for (const StateId state : part) inside[state] = 1;
  for (std::size_t point = 0; point < points_.size(); ++point) {
    reach_.release(points_[point].cells);
    const bool is_connected = reach_.count(points_[point].states, Reach::Direction::from, inside, 1) > 0 &&
                              reach_.count(points_[point].states, Reach::Direction::to, inside, 1) > 0;
    reach_.occupy(points_[point].cells);
    if (!is_connected) return point;
  }
  return std::nullopt;
}

void WellFormed::Search::find_obstructed() {
  if (points_.size() < 2) return;
  for (const StationPoint& point : points_) reach_.occupy(point.cells);
  const StrongComponents parts = open_parts();
  found_.obstructed_ = points_.front().stations.front();
  bool is_first = true;
  for (const std::uint32_t part : parts_at_first(parts)) {
    const auto off = first_off(parts.members(part));
    if (!off) {
      found_.obstructed_.reset();
      return;
    }
    if (std::exchange(is_first, false)) found_.obstructed_ = points_[*off].stations.front();
  }
}

void WellFormed::Search::run(const WellFormedLimits& limits) {
  find_exits();
  find_groups();
  find_others();
  std::size_t point = 0;
  for (; point < points_.size() && reach_.work() <= limits.work_max; ++point) find_cuts(point);
  found_.examined_ = point == points_.size() ? found_.stations_.size() : points_[point].stations.front();
  find_obstructed();
}

WellFormed WellFormed::examine(const zone::TrafficZone& zone, const WellFormedLimits& limits) {
  WellFormed found{zone.stations.size()};
  if (zone.stations.empty()) return found;
  Search{zone, found}.run(limits);
  COSIVA_EXPECT(found.stations_.size() == zone.stations.size());
  return found;
}

}  // namespace cosiva::planning
