#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/planning/floor/floor.h"

namespace cosiva::planning {

using Vehicle = std::uint32_t;  ///< index of a vehicle in the fleet that is planned
inline constexpr Vehicle no_vehicle = std::numeric_limits<Vehicle>::max();

/// A vehicle whose path contradicts another one's, and the step in which it first does.
struct Conflict {
  Vehicle vehicle{};
  std::uint32_t step{};
};

/// Where each vehicle is planned to be in each step of a window, by cell, so that one lookup shows which vehicle
/// obstructs a move. Step 0 is the present: a vehicle occupies its cells of then even while it has no path.
///
/// Two paths contradict each other where both vehicles occupy a cell at the end of the same step, where one sweeps a
/// cell that the other occupies before or after that step or sweeps, too, and where vehicles change cells: each
/// enters a cell that another one leaves in the same step, in a closed cycle. (Each of them would wait for the next one
/// to leave first.) `cycles` permits cycles of three and more.
///
/// Invariant: `owners_` names for each step and cell the vehicle with a path that occupies it, and no other vehicle's
/// path does.
class Reservations {
 public:
  /// @param floor    must outlive this object
  /// @param horizon  steps after the present, at least 1
  Reservations(const Floor& floor, std::uint32_t horizon, bool cycles);

  [[nodiscard]] std::uint32_t horizon() const noexcept { return horizon_; }
  [[nodiscard]] std::size_t vehicles() const noexcept { return has_path_.size(); }

  /// Begins with these present states, which have no cell in common, and no paths.
  void begin(std::span<const StateId> present);

  /// @param path  horizon + 1 states from the present one, free of conflicts with all paths
  void add(Vehicle vehicle, std::span<const StateId> path);
  void remove(Vehicle vehicle);
  [[nodiscard]] bool has_path(Vehicle vehicle) const noexcept { return has_path_[vehicle] != 0; }
  /// The last path added.
  [[nodiscard]] std::span<const StateId> path(Vehicle vehicle) const noexcept {
    return {paths_.data() + std::size_t{vehicle} * length(), length()};
  }

  /// Occupies the cell at the end of the step, or none.
  [[nodiscard]] Vehicle owner(std::uint32_t step, CellId cell) const noexcept {
    return owners_[std::size_t{step} * floor_->cells() + cell];
  }
  /// The move (or wait) in this step contradicts no path; vehicles without path do not count.
  /// @param step  the one that ends in `to`, from 1 to the horizon
  [[nodiscard]] bool permits(Vehicle vehicle, StateId from, StateId to, std::uint32_t step) const;
  /// Vehicles with a path that this path contradicts, each once, appended to `found`; ends early when there are more
  /// than `limit`.
  void conflicts(Vehicle vehicle, std::span<const StateId> path, std::size_t limit, std::vector<Conflict>& found) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] std::size_t length() const noexcept { return horizon_ + std::size_t{1}; }
  [[nodiscard]] std::size_t slot(std::uint32_t step, CellId cell) const noexcept {
    return std::size_t{step} * floor_->cells() + cell;
  }
  void write(std::span<const StateId> path, Vehicle owner);
  [[nodiscard]] std::span<const CellId> sweep_of(StateId from, StateId to) const;
  /// Calls `found(vehicle)` for each vehicle that the move contradicts; ends when it returns false.
  template <typename Found>
  bool each_conflict(Vehicle vehicle, StateId from, StateId to, std::uint32_t step, Found&& found) const;
  template <typename Found>
  bool each_swept(Vehicle vehicle, StateId from, StateId to, std::uint32_t step, Found&& found) const;
  /// The move of `follower` in this step enters a cell of `from`, or leads to one by the moves of further vehicles.
  [[nodiscard]] bool enters(Vehicle follower, Vehicle vehicle, StateId from, std::uint32_t step) const;

  const Floor* floor_;
  std::uint32_t horizon_;
  bool cycles_;
  std::vector<StateId> paths_;                  // vehicles × (horizon + 1)
  std::vector<std::uint8_t> has_path_;          // by vehicle
  std::vector<Vehicle> owners_;                 // (horizon + 1) × cells
  std::vector<Vehicle> sweepers_;               // (horizon + 2) × cells; empty on a floor without sweeps
  std::vector<StateId> present_;                // of the last `begin`
  mutable std::vector<std::uint32_t> visited_;  // by vehicle: the last chain that led to it
  mutable std::vector<Vehicle> open_;           // vehicles of a chain, to be examined
  mutable std::uint32_t chain_{0};
};

}  // namespace cosiva::planning
