#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/virtual/server/orders/course_planner.h"
#include "cosiva/virtual/server/orders/line_join.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/orders/path_positions.h"
#include "cosiva/virtual/server/orders/wait_records.h"
#include "cosiva/virtual/server/orders/yielding.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"

namespace cosiva::virtual_side {

/// Grants bases: an idle vehicle gets the base of a new order, which is then extended along its course, as far as
/// traffic permits. What stops the extension is recorded as the vehicle's wait.
///
/// Invariant: an extension releases at most OrderRules::base_nodes_max stretches.
class RouteFollower {
 public:
  RouteFollower(OrderContext& context, std::vector<OrderSession>& sessions, PathPositions& positions,
                WaitRecords& waits, const LineJoin& joins, CoursePlanner& planner, Yielding& yielding)
      : context_{context},
        sessions_{sessions},
        positions_{positions},
        waits_{waits},
        joins_{joins},
        planner_{planner},
        yielding_{yielding} {}

  /// The vehicle is in a condition to drive orders, and on the zone in force.
  [[nodiscard]] bool may_extend(VehicleIndex vehicle) const;
  /// What is to be sent to the vehicle now; nothing: no message is needed, or possible. Valid until the next call.
  [[nodiscard]] std::optional<BaseExtension> extend(VehicleIndex vehicle);
  /// An off-path vehicle is to join the path at the nearest position. False: another vehicle obstructs the join.
  [[nodiscard]] bool go_to_entry_point(VehicleIndex vehicle);
  /// The vehicle got no order, and stays where its body is.
  void keep_off_path(VehicleIndex vehicle);

 private:
  struct Start {
    WaypointIndex from{no_waypoint};
    double reach_m{};  ///< distance from the vehicle to `from`, negative behind it
  };
  /// Distances of a chain to its stop line, to the next waypoint and to its exit.
  struct ChainAhead {
    double stop_m;
    double next_m;
    double exit_m;
  };
  [[nodiscard]] std::optional<Start> end_of_base(VehicleIndex vehicle);
  [[nodiscard]] std::optional<Start> first_node(VehicleIndex vehicle);
  void extend_from(VehicleIndex vehicle, const Start& from);
  void announce(VehicleIndex vehicle, const Start& from);
  [[nodiscard]] bool leads_too_far(VehicleIndex vehicle);
  [[nodiscard]] bool comes_again(VehicleIndex vehicle, const Start& from, std::size_t passed,
                                 const WaypointGraph::Stretch& stretch) const;
  bool enter(VehicleIndex vehicle, double stop_m, double exit_m);
  /// The base may reach up to the leader: the vehicle's obstacle sensor keeps the distance.
  [[nodiscard]] bool joins_convoy(VehicleIndex vehicle, const ChainAhead& chain);
  void join_convoy(VehicleIndex vehicle);

  OrderContext& context_;
  std::vector<OrderSession>& sessions_;
  PathPositions& positions_;
  WaitRecords& waits_;
  const LineJoin& joins_;
  CoursePlanner& planner_;
  Yielding& yielding_;
  std::vector<const WaypointGraph::Stretch*> base_;     ///< of the vehicle being processed
  std::vector<const WaypointGraph::Stretch*> horizon_;  ///< of the vehicle being processed
  /// Whether the course of the vehicle being processed leads on from where it began to be extended; nothing: not known
  /// yet.
  std::optional<bool> leads_on_;
};

}  // namespace cosiva::virtual_side
