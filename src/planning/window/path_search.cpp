#include "cosiva/planning/window/path_search.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

constexpr std::uint32_t no_node = 0xFFFFFFFF;

// Costs that far above the least possible one are not searched for: the vehicle waits instead.
constexpr std::uint32_t delay_max = 1024;

}  // namespace

PathSearch::PathSearch(const Floor& floor, std::uint32_t horizon)
    : floor_{&floor},
      horizon_{horizon},
      stamps_((horizon + std::size_t{1}) * floor.states() * (legs_max + 1), 0),
      by_cost_(delay_max) {}

void PathSearch::begin(std::uint32_t limit, std::uint32_t least) {
  if (++search_ == 0) {
    std::ranges::fill(stamps_, 0);
    search_ = 1;
  }
  nodes_.clear();
  for (auto& list : by_cost_) list.clear();
  limit_ = std::min(limit, least + delay_max);
  least_ = least;
}

bool PathSearch::find(Vehicle vehicle, StateId at, const Itinerary& itinerary, const Reservations& reservations,
                      std::uint32_t limit, std::span<StateId> path) {
  COSIVA_EXPECT(path.size() == horizon_ + std::size_t{1} && reservations.horizon() == horizon_);
  const Itinerary::Progress start = itinerary.start(at);
  const std::uint32_t least = itinerary.remaining(start, at);
  begin(limit, least);
  add({no_node, least, at, 0, start, true});
  for (std::uint32_t cost = least; cost < limit_; ++cost) {
    auto& list = by_cost_[cost - least];
    while (!list.empty()) {
      const std::uint32_t index = list.back();
      list.pop_back();
      if (!nodes_[index].is_first && !is_first(nodes_[index])) continue;
      ++expansions_;
      if (nodes_[index].step == horizon_) {
        trace(index, path);
        return true;
      }
      expand(index, vehicle, itinerary, reservations);
    }
  }
  return false;
}

void PathSearch::add(const Node& node) {
  if (node.cost >= limit_ || (node.is_first && !is_first(node))) return;
  by_cost_[node.cost - least_].push_back(static_cast<std::uint32_t>(nodes_.size()));
  nodes_.push_back(node);
}

bool PathSearch::is_first(const Node& node) {
  const std::size_t leg = std::min(node.progress.leg, legs_max);
  std::uint32_t& stamp = stamps_[(std::size_t{node.step} * floor_->states() + node.state) * (legs_max + 1) + leg];
  if (stamp == search_) return false;
  stamp = search_;
  return true;
}

std::uint32_t PathSearch::cost_after(const Node& node, StateId to, const Itinerary& itinerary,
                                     Itinerary::Progress& progress) const {
  if (itinerary.idle()) return node.cost + (to == node.state ? 0 : 1);
  if (itinerary.done(node.progress)) return node.cost;
  progress = itinerary.next(node.progress, to);
  return node.step + 1 + itinerary.remaining(progress, to);
}

void PathSearch::expand(std::uint32_t index, Vehicle vehicle, const Itinerary& itinerary,
                        const Reservations& reservations) {
  const Node node = nodes_[index];
  const auto go = [&](StateId to) {
    if (!reservations.permits(vehicle, node.state, to, node.step + 1)) return;
    Itinerary::Progress progress = node.progress;
    const std::uint32_t cost = cost_after(node, to, itinerary, progress);
    // A vehicle without stops may reach the same node later with fewer moves: that is decided when it is examined.
    add({index, cost, to, node.step + 1, progress, !itinerary.idle() || cost == node.cost});
  };
  if (Itinerary::staying(node.progress)) return go(node.state);
  // Of equal nodes the last one added is examined first: a vehicle with a goal moves early, one at its end waits.
  const bool waits_first = itinerary.done(node.progress);
  if (!waits_first) go(node.state);
  for (const StateId to : floor_->successors(node.state)) go(to);
  if (waits_first) go(node.state);
}

void PathSearch::trace(std::uint32_t index, std::span<StateId> path) const {
  for (; index != no_node; index = nodes_[index].parent) path[nodes_[index].step] = nodes_[index].state;
}

void PathSearch::archive(Archive& archive) { archive(expansions_); }

}  // namespace cosiva::planning
