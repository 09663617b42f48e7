#include "cosiva/planning/search/configuration_search.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

constexpr std::uint32_t none = 0xFFFFFFFF;

// A generation that has tried so many operations is given up, and the next constraint is tried.
constexpr std::uint32_t attempts_max = 4'000;

// Whether a vehicle can turn on the spot: then it may have to before it can leave its cell.
bool has_turns(const Floor& floor) {
  for (StateId from = 0; from < floor.states(); ++from)
    for (const StateId to : floor.successors(from))
      if (std::ranges::equal(floor.footprint(from), floor.footprint(to))) return true;
  return false;
}

std::uint64_t hash_of(std::span<const StateId> states) {
  std::uint64_t hash = 0x9E3779B97F4A7C15ULL;
  for (const StateId state : states) {
    hash ^= state;
    hash *= 0xFF51AFD7ED558CCDULL;
    hash ^= hash >> 32U;
  }
  return hash;
}

}  // namespace

ConfigurationSearch::ConfigurationSearch(const Floor& floor, Distances& distances, bool cycles)
    : floor_{&floor},
      distances_{&distances},
      steps_at_once_{has_turns(floor) ? JointStep::operation_steps : 1},
      reservations_{floor, steps_at_once_, cycles} {}

SearchResult ConfigurationSearch::find(std::span<const StateId> states, std::span<const GoalId> goals, Vehicle vehicle,
                                       std::span<const std::uint8_t> fixed, std::uint64_t configurations_max) {
  begin(states, goals, vehicle, fixed);
  std::vector<std::uint32_t> open{add_node({states.begin(), states.end()}, none)};
  for (std::uint64_t generated = 0; !open.empty();) {
    const std::uint32_t at = open.back();
    if (to_goal_[vehicle] == nullptr || to_goal_[vehicle][nodes_[at].states[vehicle]] == 0) {
      trace(at);
      return SearchResult::solved;
    }
    if (nodes_[at].examined == nodes_[at].constraints.size()) {
      open.pop_back();
      continue;
    }
    if (generated++ == configurations_max) return SearchResult::undecided;
    const auto constraint = static_cast<std::uint32_t>(nodes_[at].examined++);
    extend(nodes_[at], constraint);
    if (generate(nodes_[at], constraint)) add_generated(at, open);
  }
  return SearchResult::impossible;
}

void ConfigurationSearch::begin(std::span<const StateId> states, std::span<const GoalId> goals, Vehicle vehicle,
                                std::span<const std::uint8_t> fixed) {
  COSIVA_EXPECT(states.size() == goals.size() && vehicle < states.size());
  nodes_.clear();
  by_hash_.clear();
  steps_.clear();
  vehicle_ = vehicle;
  fixed_.assign(fixed.begin(), fixed.end());
  fixed_.resize(states.size(), 0);
  to_goal_.clear();
  for (const GoalId goal : goals) to_goal_.push_back(goal == no_goal ? nullptr : distances_->to(goal));
}

void ConfigurationSearch::add_generated(std::uint32_t parent, std::vector<std::uint32_t>& open) {
  std::vector<StateId> next;
  const auto vehicles = static_cast<Vehicle>(reservations_.vehicles());
  for (Vehicle vehicle = 0; vehicle < vehicles; ++vehicle) next.push_back(reservations_.path(vehicle).back());
  if (const std::uint32_t known = find_node(next); known != none) {
    open.push_back(known);
    return;
  }
  const std::uint32_t added = add_node(std::move(next), parent);
  for (std::uint32_t step = 1; step < steps_at_once_; ++step)
    for (Vehicle vehicle = 0; vehicle < vehicles; ++vehicle)
      nodes_[added].between.push_back(reservations_.path(vehicle)[step]);
  open.push_back(added);
}

std::uint32_t ConfigurationSearch::add_node(std::vector<StateId> states, std::uint32_t parent) {
  const auto index = static_cast<std::uint32_t>(nodes_.size());
  by_hash_.emplace(hash_of(states), index);
  auto order = order_of(states);
  nodes_.push_back({std::move(states), {}, parent, std::move(order), {{none, 0, {}}}, 0});
  return index;
}

std::vector<Vehicle> ConfigurationSearch::order_of(std::span<const StateId> states) const {
  // The vehicle first, then those that obstruct it: the nearer to its goal, the more likely.
  const Distances::Steps* const to = to_goal_[vehicle_];
  std::vector<Vehicle> order(states.size());
  std::iota(order.begin(), order.end(), 0U);
  std::ranges::stable_sort(order, {}, [&](Vehicle other) {
    return std::pair{other != vehicle_, to == nullptr ? Distances::Steps{0} : to[states[other]]};
  });
  return order;
}

std::uint32_t ConfigurationSearch::find_node(std::span<const StateId> states) const {
  const auto [first, last] = by_hash_.equal_range(hash_of(states));
  for (auto it = first; it != last; ++it)
    if (std::ranges::equal(nodes_[it->second].states, states)) return it->second;
  return none;
}

void ConfigurationSearch::extend(Node& node, std::uint32_t constraint) {
  const std::uint32_t depth = node.constraints[constraint].depth;
  if (depth == node.order.size()) return;
  const Vehicle vehicle = node.order[depth];
  for (const Operation& operation : candidates(vehicle, node.states[vehicle]))
    node.constraints.push_back({constraint, depth + 1, operation});
}

bool ConfigurationSearch::generate(const Node& node, std::uint32_t constraint) {
  reservations_.begin(node.states);
  decided_.clear();
  attempts_left_ = attempts_max;
  failed_step_.assign(node.states.size(), 0);
  // The constrained vehicles first, all of them: none of them is displaced by another one.
  for (std::uint32_t at = constraint; node.constraints[at].depth > 0; at = node.constraints[at].parent) {
    const Vehicle vehicle = node.order[node.constraints[at].depth - 1];
    if (!permits(vehicle, node.constraints[at].operation)) return false;
    reservations_.add(vehicle, path_of(node.constraints[at].operation));
  }
  for (const Vehicle vehicle : node.order)
    if (!reservations_.has_path(vehicle) && !decide(node, vehicle)) return false;
  return true;
}

std::vector<ConfigurationSearch::Operation> ConfigurationSearch::candidates(Vehicle vehicle, StateId from) const {
  std::vector<Operation> list;
  Operation operation;
  operation.fill(from);
  if (fixed_[vehicle] != 0) return {operation};
  extend_operation(operation, 1, list);
  // Those that end nearer to the goal first, and of these the ones that are nearer earlier; without goal, those with
  // fewer moves.
  const Distances::Steps* const to = to_goal_[vehicle];
  std::ranges::stable_sort(list, {}, [&](const Operation& one) {
    std::uint64_t cost = to == nullptr ? 0 : to[one[steps_at_once_]];
    for (std::uint32_t step = 1; step <= steps_at_once_; ++step)
      cost = cost * 0x100 + (to == nullptr ? std::uint64_t{one[step] != one[step - 1]} : std::uint64_t{to[one[step]]});
    return cost;
  });
  return list;
}

void ConfigurationSearch::extend_operation(Operation& operation, std::uint32_t step,
                                           std::vector<Operation>& list) const {
  if (step > steps_at_once_) {
    list.push_back(operation);
    return;
  }
  operation[step] = operation[step - 1];
  extend_operation(operation, step + 1, list);
  for (const StateId to : floor_->successors(operation[step - 1])) {
    operation[step] = to;
    extend_operation(operation, step + 1, list);
  }
}

bool ConfigurationSearch::permits(Vehicle vehicle, const Operation& operation) const {
  for (std::uint32_t step = 1; step <= steps_at_once_; ++step)
    if (!reservations_.permits(vehicle, operation[step - 1], operation[step], step)) return false;
  return true;
}

bool ConfigurationSearch::decide(const Node& node, Vehicle vehicle) {
  for (const Operation& operation : candidates(vehicle, node.states[vehicle]))
    if (attempt(node, vehicle, operation)) return true;
  return false;
}

bool ConfigurationSearch::attempt(const Node& node, Vehicle vehicle, const Operation& operation) {
  if (attempts_left_ == 0 || !permits(vehicle, operation)) return false;
  --attempts_left_;
  const std::size_t before = decided_.size();
  reservations_.add(vehicle, path_of(operation));
  decided_.push_back(vehicle);
  bool good = true;
  for (std::uint32_t step = 1; good && step <= steps_at_once_; ++step) {
    for (const CellId cell : floor_->footprint(operation[step])) {
      const Vehicle other = reservations_.owner(0, cell);
      if (other == no_vehicle || other == vehicle || reservations_.has_path(other)) continue;
      // A vehicle that could not leave its cells by this step is not tried again in the same generation.
      good = step > failed_step_[other] && decide(node, other);
      if (good) continue;
      failed_step_[other] = std::max(failed_step_[other], step);
      break;
    }
  }
  if (good) return true;
  while (decided_.size() > before) {
    reservations_.remove(decided_.back());
    decided_.pop_back();
  }
  return false;
}

void ConfigurationSearch::trace(std::uint32_t node) {
  const std::size_t vehicles = nodes_[node].states.size();
  for (; nodes_[node].parent != none; node = nodes_[node].parent) {
    steps_.push_back(nodes_[node].states);
    const std::span between{nodes_[node].between};
    for (std::size_t step = steps_at_once_ - 1; step-- > 0;) {
      const auto states = between.subspan(step * vehicles, vehicles);
      steps_.emplace_back(states.begin(), states.end());
    }
  }
  std::ranges::reverse(steps_);
}

}  // namespace cosiva::planning
