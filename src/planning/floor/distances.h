#pragma once

#include <cstdint>
#include <limits>
#include <list>
#include <vector>

#include "cosiva/planning/floor/floor.h"

namespace cosiva::planning {

/// Least number of moves from each state of a floor to its goals, on an otherwise empty floor. The table of a goal is
/// made with its first use (one search backwards over the whole floor) and remains while there is room.
///
/// Invariant: a table in `tables_` is complete, and in `recent_` exactly once.
class Distances {
 public:
  using Steps = std::uint16_t;
  static constexpr Steps unreachable = std::numeric_limits<Steps>::max();

  /// @param floor       must outlive this object
  /// @param bytes_max   of all tables; at least one table remains
  explicit Distances(const Floor& floor, std::size_t bytes_max = std::size_t{1} << 30U);

  /// By state; `unreachable` where no moves lead to the goal, and from 65 535 moves on. Valid until `to` has been
  /// called for as many other goals as have room, that is at least `tables_max()`.
  [[nodiscard]] const Steps* to(GoalId goal);
  [[nodiscard]] std::size_t tables_max() const noexcept { return tables_max_; }

 private:
  struct Table {
    std::vector<Steps> steps;  // empty: not in memory
    std::list<GoalId>::iterator recent;
  };

  void search(GoalId goal, std::vector<Steps>& steps);

  const Floor* floor_;
  std::size_t tables_max_;
  std::vector<Table> tables_;   // by goal
  std::list<GoalId> recent_;    // those in memory, the last used first
  std::vector<StateId> queue_;  // of a search; a member, to allocate it once
};

}  // namespace cosiva::planning
