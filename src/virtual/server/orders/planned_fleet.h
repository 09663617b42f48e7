#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/planning/track_fleet/track_fleet.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/orders/path_positions.h"
#include "cosiva/virtual/server/orders/route_follower.h"

namespace cosiva::virtual_side {

/// Which vehicles take part in the plan of the zone's fleet, and how far they have driven. A vehicle joins where it is
/// stopped without an order, on the path or near it, as soon as no other vehicle needs its cells. A vehicle that does
/// not drive for long, or may not get a base, is set aside: the others' plan leads around it. The bodies of vehicles
/// that do not take part, their bases, and closed sections obstruct the plan.
///
/// Invariant: the plan exists where the zone has tracks that are driven both ways, and only vehicles of the registry
/// take part.
class PlannedFleet {
 public:
  PlannedFleet(OrderContext& context, std::vector<OrderSession>& sessions, PathPositions& positions,
               const RouteFollower& follower)
      : context_{context}, sessions_{sessions}, positions_{positions}, follower_{follower} {}

  void set_map(const WaypointGraph* map);
  /// False: the zone has no tracks that are driven both ways.
  [[nodiscard]] bool in_force() const { return fleet_ != nullptr; }
  void resize(std::size_t vehicles);
  void forget(VehicleIndex vehicle);

  /// To be called once per tick, before the goals are chosen: vehicles join, leave, are set aside and taken back.
  void update();
  /// The vehicle has been granted a move, or has another goal: it is expected to drive from now on.
  void begin_move(VehicleIndex vehicle);
  /// When the vehicle was granted a move, arrived at a state, or got another goal last.
  [[nodiscard]] SimTime moved_at(VehicleIndex vehicle) const { return vehicles_[vehicle].moved_at; }
  [[nodiscard]] const Pose2& pose(VehicleIndex vehicle) const { return positions_.reported(vehicle).X_MB; }
  [[nodiscard]] planning::TrackFleet& plan() { return *fleet_; }
  [[nodiscard]] const planning::TrackFleet& plan() const { return *fleet_; }
  /// The vehicle is stopped at the state at which it has arrived, and has no granted moves.
  [[nodiscard]] bool waits_at_state(VehicleIndex vehicle) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Vehicle {
    SimTime moved_at{};
    SimTime drove_at{};       // or need not drive
    bool could_drive{false};  // in the last tick
    Pose2 X_MB{};             // when it drove last
  };

  void join_where_stopped(VehicleIndex vehicle);
  /// The states that a stopped vehicle may be at, or between; empty: none.
  [[nodiscard]] std::vector<planning::StateId> states_around(zone::TrackPosition position) const;
  [[nodiscard]] planning::StateId straight_on(planning::StateId state) const;
  void record_arrivals(VehicleIndex vehicle);
  [[nodiscard]] bool has_reached(VehicleIndex vehicle, planning::StateId state) const;
  /// The vehicle has no order and is where none of its granted moves leads.
  [[nodiscard]] bool is_elsewhere(VehicleIndex vehicle) const;
  void set_aside_or_take_back(VehicleIndex vehicle);
  void find_obstructions();
  void obstruct_by(VehicleIndex vehicle, planning::SweptArea& area) const;

  OrderContext& context_;
  std::vector<OrderSession>& sessions_;
  PathPositions& positions_;
  const RouteFollower& follower_;
  std::unique_ptr<planning::TrackFleet> fleet_;
  std::vector<Vehicle> vehicles_;
  SimTime obstructions_at_{};  // when they were found last
};

}  // namespace cosiva::virtual_side
