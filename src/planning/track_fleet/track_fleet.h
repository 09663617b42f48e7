#pragma once

#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/planning/fleet/fleet_plan.h"
#include "cosiva/planning/track/track_floor.h"

namespace cosiva::planning {

/// The vehicles on the tracks of a zone, and their plan while vehicles join and leave, stop for long and drive on, and
/// while something else obstructs tracks. A FleetPlan has a fixed number of vehicles, all of which can drive; with each
/// such change another one begins from the moves granted so far.
///
/// A vehicle that is set aside, because it does not drive, keeps the cells of its granted moves. The others' plan leads
/// around it, and where there is no detour, their stops are not reachable.
///
/// Invariant: no two vehicles that take part need the same cell for their granted moves. The states of these moves are
/// either in the plan or in `members_`.
class TrackFleet {
 public:
  TrackFleet(const zone::TrafficZone& zone, const FleetPlanOptions& options, std::uint64_t seed);
  TrackFleet(const TrackFleet&) = delete;  // the plan refers to the floors
  TrackFleet& operator=(const TrackFleet&) = delete;

  [[nodiscard]] const TrackFloor& track() const noexcept { return track_; }
  void resize(std::size_t vehicles) { members_.resize(vehicles); }

  // --- which vehicles take part ---
  /// @param granted  the state at which the vehicle is, or has been last, and the ends of the moves that it may drive
  /// False: another vehicle needs one of these cells; the vehicle does not take part.
  [[nodiscard]] bool join(Vehicle vehicle, std::span<const StateId> granted);
  void leave(Vehicle vehicle);
  [[nodiscard]] bool takes_part(Vehicle vehicle) const { return members_[vehicle].part != Part::none; }
  /// @param aside  false: it can drive again
  void set_aside(Vehicle vehicle, bool aside);
  [[nodiscard]] bool is_set_aside(Vehicle vehicle) const { return members_[vehicle].part == Part::aside; }
  /// What is obstructed by others than the vehicles that take part; replaces what was before.
  void obstruct(Obstruction obstruction);

  // --- the plan, see FleetPlan ---
  void set_stops(Vehicle vehicle, std::span<const Stop> stops, std::uint32_t urgency);
  /// All stops of the vehicle can be reached, were no other vehicle in the plan.
  [[nodiscard]] bool reachable(Vehicle vehicle) const;
  void plan();
  /// See FleetPlan::replan.
  void replan();
  /// Moves from the state to the goal, were nothing obstructed; Distances::unreachable: no moves lead there.
  [[nodiscard]] Distances::Steps moves_to(GoalId goal, StateId from) { return distances_.to(goal)[from]; }

  // --- its execution ---
  /// The state at which the vehicle has arrived, and those to come: granted ones and planned ones.
  [[nodiscard]] const std::deque<StateId>& states(Vehicle vehicle) const;
  [[nodiscard]] std::size_t granted_moves(Vehicle vehicle) const;
  /// See PassingOrder::clear. May be repeated.
  void clear(Vehicle vehicle);
  void arrive(Vehicle vehicle);
  [[nodiscard]] bool grant(Vehicle vehicle);
  /// See PassingOrder::waits_for.
  [[nodiscard]] std::optional<Vehicle> waits_for(Vehicle vehicle) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  enum class Part : std::uint8_t { none, planned, aside };
  struct Member {
    Part part{Part::none};
    Vehicle slot{0};             // in the plan
    std::deque<StateId> states;  // of a vehicle that is not in the plan, or not yet: those of its granted moves
    bool clear{false};           // likewise
    std::vector<Stop> stops;
    std::uint32_t urgency{0};
  };

  [[nodiscard]] bool is_in_plan(Vehicle vehicle) const {
    return members_[vehicle].part == Part::planned && members_[vehicle].states.empty();
  }
  [[nodiscard]] GrantedMoves granted(Vehicle vehicle) const;
  /// Holds the states of the vehicle's granted moves here, not in the plan.
  void hold(Vehicle vehicle);
  void begin_again();
  /// Without vehicles, for the floor without `closed_`.
  void make_plan();

  TrackFloor track_;
  FleetPlanOptions options_;
  std::uint64_t seed_;
  Distances distances_;
  Obstruction obstruction_;
  std::vector<Member> members_;
  std::vector<Vehicle> slots_;  // the vehicle of each slot of the plan
  bool changed_{false};         // since the plan has begun
  Obstruction closed_;          // of the floor that the plan is for
  std::unique_ptr<Floor> open_;
  std::unique_ptr<FleetPlan> plan_;
};

}  // namespace cosiva::planning
