#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/missions/missions.h"
#include "cosiva/virtual/server/orders/course_planner.h"
#include "cosiva/virtual/server/orders/line_join.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/orders/path_positions.h"
#include "cosiva/virtual/server/orders/planned_routes.h"
#include "cosiva/virtual/server/orders/route_follower.h"
#include "cosiva/virtual/server/orders/wait_analysis.h"
#include "cosiva/virtual/server/orders/wait_graph.h"
#include "cosiva/virtual/server/orders/wait_records.h"
#include "cosiva/virtual/server/orders/yielding.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// Extends orders along each vehicle's mission: in each tick RouteFollower grants every vehicle the base that traffic
/// permits, and the vehicle's OrderSession sends it. The other parts bring off-path vehicles onto the path (LineJoin),
/// plan courses (CoursePlanner), find which vehicle waits for which (WaitAnalysis) and resolve deadlocks (Yielding). On
/// zones with two-way tracks PlannedRoutes grants the bases, by a plan of the whole fleet.
///
/// Invariant: every part knows the same vehicles, and has one session for each.
class OrderManager {
 public:
  OrderManager(Registry& registry, Traffic& traffic, MessagePublisher& publisher, InstantActionSender& action_sender,
               Missions& missions, Simulator& simulator, const OrderRules& rules = {})
      : context_{registry, traffic, publisher, action_sender, missions, simulator, rules} {}
  OrderManager(const OrderManager&) = delete;  // the parts refer to each other
  OrderManager& operator=(const OrderManager&) = delete;

  void set_map(const WaypointGraph* map);  ///< cancels the orders on the old zone
  void resize(std::size_t vehicles);

  /// To be called after the proxy has stored the state. `before` is the previous state, if any.
  void on_state(VehicleIndex vehicle, const wire::State* before);
  /// An operator has cancelled: the present order gets no more updates.
  void stop_extending(VehicleIndex vehicle) { sessions_[vehicle].stop_extending(); }
  /// The vehicle has been removed.
  void forget(VehicleIndex vehicle);
  /// @param drive     send orders; otherwise only pending orders are tracked
  /// @param send_off  send orders to vehicles that have none
  void tick(bool drive, bool send_off, SimDuration lost_after);

  /// To be called at each report of the vehicle.
  void set_reported_pose(VehicleIndex vehicle, const ReportedPose& reported) {
    positions_.set_reported(vehicle, reported);
  }

  /// The vehicle has an order on the zone in force.
  [[nodiscard]] bool has_order(VehicleIndex vehicle) const { return sessions_[vehicle].is_running(); }
  [[nodiscard]] bool is_off_path(VehicleIndex vehicle) const { return positions_.goes_onto_line(vehicle); }
  /// Which vehicle waits for which, and why.
  [[nodiscard]] const WaitAnalysis& waits() const { return analysis_; }
  /// The longest wait so far.
  [[nodiscard]] SimDuration longest_wait() const { return records_.longest(); }

  /// Bases follow from a plan of the whole fleet, on a zone with tracks that are driven both ways; null: they do not.
  [[nodiscard]] const PlannedRoutes* planned() const { return planned_.in_force() ? &planned_ : nullptr; }

  /// The cost of yielding so that `waits`, all of which are for this vehicle, end: the distance to back up [m], 0 for
  /// all other means. Nothing: the vehicle cannot yield by `means`.
  [[nodiscard]] std::optional<double> can_yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits) const {
    // By plan, no vehicle has to yield, and none leaves the cells that it has been granted.
    return planned_.in_force() ? std::nullopt : yielding_.can_yield(vehicle, means, waits);
  }
  /// False: the means could not be applied.
  bool yield(VehicleIndex vehicle, Means means, std::span<const Wait> waits) {
    return yielding_.yield(vehicle, means, waits);
  }
  /// The vehicle is stopped for others, or is backing up for them.
  [[nodiscard]] bool yields(VehicleIndex vehicle) const { return yielding_.yields(vehicle); }
  /// The deadlock is resolved: the vehicle may use the avoided sections again.
  void need_not_avoid(VehicleIndex vehicle) { context_.missions.need_not_avoid(vehicle); }

  /// Order messages since the start of the server.
  struct Counters {
    std::uint64_t orders{0};  ///< new orders
    std::uint64_t updates{0};
    std::uint64_t repeated{0};
  };
  [[nodiscard]] const Counters& counters() const { return counters_; }
  void fold(Digest& digest) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void adopt(VehicleIndex vehicle, const wire::State& state);
  void drop(VehicleIndex vehicle);
  void step(VehicleIndex vehicle, bool drive, bool send_off);
  /// Whether the vehicle gets no base in this tick, whatever the traffic is.
  [[nodiscard]] bool stays(VehicleIndex vehicle, bool drive, bool send_off);

  OrderContext context_;
  std::vector<OrderSession> sessions_;
  PathPositions positions_{context_, sessions_};
  WaitRecords records_;
  LineJoin joins_{context_, sessions_, positions_, records_};
  WaitAnalysis analysis_{context_, sessions_, positions_, joins_, records_};
  CoursePlanner planner_{context_, sessions_, positions_};
  Yielding yielding_{context_, sessions_, positions_, joins_, records_};
  RouteFollower follower_{context_, sessions_, positions_, records_, joins_, planner_, yielding_};
  PlannedRoutes planned_{context_, sessions_, positions_, follower_, records_};
  Counters counters_;
};

}  // namespace cosiva::virtual_side
