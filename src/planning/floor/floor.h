#pragma once

#include <algorithm>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::planning {

using StateId = std::uint32_t;  ///< index of a state of a floor
using CellId = std::uint32_t;   ///< index of a cell of a floor
using GoalId = std::uint32_t;   ///< index of a goal of a floor

/// Of a vehicle without destination.
inline constexpr GoalId no_goal = std::numeric_limits<GoalId>::max();

/// A move, by its ends.
struct FloorMove {
  StateId from{};
  StateId to{};
  friend bool operator==(const FloorMove&, const FloorMove&) = default;
  friend bool operator<(const FloorMove& a, const FloorMove& b) {
    return a.from != b.from ? a.from < b.from : a.to < b.to;
  }
};

/// What is obstructed on a floor.
struct Obstruction {
  std::vector<CellId> cells;     ///< occupied by something that is no vehicle of the plan
  std::vector<FloorMove> moves;  ///< that cannot be made for other reasons
  friend bool operator==(const Obstruction&, const Obstruction&) = default;
};

/// The description from which a Floor is made.
struct FloorDescription {
  struct Move {
    StateId to{};
    std::vector<CellId> sweep;  ///< cells that the body passes between, in addition to those of both ends
  };
  /// A vehicle that waits at one point with one heading.
  struct State {
    std::vector<CellId> footprint;  ///< cells that the body occupies; at least one
    std::vector<Move> moves;        ///< of one step each, to different states; waiting needs none
  };

  std::uint32_t cells{};
  std::vector<State> states;
  std::vector<std::vector<StateId>> goals;  ///< each a set of states: in any of them a vehicle has arrived
};

/// A floor as a planner needs it: states in which a vehicle can wait, moves of one step from state to state, and cells,
/// each of which one body occupies at a time. Two bodies touch only where their states' footprints, or a footprint and
/// the sweep of a move, have a cell in common. A two-way track is two states with one footprint, a long body a
/// footprint of several cells, a turn on the spot a move whose sweep is the disc that the body needs.
///
/// Invariant: all indices are valid; footprints and sweeps are sorted, without repetition; no footprint is empty.
class Floor {
 public:
  /// Fails ("floor.index", "floor.footprint", "floor.move", "floor.goal") and names the state, move or goal.
  [[nodiscard]] static Result<Floor> make(const FloorDescription& description);
  /// This floor without the moves that are obstructed, or that enter an obstructed cell; states, cells and goals are
  /// the same. A vehicle that is in an obstructed cell may leave it.
  [[nodiscard]] Floor without(const Obstruction& obstruction) const;

  [[nodiscard]] std::uint32_t states() const noexcept { return static_cast<std::uint32_t>(footprints_.size()); }
  [[nodiscard]] std::uint32_t cells() const noexcept { return cells_; }
  [[nodiscard]] std::uint32_t goals() const noexcept { return static_cast<std::uint32_t>(goals_.size()); }

  /// Cells of a body in this state.
  [[nodiscard]] std::span<const CellId> footprint(StateId state) const noexcept { return footprints_[state]; }
  /// States that are one move away, in the description's order.
  [[nodiscard]] std::span<const StateId> successors(StateId state) const noexcept { return successors_[state]; }
  /// States from which one move leads to this one.
  [[nodiscard]] std::span<const StateId> predecessors(StateId state) const noexcept { return predecessors_[state]; }
  /// Of the move to `successors(state)[move]`: the cells passed besides those of both footprints.
  [[nodiscard]] std::span<const CellId> sweep(StateId state, std::size_t move) const noexcept {
    return sweeps_[successors_.begin_of(state) + move];
  }
  /// Of the move between these states, which exists (checked); of waiting: none.
  [[nodiscard]] std::span<const CellId> sweep_between(StateId from, StateId to) const;
  /// Calls visit(cell) for each cell that the move needs besides those of its beginning.
  template <typename Visit>
  void each_entered(StateId from, StateId to, Visit&& visit) const {
    const auto own = footprint(from);
    for (const CellId cell : footprint(to))
      if (!std::ranges::binary_search(own, cell)) visit(cell);
    for (const CellId cell : sweep_between(from, to)) visit(cell);
  }
  /// False: no move of this floor passes cells besides those of its ends.
  [[nodiscard]] bool has_sweeps() const noexcept { return !sweeps_.empty(); }
  [[nodiscard]] std::span<const StateId> goal(GoalId goal) const noexcept { return goals_[goal]; }

 private:
  /// Lists of different lengths, one after the other in one array.
  /// Invariant: list i is values_[begins_[i]] to before values_[begins_[i + 1]]; the last begin is the number of
  /// values.
  class Lists {
   public:
    void add(std::span<const std::uint32_t> list);
    [[nodiscard]] std::size_t size() const noexcept { return begins_.size() - 1; }
    [[nodiscard]] bool empty() const noexcept { return values_.empty(); }
    [[nodiscard]] std::uint32_t begin_of(std::size_t list) const noexcept { return begins_[list]; }
    [[nodiscard]] std::span<const std::uint32_t> operator[](std::size_t list) const noexcept {
      return {values_.data() + begins_[list], values_.data() + begins_[list + 1]};
    }

   private:
    std::vector<std::uint32_t> begins_{0};
    std::vector<std::uint32_t> values_;
  };

  Floor() = default;

  std::uint32_t cells_{};
  Lists footprints_;
  Lists successors_;
  Lists predecessors_;
  Lists sweeps_;  // one list per move, in the order of successors_
  Lists goals_;
};

}  // namespace cosiva::planning
