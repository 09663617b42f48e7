#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/orders/path_positions.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/right_of_way/waypoint_graph.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::virtual_side {

/// Plans along which sections each vehicle drives: the course follows the vehicle's order, and beyond the base its
/// mission. The twin and the traffic get the same course.
///
/// Invariant: a planned course begins in a section that the vehicle's track position belongs to.
class CoursePlanner {
 public:
  CoursePlanner(OrderContext& context, std::vector<OrderSession>& sessions, PathPositions& positions)
      : context_{context}, sessions_{sessions}, positions_{positions} {}

  void resize(std::size_t vehicles) { vehicles_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { vehicles_[vehicle] = {}; }

  /// Takes the course from an order of the vehicle that this server did not send. Returns the end of its base; nothing:
  /// the order's nodes do not determine it.
  [[nodiscard]] std::optional<WaypointIndex> adopt_course(VehicleIndex vehicle, const wire::State& state);
  /// Plans for a vehicle without an order. False: its mission has no route from there.
  [[nodiscard]] bool plan(VehicleIndex vehicle);
  /// The vehicle's mission has changed since its course was planned, or the closed sections have.
  [[nodiscard]] bool is_outdated(VehicleIndex vehicle) const;
  /// Plans anew beyond the base. False: the base leads into a closed section, and the order has been cancelled.
  [[nodiscard]] bool plan_beyond_base(VehicleIndex vehicle);
  /// Finds the course of a vehicle that has left it, up to the end of its base. False: there is none.
  [[nodiscard]] bool regain(VehicleIndex vehicle);
  /// The vehicle has no order and needs none: it is stopped at its goal, or is about to stop there. Arrival is recorded
  /// in the missions.
  [[nodiscard]] bool stays_at_goal(VehicleIndex vehicle);

  /// Begins an extension: `first` and then `rest` are the sections after the extension's first one. Valid until the
  /// next extension, of any vehicle.
  void begin_route(Sections first, Sections rest = {});
  /// Likewise, of a vehicle with a base: the sections after that base.
  void begin_route_beyond_base(VehicleIndex vehicle, zone::TrackPosition position) {
    list_beyond_base(context_.traffic, vehicle, position, route_);
  }
  [[nodiscard]] Sections route() const { return route_; }
  /// The stretch of the route from `at`, which is `passed` sections into it; null: the route ends there. The route is
  /// made longer as the mission permits.
  [[nodiscard]] const WaypointGraph::Stretch* next_stretch(VehicleIndex vehicle, WaypointIndex at, std::size_t passed);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void set_course(VehicleIndex vehicle, zone::Course course);
  /// Cancels the vehicle's order where `released`, the sections of its base, contain a closed one. True: cancelled.
  bool cancel_before_closed(VehicleIndex vehicle, Sections released);
  /// The vehicle has passed the end of its mission's route.
  [[nodiscard]] bool is_past_goal(VehicleIndex vehicle) const;
  /// No route leads the vehicle to the position at which it is to be handed over.
  [[nodiscard]] bool cannot_reach_handover(VehicleIndex vehicle) const;

  struct Vehicle {
    std::uint64_t route_of{0};                ///< revision of the missions for which its course was planned; 0: none
    std::optional<zone::SectionId> no_route;  ///< section from which there is no route
  };
  OrderContext& context_;
  std::vector<OrderSession>& sessions_;
  PathPositions& positions_;
  std::vector<Vehicle> vehicles_;
  std::vector<zone::SectionId> route_;  ///< of the vehicle being processed, after its extension's first section
};

}  // namespace cosiva::virtual_side
