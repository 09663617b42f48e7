#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/orders/path_positions.h"
#include "cosiva/virtual/server/orders/planned_fleet.h"
#include "cosiva/virtual/server/orders/planned_goals.h"
#include "cosiva/virtual/server/orders/route_follower.h"
#include "cosiva/virtual/server/orders/route_waits.h"
#include "cosiva/virtual/server/orders/wait_records.h"

namespace cosiva::virtual_side {

/// Grants bases by a plan of the whole fleet (planning/fleet), on zones with tracks that are driven both ways: there a
/// vehicle that drives as far as it can may obstruct all others for ever. Bases end where the plan grants nothing more;
/// nothing is announced beyond, because the plan may change.
///
/// Invariant: a base leads along granted moves.
class PlannedRoutes {
 public:
  PlannedRoutes(OrderContext& context, std::vector<OrderSession>& sessions, PathPositions& positions,
                RouteFollower& follower, WaitRecords& waits)
      : context_{context},
        sessions_{sessions},
        positions_{positions},
        follower_{follower},
        waits_{waits},
        fleet_{context, sessions, positions, follower},
        goals_{context, fleet_} {}

  void set_map(const WaypointGraph* map);
  /// False: the zone has no tracks that are driven both ways, and RouteFollower grants bases.
  [[nodiscard]] bool in_force() const { return fleet_.in_force(); }
  void resize(std::size_t vehicles);
  void forget(VehicleIndex vehicle);

  /// To be called once per tick, before the vehicles are extended.
  void update();
  /// What is to be sent to the vehicle now; nothing: no message is needed, or possible. Valid until the next call.
  [[nodiscard]] std::optional<BaseExtension> extend(VehicleIndex vehicle);
  /// Of all zones with such tracks so far.
  [[nodiscard]] const RouteWaits& route_waits() const { return route_waits_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void replan_when_it_pays();
  [[nodiscard]] std::optional<RouteWaits::Route> route_of(VehicleIndex vehicle);
  /// Grants moves until the base is long enough. Returns how many.
  std::size_t grant(VehicleIndex vehicle);
  /// The base of a new order, from the granted moves; nothing: the vehicle cannot begin one at present.
  [[nodiscard]] std::optional<BaseExtension> begin_order(VehicleIndex vehicle);
  /// Fills `base_` with the moves from `move` on. False: they do not correspond to stretches of the zone.
  [[nodiscard]] bool fill_base(VehicleIndex vehicle, WaypointIndex from, std::size_t move);
  [[nodiscard]] WaypointIndex waypoint_of(VehicleIndex vehicle, std::size_t state) const;
  [[nodiscard]] const WaypointGraph::Stretch* stretch_of(VehicleIndex vehicle, WaypointIndex from,
                                                         std::size_t move) const;
  /// The course of twin and traffic follows the granted moves.
  void set_course(VehicleIndex vehicle, WaypointIndex end);

  OrderContext& context_;
  std::vector<OrderSession>& sessions_;
  PathPositions& positions_;
  RouteFollower& follower_;
  WaitRecords& waits_;
  PlannedFleet fleet_;
  PlannedGoals goals_;
  RouteWaits route_waits_;
  SimTime replanned_at_{};
  std::vector<const WaypointGraph::Stretch*> base_;  // of the vehicle being processed
};

}  // namespace cosiva::virtual_side
