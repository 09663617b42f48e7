#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/orders/planned_fleet.h"

namespace cosiva::virtual_side {

/// Where the vehicles that take part in the plan go: to the goal of their mission; without one along the waypoints of
/// their loop, or from station to station. No two go to the same station: where there are more vehicles than stations,
/// they take turns, and go to a waypoint in between.
///
/// Invariant: stations_ and waypoints_ are goals of the plan's floor, and have none in common.
class PlannedGoals {
 public:
  PlannedGoals(OrderContext& context, PlannedFleet& fleet) : context_{context}, fleet_{fleet} {}

  void set_map(const WaypointGraph* map);
  void resize(std::size_t vehicles) { vehicles_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { vehicles_[vehicle] = {}; }

  /// To be called once per tick, for each vehicle that takes part. True: the vehicle has arrived at its goal.
  /// @param waited  since its remaining route was shortest: decides how urgent the vehicle is
  bool choose(VehicleIndex vehicle, SimDuration waited);
  [[nodiscard]] const std::optional<planning::GoalId>& goal(VehicleIndex vehicle) const {
    return vehicles_[vehicle].goal;
  }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Vehicle {
    std::uint64_t revision{0};  // of its mission, for which the goal was chosen; 0: none
    std::optional<planning::GoalId> goal;
    bool to_station{false};  // or along a loop; otherwise in between
    std::uint32_t round{0};  // determines which goal comes next
    SimTime chosen_at{};
    SimTime at_station_at{};  // or when the vehicle began
  };

  bool go(VehicleIndex vehicle, const Mission& mission);
  bool go_round(VehicleIndex vehicle, const Mission& mission);
  [[nodiscard]] std::vector<planning::GoalId> round_of(const zone::Loop& loop) const;
  /// The first station from `first` on, in a circle, that is neither `but` nor another vehicle's goal; none: all are.
  [[nodiscard]] std::optional<planning::GoalId> next_free(VehicleIndex vehicle, std::size_t first,
                                                          std::optional<planning::GoalId> but) const;
  /// The nearest goal, at least so many moves away, that is not another vehicle's; none: all are.
  [[nodiscard]] std::optional<planning::GoalId> nearest_free(VehicleIndex vehicle,
                                                             std::span<const planning::GoalId> goals,
                                                             planning::Distances::Steps moves_min);
  [[nodiscard]] bool is_station(planning::GoalId goal) const;
  [[nodiscard]] bool others_wait_for_station(VehicleIndex vehicle) const;
  /// Of the vehicles that go to no station for the present, it has been at one the longest ago.
  [[nodiscard]] bool is_next_for_station(VehicleIndex vehicle) const;
  [[nodiscard]] bool waits_for_station(VehicleIndex vehicle) const;
  [[nodiscard]] bool is_goal_of_others(planning::GoalId goal, VehicleIndex vehicle) const;
  [[nodiscard]] bool has_arrived(VehicleIndex vehicle) const;
  void set_stops(VehicleIndex vehicle, SimDuration waited);

  OrderContext& context_;
  PlannedFleet& fleet_;
  std::vector<Vehicle> vehicles_;
  std::vector<planning::GoalId> stations_;
  std::vector<planning::GoalId> waypoints_;  // others
};

}  // namespace cosiva::virtual_side
