#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/planning/floor/floor.h"

namespace cosiva::planning {

/// Searches over a floor on which stopped vehicles occupy cells, breadth first.
///
/// Invariant: `occupied_` counts the vehicles on each cell.
class Reach {
 public:
  using Reached = std::vector<std::uint8_t>;  ///< by state; 1: reached
  enum class Direction : std::uint8_t { from, to };

  /// @param floor  must outlive this object
  explicit Reach(const Floor& floor);

  void occupy(std::span<const CellId> cells);
  void release(std::span<const CellId> cells);
  [[nodiscard]] bool is_free(StateId state) const { return is_free(floor_->footprint(state)); }
  /// A move between two free states sweeps no occupied cell.
  [[nodiscard]] bool is_open(StateId from, StateId to) const {
    return !floor_->has_sweeps() || is_free(floor_->sweep_between(from, to));
  }

  /// The states that a vehicle reaches from any of these, themselves included where they are free.
  [[nodiscard]] const Reached& from(std::span<const StateId> states);
  /// The states from which a vehicle reaches one of these, likewise.
  [[nodiscard]] const Reached& to(std::span<const StateId> states);
  /// The number of `wanted` states that a vehicle reaches from one of these, or from which it reaches one of them; the
  /// search ends as soon as that is `enough`.
  [[nodiscard]] std::size_t count(std::span<const StateId> states, Direction direction, const Reached& wanted,
                                  std::size_t enough);
  /// Of all searches: the moves that were examined.
  [[nodiscard]] std::size_t work() const noexcept { return work_; }

 private:
  [[nodiscard]] bool is_free(std::span<const CellId> cells) const;
  void search(std::span<const StateId> states, Direction direction, Reached& reached, const Reached* wanted,
              std::size_t enough);

  const Floor* floor_;
  std::vector<std::uint32_t> occupied_;  // by cell
  Reached from_;
  Reached to_;
  Reached counted_;
  std::vector<StateId> queue_;
  std::size_t found_{0};  // of the wanted states, in the last search
  std::size_t work_{0};
};

}  // namespace cosiva::planning
