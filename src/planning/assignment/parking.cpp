#include "cosiva/planning/assignment/parking.h"

#include <algorithm>

#include "cosiva/base/expect.h"
#include "cosiva/planning/assignment/least_cost.h"

namespace cosiva::planning {

Parking::Parking(const Floor& floor, Distances& distances, std::vector<GoalId> goals, const ParkingOptions& options)
    : floor_{&floor},
      distances_{&distances},
      options_{options},
      allowed_{std::move(goals)},
      is_taken_(floor.goals(), 0) {
  std::ranges::sort(allowed_);
  allowed_.erase(std::unique(allowed_.begin(), allowed_.end()), allowed_.end());
  COSIVA_EXPECT(allowed_.empty() || allowed_.back() < floor.goals());
}

void Parking::set_demand(std::vector<Demand> demand) {
  demand_ = std::move(demand);
  std::ranges::sort(demand_, {}, &Demand::goal);
  COSIVA_EXPECT(std::ranges::adjacent_find(demand_, {}, &Demand::goal) == demand_.end());
}

void Parking::count(GoalId pick_up) {
  COSIVA_EXPECT(pick_up < floor_->goals());
  const auto found = std::ranges::lower_bound(demand_, pick_up, {}, &Demand::goal);
  if (found != demand_.end() && found->goal == pick_up)
    ++found->weight;
  else
    demand_.insert(found, {pick_up, 1});
}

void Parking::plan(std::span<const Reserve> vehicles) {
  vehicles_.assign(vehicles.begin(), vehicles.end());
  goals_.resize(vehicles.size());
  to_demand_.clear();
  for (const Demand& demand : demand_) to_demand_.push_back(distances_->to(demand.goal));
  std::ranges::fill(is_taken_, 0);
  for (std::size_t vehicle = 0; vehicle < vehicles.size(); ++vehicle) {
    if (vehicles[vehicle].free_at) goals_[vehicle].reset();
    if (goals_[vehicle]) is_taken_[*goals_[vehicle]] = 1;
  }
  find_nearest();
  std::uint32_t decided = 0;
  for (std::size_t i = 0; i < vehicles.size() && decided < options_.vehicles_max; ++i) {
    turn_ = (turn_ + 1) % vehicles.size();
    if (vehicles[turn_].free_at) continue;
    decide(turn_);
    ++decided;
  }
  match();
}

Parking::Steps Parking::least(std::span<const StateId> states, const Steps* to) {
  Steps least = Distances::unreachable;
  for (const StateId state : states) least = std::min(least, to[state]);
  return least;
}

std::uint32_t Parking::steps(std::size_t vehicle, const Steps* to) const {
  const Reserve& reserve = vehicles_[vehicle];
  if (reserve.free_at) return reserve.free_in + least(floor_->goal(*reserve.free_at), to);
  return goals_[vehicle] ? least(floor_->goal(*goals_[vehicle]), to) : to[reserve.at];
}

void Parking::find_nearest() {
  nearest_.assign(demand_.size(), {});
  for (std::size_t vehicle = 0; vehicle < vehicles_.size(); ++vehicle) {
    for (std::size_t demand = 0; demand < demand_.size(); ++demand) {
      Nearest& nearest = nearest_[demand];
      const std::uint32_t now = steps(vehicle, to_demand_[demand]);
      if (now < nearest.first)
        nearest = {vehicle, now, nearest.first};
      else
        nearest.second = std::min(nearest.second, now);
    }
  }
}

std::uint64_t Parking::cost(std::size_t vehicle, std::span<const StateId> at) const {
  std::uint64_t sum = 0;
  for (std::size_t demand = 0; demand < demand_.size(); ++demand) {
    const Nearest& nearest = nearest_[demand];
    const std::uint32_t others = nearest.vehicle == vehicle ? nearest.second : nearest.first;
    sum += std::uint64_t{demand_[demand].weight} * std::min<std::uint32_t>(others, least(at, to_demand_[demand]));
  }
  return sum;
}

void Parking::list_candidates(std::size_t vehicle) {
  std::vector<std::pair<Steps, GoalId>> reachable;
  for (const GoalId goal : allowed_) {
    const Steps steps = distances_->to(goal)[vehicles_[vehicle].at];
    if (steps != Distances::unreachable && is_taken_[goal] == 0) reachable.emplace_back(steps, goal);
  }
  const std::size_t count = std::min<std::size_t>(reachable.size(), options_.candidates_max);
  std::ranges::partial_sort(reachable, reachable.begin() + static_cast<std::ptrdiff_t>(count));
  candidates_.clear();
  for (std::size_t i = 0; i < count; ++i) candidates_.push_back(reachable[i].second);
}

void Parking::decide(std::size_t vehicle) {
  const auto old = goals_[vehicle];
  std::uint64_t weights = 0;
  for (const Demand& demand : demand_) weights += demand.weight;
  // A quarter of a step for the loads of one vehicle on average: less is not worth a trip.
  const std::uint64_t gain_min = old ? weights / (4 * vehicles_.size()) : 0;
  std::uint64_t best = old ? cost(vehicle, floor_->goal(*old)) : cost(vehicle, {&vehicles_[vehicle].at, 1});
  best -= std::min(best, gain_min);
  list_candidates(vehicle);
  for (const GoalId goal : candidates_) {
    const std::uint64_t now = cost(vehicle, floor_->goal(goal));
    if (now >= best) continue;
    best = now;
    goals_[vehicle] = goal;
  }
  if (goals_[vehicle] == old) return;
  if (old) is_taken_[*old] = 0;
  is_taken_[*goals_[vehicle]] = 1;
  find_nearest();
}

void Parking::match() {
  std::vector<std::size_t> vehicles;
  std::vector<GoalId> goals;
  for (std::size_t vehicle = 0; vehicle < vehicles_.size(); ++vehicle) {
    if (!goals_[vehicle]) continue;
    vehicles.push_back(vehicle);
    goals.push_back(*goals_[vehicle]);
  }
  if (vehicles.size() < 2 || vehicles.size() > options_.matched_max) return;
  CostTable table{vehicles.size(), goals.size(), {}};
  for (const std::size_t vehicle : vehicles) {
    for (const GoalId goal : goals) {
      const Steps steps = distances_->to(goal)[vehicles_[vehicle].at];
      // The square prefers two short trips to a long one, and the present goal a little.
      const std::int64_t cost = 4 * std::int64_t{steps} * steps - (goals_[vehicle] == goal ? 1 : 0);
      table.costs.push_back(steps == Distances::unreachable ? forbidden_cost : std::min(cost, cost_max));
    }
  }
  const auto assignment = least_cost_assignment(table);
  if (std::ranges::find(assignment, unassigned) != assignment.end()) return;
  for (std::size_t i = 0; i < vehicles.size(); ++i) goals_[vehicles[i]] = goals[assignment[i]];
}

}  // namespace cosiva::planning
