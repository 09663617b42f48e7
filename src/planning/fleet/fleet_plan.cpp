#include "cosiva/planning/fleet/fleet_plan.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::planning {

FleetPlan::FleetPlan(const Floor& floor, const Floor& open, const FleetPlanOptions& options, std::uint64_t seed)
    : options_{options},
      distances_{open},
      planner_{open, distances_, options.window, seed},
      search_{open, distances_, options.window.cycles},
      order_{floor} {
  COSIVA_EXPECT(options.unfinished_max > options.planned_min && open.states() == floor.states());
}

void FleetPlan::begin(std::span<const StateId> states) {
  std::vector<GrantedMoves> granted;
  for (const StateId state : states) granted.push_back({{state}, false});
  begin(granted);
}

void FleetPlan::begin(std::span<const GrantedMoves> granted) {
  order_.begin(granted);
  fleet_.clear();
  for (const GrantedMoves& moves : granted) fleet_.push_back({moves.states.back(), {}, 0});
  progress_.assign(granted.size(), {});
  found_ = {};
  steps_since_change_ = 0;
}

void FleetPlan::set_stops(Vehicle vehicle, std::span<const Stop> stops, std::uint32_t urgency) {
  fleet_[vehicle].urgency = urgency;
  Progress& progress = progress_[vehicle];
  std::vector<Stop>& known = progress.stops;
  const std::size_t ended = known.size() - std::min(known.size(), stops.size());
  if (std::ranges::equal(std::span{known}.subspan(ended), stops)) {
    known.erase(known.begin(), known.begin() + static_cast<std::ptrdiff_t>(ended));
    if (ended > progress.ended) progress.stayed = 0;
    progress.ended -= std::min(progress.ended, ended);
  } else {
    progress = Progress{};
    steps_since_change_ = 0;
    progress.stops.assign(stops.begin(), stops.end());
  }
  count_stops(vehicle, false);
}

void FleetPlan::count_stops(Vehicle vehicle, bool stays) {
  Progress& progress = progress_[vehicle];
  Traveller& traveller = fleet_[vehicle];
  for (; progress.ended < progress.stops.size(); ++progress.ended, progress.stayed = 0) {
    const Stop& stop = progress.stops[progress.ended];
    if (distances_.to(stop.goal)[traveller.at] != 0) break;
    if (stays && progress.stayed < stop.stay) ++progress.stayed;
    if (progress.stayed < stop.stay) break;
  }
  traveller.stops.assign(progress.stops.begin() + static_cast<std::ptrdiff_t>(progress.ended), progress.stops.end());
  if (!traveller.stops.empty()) traveller.stops.front().stay -= progress.stayed;
}

bool FleetPlan::wants_step() const {
  for (Vehicle vehicle = 0; vehicle < fleet_.size(); ++vehicle)
    if (!fleet_[vehicle].stops.empty() && order_.planned_moves(vehicle) < options_.planned_min) return true;
  return false;
}

bool FleetPlan::grant(Vehicle vehicle) {
  const std::vector<Stop>& stops = progress_[vehicle].stops;
  if (!stops.empty() && distances_.to(stops.front().goal)[order_.granted_end(vehicle)] == 0) return false;
  return order_.grant(vehicle);
}

bool FleetPlan::is_late() const {
  for (Vehicle vehicle = 0; vehicle < fleet_.size(); ++vehicle)
    if (order_.planned_moves(vehicle) + order_.granted_moves(vehicle) >= options_.unfinished_max) return true;
  return false;
}

void FleetPlan::plan() {
  // A vehicle that waits needs several steps until its next move is planned; a whole window, at most.
  for (std::uint32_t step = 0; step < options_.window.horizon && wants_step() && !is_late(); ++step) {
    if (steps_since_change_ >= 2 * options_.window.horizon) return;
    ++steps_since_change_;
    add_step();
  }
}

void FleetPlan::replan() {
  const Vehicle found = found_.vehicle;
  if (found_.moves > 0 && order_.ended_moves(found) + order_.granted_moves(found) < found_.moves) return;
  found_ = {};
  order_.drop_planned();
  for (Vehicle vehicle = 0; vehicle < fleet_.size(); ++vehicle) {
    fleet_[vehicle].at = order_.granted_end(vehicle);
    progress_[vehicle].ended = 0;
    progress_[vehicle].stayed = 0;
    count_stops(vehicle, false);
    progress_[vehicle].nearest = away(vehicle);
  }
  ++replans_;
}

void FleetPlan::add_step() {
  if (const auto stuck = most_stuck(); stuck && search_for(*stuck)) return;
  planner_.plan(fleet_, options_.expansions_max);
  next_.clear();
  for (Vehicle vehicle = 0; vehicle < fleet_.size(); ++vehicle) next_.push_back(planner_.path(vehicle)[1]);
  advance(next_);
}

void FleetPlan::advance(std::span<const StateId> next) {
  order_.add_step(next);
  for (Vehicle vehicle = 0; vehicle < fleet_.size(); ++vehicle) {
    const bool stays = fleet_[vehicle].at == next[vehicle];
    fleet_[vehicle].at = next[vehicle];
    count_stops(vehicle, stays);
    watch(vehicle);
  }
  ++steps_;
}

void FleetPlan::watch(Vehicle vehicle) {
  Progress& progress = progress_[vehicle];
  const Distances::Steps now = away(vehicle);
  if (now > 0 && now >= progress.nearest) {
    ++progress.stuck;
    return;
  }
  progress.nearest = now > 0 ? now : Distances::unreachable;
  progress.stuck = 0;
}

Distances::Steps FleetPlan::away(Vehicle vehicle) {
  const Traveller& traveller = fleet_[vehicle];
  return traveller.stops.empty() ? Distances::Steps{0} : distances_.to(traveller.stops.front().goal)[traveller.at];
}

std::optional<Vehicle> FleetPlan::most_stuck() const {
  std::optional<Vehicle> most;
  for (Vehicle vehicle = 0; vehicle < fleet_.size(); ++vehicle) {
    const Progress& progress = progress_[vehicle];
    if (progress.stuck >= options_.stuck_steps && planner_.complete(vehicle) &&
        (!most || progress.stuck > progress_[*most].stuck))
      most = vehicle;
  }
  return most;
}

bool FleetPlan::search_for(Vehicle vehicle) {
  std::vector<StateId> states;
  std::vector<GoalId> goals;
  std::vector<std::uint8_t> fixed;
  for (Vehicle other = 0; other < fleet_.size(); ++other) {
    const Traveller& traveller = fleet_[other];
    states.push_back(traveller.at);
    goals.push_back(traveller.stops.empty() ? no_goal : traveller.stops.front().goal);
    fixed.push_back(progress_[other].stayed > 0 ? 1 : 0);
  }
  Progress& progress = progress_[vehicle];
  progress.configurations_max =
      std::clamp(2 * progress.configurations_max, options_.configurations_max, 16 * options_.configurations_max);
  progress.searched = search_.find(states, goals, vehicle, fixed, progress.configurations_max);
  progress.stuck = 0;
  if (progress.searched != SearchResult::solved) return false;
  for (const auto& step : search_.steps()) advance(step);
  found_ = {vehicle, order_.ended_moves(vehicle) + order_.granted_moves(vehicle) + order_.planned_moves(vehicle)};
  progress.configurations_max = 0;
  return true;
}

void FleetPlan::archive(Archive& archive) {
  archive(planner_, order_, fleet_, progress_, found_, steps_, steps_since_change_, replans_);
}

}  // namespace cosiva::planning
