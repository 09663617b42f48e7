#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/planning/floor/distances.h"

namespace cosiva::planning {

/// A goal at which loads appear.
struct Demand {
  GoalId goal{};
  std::uint32_t weight{1};  ///< expected orders, relative to those of the other goals
};

/// Where and when a vehicle will be able to drive to a load.
struct Reserve {
  StateId at{};                   ///< its present state
  std::optional<GoalId> free_at;  ///< a vehicle with an order: where it becomes free
  std::uint32_t free_in{0};       ///< steps until then
};

struct ParkingOptions {
  std::uint32_t vehicles_max = 8;      ///< whose goals are decided again per call, in turn
  std::uint32_t candidates_max = 256;  ///< goals that are tried for each, those nearest to it
  std::uint32_t matched_max = 128;     ///< with more vehicles without order, goals are not exchanged between them
};

/// Chooses goals for vehicles without order, such that the next load, wherever it appears, has a vehicle near: the sum
/// of weight × distance to the nearest vehicle over all demand becomes small (the p-median problem; one vehicle's goal
/// at a time is changed, as in Teitz and Bart 1968). Vehicles that have an order count from where they become free. A
/// goal is changed only where that gains enough, and goals are exchanged between vehicles to shorten their trips.
///
/// Invariant: each goal is that of one vehicle at most, and one of those given.
class Parking {
 public:
  /// @param floor, distances  must outlive this object; `distances` has room for the tables of all goals and demand
  /// @param goals  where vehicles may wait: those in which they obstruct no others
  Parking(const Floor& floor, Distances& distances, std::vector<GoalId> goals, const ParkingOptions& options = {});

  /// Expected weights, at most one for each goal.
  void set_demand(std::vector<Demand> demand);
  /// An order with this pick-up was accepted: the weight of the goal grows by one.
  void count(GoalId pick_up);

  /// Call once per step; vehicles have the same index in each call.
  void plan(std::span<const Reserve> vehicles);
  /// Goal of a vehicle without order; none: it may wait where it is, as long as no other vehicle needs the cells.
  [[nodiscard]] std::optional<GoalId> goal(std::size_t vehicle) const { return goals_[vehicle]; }

 private:
  using Steps = Distances::Steps;

  /// The two least distances to a demand, and the vehicle that has the first one.
  struct Nearest {
    std::size_t vehicle{};
    std::uint32_t first{Distances::unreachable};
    std::uint32_t second{Distances::unreachable};
  };

  void find_nearest();
  [[nodiscard]] std::uint32_t steps(std::size_t vehicle, const Steps* to) const;
  [[nodiscard]] static Steps least(std::span<const StateId> states, const Steps* to);
  void decide(std::size_t vehicle);
  void list_candidates(std::size_t vehicle);
  [[nodiscard]] std::uint64_t cost(std::size_t vehicle, std::span<const StateId> at) const;
  void match();

  const Floor* floor_;
  Distances* distances_;
  ParkingOptions options_;
  std::vector<GoalId> allowed_;
  std::vector<Demand> demand_;                // by goal
  std::vector<const Steps*> to_demand_;       // by demand
  std::vector<Reserve> vehicles_;             // of the present call
  std::vector<Nearest> nearest_;              // by demand
  std::vector<std::optional<GoalId>> goals_;  // by vehicle
  std::vector<std::uint8_t> is_taken_;        // by goal
  std::vector<GoalId> candidates_;
  std::size_t turn_{0};  // the next vehicle whose goal is decided
};

}  // namespace cosiva::planning
