#include "cosiva/planning/floor/floor.h"

#include <algorithm>
#include <set>
#include <string>

#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

std::vector<std::uint32_t> sorted(std::vector<std::uint32_t> list) {
  std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

std::string name_of(const char* kind, std::size_t index) { return std::string{kind} + " " + std::to_string(index); }

Result<void> check_state(const FloorDescription& description, std::size_t index) {
  const auto valid_cell = [&](CellId cell) { return cell < description.cells; };
  const auto& state = description.states[index];
  const std::string name = name_of("state", index);
  if (state.footprint.empty()) return fail("floor.footprint", name + " occupies no cell");
  if (!std::ranges::all_of(state.footprint, valid_cell))
    return fail("floor.index", name + " occupies a cell that does not exist");
  for (const auto& move : state.moves) {
    if (move.to >= description.states.size() || !std::ranges::all_of(move.sweep, valid_cell))
      return fail("floor.index", "a move of " + name + " has an end or a cell that does not exist");
    if (move.to == index) return fail("floor.move", "a move of " + name + " ends where it begins");
    if (std::ranges::count(state.moves, move.to, &FloorDescription::Move::to) > 1)
      return fail("floor.move", name + " has several moves to the same state");
  }
  return {};
}

Result<void> check(const FloorDescription& description) {
  for (std::size_t i = 0; i < description.states.size(); ++i)
    if (auto good = check_state(description, i); !good) return good;
  for (std::size_t i = 0; i < description.goals.size(); ++i) {
    const auto valid = [&](StateId state) { return state < description.states.size(); };
    if (description.goals[i].empty() || !std::ranges::all_of(description.goals[i], valid))
      return fail("floor.goal", name_of("goal", i) + " has no state, or one that does not exist");
  }
  return {};
}

}  // namespace

void Floor::Lists::add(std::span<const std::uint32_t> list) {
  COSIVA_EXPECT(begins_.back() == values_.size());
  values_.insert(values_.end(), list.begin(), list.end());
  begins_.push_back(static_cast<std::uint32_t>(values_.size()));
}

std::span<const CellId> Floor::sweep_between(StateId from, StateId to) const {
  if (from == to) return {};
  const auto ends = successors(from);
  const auto move = std::ranges::find(ends, to);
  COSIVA_EXPECT(move != ends.end());
  return sweep(from, static_cast<std::size_t>(move - ends.begin()));
}

Result<Floor> Floor::make(const FloorDescription& description) {
  if (auto good = check(description); !good) return tl::unexpected{good.error()};
  Floor floor;
  floor.cells_ = description.cells;
  std::vector<std::vector<StateId>> predecessors(description.states.size());
  for (StateId id = 0; id < description.states.size(); ++id) {
    const auto& state = description.states[id];
    const auto footprint = sorted(state.footprint);
    floor.footprints_.add(footprint);
    std::vector<StateId> ends;
    for (const auto& move : state.moves) {
      ends.push_back(move.to);
      predecessors[move.to].push_back(id);
      const auto far_end = sorted(description.states[move.to].footprint);
      auto sweep = sorted(move.sweep);
      std::erase_if(sweep, [&](CellId cell) {
        return std::ranges::binary_search(footprint, cell) || std::ranges::binary_search(far_end, cell);
      });
      floor.sweeps_.add(sweep);
    }
    floor.successors_.add(ends);
  }
  for (const auto& list : predecessors) floor.predecessors_.add(list);
  for (const auto& goal : description.goals) floor.goals_.add(sorted(goal));
  COSIVA_EXPECT(floor.predecessors_.size() == floor.footprints_.size());
  return floor;
}

Floor Floor::without(const Obstruction& obstruction) const {
  std::vector<bool> occupied(cells_, false);
  for (const CellId cell : obstruction.cells) occupied[cell] = true;
  const std::set<FloorMove> closed{obstruction.moves.begin(), obstruction.moves.end()};
  Floor floor;
  floor.cells_ = cells_;
  floor.footprints_ = footprints_;
  floor.goals_ = goals_;
  std::vector<std::vector<StateId>> predecessors(states());
  for (StateId from = 0; from < states(); ++from) {
    std::vector<StateId> ends;
    for (std::size_t move = 0; move < successors(from).size(); ++move) {
      const StateId to = successors(from)[move];
      bool open = !closed.contains({from, to});
      each_entered(from, to, [&](CellId cell) { open = open && !occupied[cell]; });
      if (!open) continue;
      ends.push_back(to);
      predecessors[to].push_back(from);
      floor.sweeps_.add(sweep(from, move));
    }
    floor.successors_.add(ends);
  }
  for (const auto& list : predecessors) floor.predecessors_.add(list);
  COSIVA_EXPECT(floor.predecessors_.size() == floor.footprints_.size());
  return floor;
}

}  // namespace cosiva::planning
