#include "cosiva/planning/assignment/dispatch.h"

#include <algorithm>
#include <numeric>

#include "cosiva/base/expect.h"
#include "cosiva/planning/assignment/least_cost.h"

namespace cosiva::planning {
namespace {

// Of a tour with an order that the vehicle cannot reach; far above all others, and still good to add up.
constexpr std::uint64_t impossible = std::uint64_t{1} << 50U;

// With each level of priority a step of waiting costs as much more as this many do without.
constexpr std::uint64_t per_priority = 16;
// So that no order waits for ever: after so many steps of waiting a further one costs twice as much.
constexpr std::uint64_t age_doubles = 256;

// Of an exchange: of so many vehicles drawn the one with the highest cost is relieved, and of so many orders drawn the
// nearest one becomes the predecessor. Measured with 50 vehicles and 500 orders, and with 100 and 1 000: fewer are
// worse.
constexpr int late_tries = 8;
constexpr int near_tries = 8;

Distances::Steps least_of(const Distances::Steps* to, std::span<const StateId> states) {
  Distances::Steps least = Distances::unreachable;
  for (const StateId state : states) least = std::min(least, to[state]);
  return least;
}

}  // namespace

Dispatch::Dispatch(const Floor& floor, Distances& distances, const DispatchOptions& options, std::uint64_t seed)
    : floor_{&floor}, distances_{&distances}, options_{options}, random_{seed, "dispatch"} {}

void Dispatch::plan(std::span<const Carrier> carriers, std::span<const OpenOrder> orders) {
  accept(carriers, orders);
  adopt_tours(orders);
  for (const std::size_t order : considered_)
    if (positions_[order].carrier == none) insert(order);
  assign_singly();
  exchange();
  std::size_t planned = 0;
  ids_.assign(carriers.size(), {});
  for (std::size_t carrier = 0; carrier < carriers.size(); ++carrier) {
    planned += tours_[carrier].size();
    for (const std::size_t order : tours_[carrier]) ids_[carrier].push_back(orders[order].id);
  }
  COSIVA_EXPECT(planned <= considered_.size());
}

void Dispatch::accept(std::span<const Carrier> carriers, std::span<const OpenOrder> orders) {
  starts_.clear();
  for (const Carrier& carrier : carriers) starts_.push_back(start_of(carrier));
  std::vector<std::size_t> order(orders.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) {
    if (orders[a].priority != orders[b].priority) return orders[a].priority > orders[b].priority;
    return orders[a].age > orders[b].age;
  });
  order.resize(std::min<std::size_t>(order.size(), options_.orders_max));
  legs_.assign(orders.size(), {});
  considered_.clear();
  for (const std::size_t index : order)
    if (make_leg(orders[index], legs_[index])) considered_.push_back(index);
}

Dispatch::Start Dispatch::start_of(const Carrier& carrier) {
  Start start{carrier.at, no_goal, 0, carrier.available};
  for (const Stop& stop : carrier.stops) {
    const Distances::Steps* const to = distances_->to(stop.goal);
    const Distances::Steps steps = start.goal == no_goal ? to[start.state] : least_of(to, floor_->goal(start.goal));
    if (steps == Distances::unreachable) {
      start.available = false;
      break;
    }
    start.free_in += steps + stop.stay;
    start.goal = stop.goal;
  }
  return start;
}

bool Dispatch::make_leg(const OpenOrder& order, Leg& leg) {
  const Distances::Steps carry = least_of(distances_->to(order.delivery.goal), floor_->goal(order.pick_up.goal));
  if (carry == Distances::unreachable) return false;
  leg.to_pick_up = distances_->to(order.pick_up.goal);
  leg.delivery = floor_->goal(order.delivery.goal);
  leg.duration = order.pick_up.stay + carry + order.delivery.stay;
  leg.waiting_cost = options_.waiting_cost * (1 + per_priority * order.priority + order.age / age_doubles);
  return true;
}

void Dispatch::adopt_tours(std::span<const OpenOrder> orders) {
  std::vector<std::pair<std::uint64_t, std::size_t>> by_id;
  for (const std::size_t order : considered_) by_id.emplace_back(orders[order].id, order);
  std::ranges::sort(by_id);
  COSIVA_EXPECT(std::ranges::adjacent_find(by_id, {}, [](const auto& pair) { return pair.first; }) == by_id.end());
  positions_.assign(orders.size(), {none, 0});
  ids_.resize(starts_.size());
  tours_.assign(starts_.size(), {});
  costs_.assign(starts_.size(), 0);
  for (std::size_t carrier = 0; carrier < starts_.size(); ++carrier) {
    first_.clear();
    for (const std::uint64_t id : ids_[carrier]) {
      const auto found = std::ranges::lower_bound(by_id, id, {}, [](const auto& pair) { return pair.first; });
      if (found != by_id.end() && found->first == id) first_.push_back(found->second);
    }
    if (!starts_[carrier].available || cost(carrier, first_).cost >= impossible) first_.clear();
    set_tour(carrier, first_);
  }
}

void Dispatch::insert(std::size_t order) {
  std::uint64_t least = impossible;
  Position best{none, 0};
  for (std::size_t carrier = 0; carrier < tours_.size(); ++carrier) {
    if (!starts_[carrier].available) continue;
    for (std::size_t index = 0; index <= tours_[carrier].size(); ++index) {
      first_ = tours_[carrier];
      first_.insert(first_.begin() + static_cast<std::ptrdiff_t>(index), order);
      const std::uint64_t now = cost(carrier, first_).cost;
      if (now >= impossible || now - costs_[carrier] >= least) continue;
      least = now - costs_[carrier];
      best = {carrier, index};
    }
  }
  if (best.carrier == none) return;
  first_ = tours_[best.carrier];
  first_.insert(first_.begin() + static_cast<std::ptrdiff_t>(best.index), order);
  set_tour(best.carrier, first_);
}

void Dispatch::assign_singly() {
  if (considered_.empty() || considered_.size() > starts_.size()) return;
  CostTable table{considered_.size(), starts_.size(), {}};
  std::uint64_t now = 0;
  for (const std::size_t order : considered_) {
    for (std::size_t carrier = 0; carrier < starts_.size(); ++carrier) {
      const std::uint64_t with = cost(carrier, {&order, 1}).cost;
      const bool possible = starts_[carrier].available && with < impossible;
      const auto more = static_cast<std::int64_t>(with - cost(carrier, {}).cost);
      table.costs.push_back(possible ? std::min(more, cost_max) : forbidden_cost);
    }
  }
  for (std::size_t carrier = 0; carrier < starts_.size(); ++carrier) now += costs_[carrier] - cost(carrier, {}).cost;
  const auto assignment = least_cost_assignment(table);
  if (std::ranges::find(assignment, unassigned) != assignment.end()) return;
  std::uint64_t then = 0;
  for (std::size_t row = 0; row < table.rows; ++row) then += static_cast<std::uint64_t>(table.at(row, assignment[row]));
  if (then >= now) return;
  for (std::size_t carrier = 0; carrier < starts_.size(); ++carrier) set_tour(carrier, {});
  for (std::size_t row = 0; row < table.rows; ++row) set_tour(assignment[row], {considered_[row]});
}

Dispatch::TourCost Dispatch::cost(std::size_t carrier, std::span<const std::size_t> tour) const {
  const Start& start = starts_[carrier];
  std::span<const StateId> at = start.goal == no_goal ? std::span{&start.state, 1} : floor_->goal(start.goal);
  TourCost result{0, start.free_in};
  for (const std::size_t order : tour) {
    const Leg& leg = legs_[order];
    const Distances::Steps steps = least_of(leg.to_pick_up, at);
    if (steps == Distances::unreachable) return {impossible, result.end};
    result.end += steps;
    result.cost += leg.waiting_cost * result.end;
    result.end += leg.duration;
    at = leg.delivery;
  }
  result.cost += std::uint64_t{result.end} * result.end;
  return result;
}

std::size_t Dispatch::some_order() { return considered_[random_.below(considered_.size())]; }

void Dispatch::exchange() {
  // An exchange needs two positions; one tour alone has them with two orders.
  if (considered_.empty() || starts_.size() + considered_.size() < 3) return;
  for (std::uint32_t attempt = 0; attempt < options_.exchanges_max; ++attempt) {
    const Position a = attempt % 2 == 0 ? positions_[some_order()] : position_of_late();
    const Position b = position_after_near(a);
    if (a.carrier == none || b.carrier == none || !starts_[b.carrier].available) continue;
    if (a.carrier == b.carrier)
      try_within(a, b);
    else
      try_exchange(a, b, random_.below(3));
  }
}

Dispatch::Position Dispatch::position_of_late() {
  std::size_t latest = random_.below(starts_.size());
  for (int i = 1; i < late_tries; ++i)
    if (const std::size_t other = random_.below(starts_.size()); costs_[other] > costs_[latest]) latest = other;
  if (tours_[latest].empty()) return {none, 0};
  return {latest, random_.below(tours_[latest].size())};
}

Dispatch::Position Dispatch::position_after_near(Position a) {
  if (a.carrier == none) return a;
  if (random_.below(4) == 0) {
    const std::size_t carrier = random_.below(starts_.size());
    return {carrier, random_.below(2) == 0 ? 0 : tours_[carrier].size()};
  }
  const Leg& leg = legs_[tours_[a.carrier][a.index]];
  Position best{none, 0};
  Distances::Steps least = Distances::unreachable;
  for (int i = 0; i < near_tries; ++i) {
    const std::size_t order = some_order();
    const Distances::Steps steps = least_of(leg.to_pick_up, legs_[order].delivery);
    if (steps >= least || positions_[order].carrier == none) continue;
    least = steps;
    best = {positions_[order].carrier, positions_[order].index + 1};
  }
  return best;
}

void Dispatch::try_exchange(Position a, Position b, std::uint64_t kind) {
  const Tour& tour_a = tours_[a.carrier];
  const Tour& tour_b = tours_[b.carrier];
  const auto at_a = tour_a.begin() + static_cast<std::ptrdiff_t>(a.index);
  const auto at_b = tour_b.begin() + static_cast<std::ptrdiff_t>(b.index);
  // Kind 0: the order at a goes before b. 1: both orders change tours. 2: everything from a on and from b on does.
  const bool has_b = b.index < tour_b.size();
  const auto end_a = kind == 2 ? tour_a.end() : at_a + 1;
  const auto end_b = kind == 2 ? tour_b.end() : (kind == 1 && has_b ? at_b + 1 : at_b);
  first_.assign(tour_a.begin(), at_a);
  first_.insert(first_.end(), at_b, end_b);
  first_.insert(first_.end(), end_a, tour_a.end());
  second_.assign(tour_b.begin(), at_b);
  second_.insert(second_.end(), at_a, end_a);
  second_.insert(second_.end(), end_b, tour_b.end());
  const std::uint64_t now = costs_[a.carrier] + costs_[b.carrier];
  const std::uint64_t cost_a = cost(a.carrier, first_).cost;
  if (cost_a >= now || cost_a + cost(b.carrier, second_).cost >= now) return;
  set_tour(a.carrier, first_);
  set_tour(b.carrier, second_);
}

void Dispatch::try_within(Position a, Position b) {
  if (a.index == b.index) return;
  first_ = tours_[a.carrier];
  const auto begin = first_.begin();
  const auto at_a = begin + static_cast<std::ptrdiff_t>(a.index);
  const auto at_b = begin + static_cast<std::ptrdiff_t>(b.index);
  if (at_a < at_b)
    std::rotate(at_a, at_a + 1, at_b);
  else
    std::rotate(at_b, at_a, at_a + 1);
  if (cost(a.carrier, first_).cost < costs_[a.carrier]) set_tour(a.carrier, first_);
}

void Dispatch::set_tour(std::size_t carrier, const Tour& tour) {
  tours_[carrier] = tour;
  costs_[carrier] = cost(carrier, tour).cost;
  for (std::size_t index = 0; index < tour.size(); ++index) positions_[tour[index]] = {carrier, index};
}

}  // namespace cosiva::planning
