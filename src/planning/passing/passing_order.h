#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/planning/floor/floor.h"

namespace cosiva::planning {

/// The moves that a vehicle has been granted and has not ended.
struct GrantedMoves {
  std::vector<StateId> states;  ///< the state at which the vehicle has arrived last, and the ends of the moves
  bool clear{false};            ///< the vehicle has left what the first move does not need any more
};

/// Which vehicle passes where before which other one: the part of a plan that an execution has to keep, whatever the
/// times are (action dependency graph, Hönig et al. 2019). Each cell has a queue of its uses, in the order of the plan;
/// a vehicle may begin a move when all cells that the move needs are its own, that is when every use before its own has
/// ended. Whether vehicles are early, late or at a standstill, no two are ever granted the same cell; and as a plan
/// without cycles has no circular order, the vehicle whose move is the earliest of those not begun can always begin it.
///
/// A vehicle has a position in its own sequence of moves: `done` moves have ended, `granted` ones may be driven, the
/// rest is planned.
///
/// Invariant: the uses by granted moves that have not ended precede all others in their queues, and in each queue
/// at most one vehicle has such ones.
class PassingOrder {
 public:
  /// @param floor  must outlive this object
  explicit PassingOrder(const Floor& floor);

  /// Begins with vehicles at a standstill in these states, which have no cell in common.
  void begin(std::span<const StateId> states);
  /// Begins with vehicles that have been granted moves before. No two vehicles have a cell in common.
  void begin(std::span<const GrantedMoves> granted);
  [[nodiscard]] std::size_t vehicles() const noexcept { return vehicles_.size(); }

  /// Adds a joint step of the plan: the next state of every vehicle, which may be the present one. Steps are added in
  /// their order; of the vehicles that move in the same step each enters only what another one leaves in it.
  void add_step(std::span<const StateId> next);
  /// Removes what is planned and not granted.
  void drop_planned();

  /// Grants the vehicle's next planned move. False: none is planned, or another vehicle has to pass first
  /// (`waits_for`).
  [[nodiscard]] bool grant(std::uint32_t vehicle);
  /// In its next granted move, the vehicle is clear of the beginning: what the rest of the move does not need is free
  /// for the others.
  void clear(std::uint32_t vehicle);
  [[nodiscard]] bool is_clear(std::uint32_t vehicle) const { return vehicles_[vehicle].clear; }
  /// The vehicle has arrived at the end of its next granted move: what it has left is free for the others.
  void arrive(std::uint32_t vehicle);

  /// State in which the last granted move ends.
  [[nodiscard]] StateId granted_end(std::uint32_t vehicle) const {
    return vehicles_[vehicle].states[vehicles_[vehicle].granted];
  }
  /// State in which the last planned move ends.
  [[nodiscard]] StateId planned_end(std::uint32_t vehicle) const { return vehicles_[vehicle].states.back(); }
  /// The state at which the vehicle has arrived, and those to come: granted ones and planned ones.
  [[nodiscard]] const std::deque<StateId>& states(std::uint32_t vehicle) const { return vehicles_[vehicle].states; }
  /// Moves that have ended, since the beginning.
  [[nodiscard]] std::uint64_t ended_moves(std::uint32_t vehicle) const { return vehicles_[vehicle].done; }
  [[nodiscard]] std::size_t granted_moves(std::uint32_t vehicle) const { return vehicles_[vehicle].granted; }
  [[nodiscard]] std::size_t planned_moves(std::uint32_t vehicle) const {
    return vehicles_[vehicle].states.size() - 1 - vehicles_[vehicle].granted;
  }
  /// The vehicle that has to pass before this one's next planned move, the first found; none: it may begin, or nothing
  /// is planned.
  [[nodiscard]] std::optional<std::uint32_t> waits_for(std::uint32_t vehicle) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// A vehicle's stay in a cell: from the beginning of a move to the end of another one.
  struct Use {
    std::uint32_t vehicle{};
    std::uint64_t first{};  // number of the move that enters the cell
  };
  struct VehicleMoves {
    std::deque<StateId> states;  // of the moves that have not ended, after the state arrived at
    std::size_t granted{0};      // of them
    std::uint64_t done{0};       // moves that have ended, since `begin`
    bool clear{false};           // has left what the first move does not need any more
  };

  void enter(std::uint32_t vehicle, StateId from, StateId to, std::uint64_t move);
  void leave(std::uint32_t vehicle, CellId cell);

  const Floor* floor_;
  std::vector<VehicleMoves> vehicles_;
  std::vector<std::deque<Use>> queues_;  // by cell
};

}  // namespace cosiva::planning
