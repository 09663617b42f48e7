#include "cosiva/planning/passing/passing_order.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::planning {

PassingOrder::PassingOrder(const Floor& floor) : floor_{&floor}, queues_(floor.cells()) {}

void PassingOrder::begin(std::span<const StateId> states) {
  std::vector<GrantedMoves> granted;
  for (const StateId state : states) granted.push_back({{state}, false});
  begin(granted);
}

void PassingOrder::begin(std::span<const GrantedMoves> granted) {
  for (auto& queue : queues_) queue.clear();
  vehicles_.clear();
  for (std::uint32_t vehicle = 0; vehicle < granted.size(); ++vehicle) {
    const auto& [states, is_clear] = granted[vehicle];
    COSIVA_EXPECT(states.size() > (is_clear ? 1U : 0U));
    vehicles_.push_back({{states.begin(), states.end()}, states.size() - 1, 0, is_clear});
    for (const CellId cell : floor_->footprint(states[0]))
      if (!is_clear || std::ranges::binary_search(floor_->footprint(states[1]), cell))
        queues_[cell].push_back({vehicle, 0});
    for (std::size_t move = 1; move < states.size(); ++move) enter(vehicle, states[move - 1], states[move], move);
  }
  for (const auto& queue : queues_)
    COSIVA_EXPECT(std::ranges::all_of(queue, [&](const Use& use) { return use.vehicle == queue.front().vehicle; }));
}

void PassingOrder::add_step(std::span<const StateId> next) {
  COSIVA_EXPECT(next.size() == vehicles_.size());
  for (std::uint32_t vehicle = 0; vehicle < next.size(); ++vehicle) {
    VehicleMoves& moves = vehicles_[vehicle];
    const StateId from = moves.states.back();
    if (next[vehicle] == from) continue;
    enter(vehicle, from, next[vehicle], moves.done + moves.states.size());
    moves.states.push_back(next[vehicle]);
  }
}

void PassingOrder::enter(std::uint32_t vehicle, StateId from, StateId to, std::uint64_t move) {
  floor_->each_entered(from, to, [&](CellId cell) { queues_[cell].push_back({vehicle, move}); });
}

void PassingOrder::drop_planned() {
  for (std::uint32_t vehicle = 0; vehicle < vehicles_.size(); ++vehicle) {
    VehicleMoves& moves = vehicles_[vehicle];
    while (moves.states.size() > moves.granted + 1) {
      const StateId to = moves.states.back();
      moves.states.pop_back();
      const std::uint64_t move = moves.done + moves.states.size();
      floor_->each_entered(moves.states.back(), to, [&](CellId cell) {
        std::erase_if(queues_[cell], [&](const Use& use) { return use.vehicle == vehicle && use.first == move; });
      });
    }
  }
}

std::optional<std::uint32_t> PassingOrder::waits_for(std::uint32_t vehicle) const {
  const VehicleMoves& moves = vehicles_[vehicle];
  if (planned_moves(vehicle) == 0) return std::nullopt;
  std::optional<std::uint32_t> other;
  const std::uint64_t move = moves.done + moves.granted + 1;
  floor_->each_entered(moves.states[moves.granted], moves.states[moves.granted + 1], [&](CellId cell) {
    for (const Use& use : queues_[cell]) {
      if (other || (use.vehicle == vehicle && use.first == move)) break;
      if (use.vehicle != vehicle) other = use.vehicle;
    }
  });
  return other;
}

bool PassingOrder::grant(std::uint32_t vehicle) {
  if (planned_moves(vehicle) == 0 || waits_for(vehicle)) return false;
  ++vehicles_[vehicle].granted;
  return true;
}

void PassingOrder::leave(std::uint32_t vehicle, CellId cell) {
  auto& queue = queues_[cell];
  COSIVA_EXPECT(!queue.empty() && queue.front().vehicle == vehicle);
  queue.pop_front();
}

void PassingOrder::clear(std::uint32_t vehicle) {
  VehicleMoves& moves = vehicles_[vehicle];
  COSIVA_EXPECT(moves.granted > 0 && !moves.clear);
  const auto needed = floor_->footprint(moves.states[1]);
  for (const CellId cell : floor_->footprint(moves.states[0]))
    if (!std::ranges::binary_search(needed, cell)) leave(vehicle, cell);
  moves.clear = true;
}

void PassingOrder::arrive(std::uint32_t vehicle) {
  if (!is_clear(vehicle)) clear(vehicle);
  VehicleMoves& moves = vehicles_[vehicle];
  for (const CellId cell : floor_->sweep_between(moves.states[0], moves.states[1])) leave(vehicle, cell);
  moves.clear = false;
  moves.states.pop_front();
  --moves.granted;
  ++moves.done;
}

void PassingOrder::archive(Archive& archive) { archive(vehicles_, queues_); }

}  // namespace cosiva::planning
