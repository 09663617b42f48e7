#include "cosiva/planning/layout_check/reach.h"

#include <algorithm>
#include <limits>

#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

constexpr std::size_t all = std::numeric_limits<std::size_t>::max();

}  // namespace

Reach::Reach(const Floor& floor) : floor_{&floor}, occupied_(floor.cells(), 0) {}

void Reach::occupy(std::span<const CellId> cells) {
  for (const CellId cell : cells) ++occupied_[cell];
}

void Reach::release(std::span<const CellId> cells) {
  for (const CellId cell : cells) {
    COSIVA_EXPECT(occupied_[cell] > 0);
    --occupied_[cell];
  }
}

bool Reach::is_free(std::span<const CellId> cells) const {
  return std::ranges::none_of(cells, [&](CellId cell) { return occupied_[cell] > 0; });
}

void Reach::search(std::span<const StateId> states, Direction direction, Reached& reached, const Reached* wanted,
                   std::size_t enough) {
  reached.assign(floor_->states(), 0);
  queue_.clear();
  found_ = 0;
  const auto add = [&](StateId state) {
    if (reached[state] != 0 || !is_free(state)) return;
    reached[state] = 1;
    queue_.push_back(state);
    if (wanted != nullptr && (*wanted)[state] != 0) ++found_;
  };
  for (const StateId state : states) add(state);
  for (std::size_t i = 0; i < queue_.size() && found_ < enough; ++i) {
    const StateId state = queue_[i];
    const bool forward = direction == Direction::from;
    for (const StateId next : forward ? floor_->successors(state) : floor_->predecessors(state)) {
      ++work_;
      if (reached[next] == 0 && (forward ? is_open(state, next) : is_open(next, state))) add(next);
    }
  }
}

const Reach::Reached& Reach::from(std::span<const StateId> states) {
  search(states, Direction::from, from_, nullptr, all);
  return from_;
}

const Reach::Reached& Reach::to(std::span<const StateId> states) {
  search(states, Direction::to, to_, nullptr, all);
  return to_;
}

std::size_t Reach::count(std::span<const StateId> states, Direction direction, const Reached& wanted,
                         std::size_t enough) {
  search(states, direction, counted_, &wanted, enough);
  return found_;
}

}  // namespace cosiva::planning
