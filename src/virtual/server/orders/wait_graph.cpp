#include "cosiva/virtual/server/orders/wait_graph.h"

#include <algorithm>
#include <tuple>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr auto no_wait = std::numeric_limits<std::size_t>::max();

}  // namespace

void WaitGraph::begin(std::size_t count) {
  count_ = count;
  waits_.clear();
  knots_.clear();
}

void WaitGraph::add(const Wait& wait) {
  if (wait.waiter != wait.blocker && wait.waiter < count_ && wait.blocker < count_) waits_.push_back(wait);
}

void WaitGraph::sort_waits() {
  const auto key = [](const Wait& w) { return std::tuple(w.waiter, w.blocker, w.why, w.crossing); };
  // They are added vehicle by vehicle.
  if (!std::ranges::is_sorted(waits_, {}, key)) std::ranges::sort(waits_, {}, key);
  first_.assign(count_ + 1, 0);
  for (const Wait& wait : waits_) ++first_[wait.waiter + 1];
  for (std::size_t i = 0; i < count_; ++i) first_[i + 1] += first_[i];
  COSIVA_EXPECT(first_.back() == waits_.size());
}

const std::vector<Knot>& WaitGraph::find_knots() {
  knots_.clear();
  sort_waits();
  // A cycle needs vehicles that wait and are waited for; most of the time there are none.
  const auto waits_itself = [this](const Wait& wait) { return first_[wait.blocker] < first_[wait.blocker + 1]; };
  if (std::ranges::none_of(waits_, waits_itself)) return knots_;
  blockers_.clear();
  for (const Wait& wait : waits_) blockers_.push_back(wait.blocker);
  components_.find(count_, [this](VehicleIndex v) {
    return std::span<const VehicleIndex>{blockers_}.subspan(first_[v], first_[v + 1] - first_[v]);
  });
  for (std::size_t i = 0; i < components_.size(); ++i) {
    const auto members = components_.members(i);
    if (members.size() > 1) knots_.push_back({{members.begin(), members.end()}, {}});
  }
  std::ranges::sort(knots_, {}, [](const Knot& knot) { return knot.members.front(); });
  for (Knot& knot : knots_) knot.cycle = cycle_through(knot.members.front());
  return knots_;
}

std::vector<Wait> WaitGraph::cycle_through(VehicleIndex first) {
  // Breadth-first search from the first member until a wait leads back to that member. One search reaches all vehicles
  // of a knot.
  came_by_.resize(count_, no_wait);
  reached_.assign(1, first);
  std::size_t last = no_wait;
  for (std::size_t i = 0; i < reached_.size() && last == no_wait; ++i) {
    const VehicleIndex v = reached_[i];
    for (std::size_t at = first_[v]; at < first_[v + 1] && last == no_wait; ++at) {
      const VehicleIndex blocker = waits_[at].blocker;
      if (blocker == first) {
        last = at;
      } else if (components_.component_of(blocker) == components_.component_of(first) && came_by_[blocker] == no_wait) {
        came_by_[blocker] = at;
        reached_.push_back(blocker);
      }
    }
  }
  COSIVA_EXPECT(last != no_wait);
  std::vector<Wait> cycle;
  for (std::size_t at = last; at != no_wait; at = came_by_[waits_[at].waiter]) cycle.push_back(waits_[at]);
  std::ranges::reverse(cycle);
  for (const VehicleIndex v : reached_) came_by_[v] = no_wait;
  return cycle;
}

void WaitGraph::archive(Archive& archive) { archive(count_, waits_, first_, blockers_, came_by_, reached_, knots_); }

}  // namespace cosiva::virtual_side
