#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/registry/registry.h"

namespace cosiva::virtual_side {

/// A vehicle's last reported pose relative to the circuit.
struct ReportedPose {
  std::optional<zone::TrackPosition> position;  ///< nearest on the circuit
  double off_m{};                               ///< distance from that position
  double heading_off_rad{};                     ///< from the direction of the section
  Pose2 X_MB{};                                 ///< body in map
};

/// Where each vehicle is: on the path, off the path, or driving onto the path towards its entry point.
///
/// Invariant: a vehicle that has an entry point has a track position.
class PathPositions {
 public:
  PathPositions(OrderContext& context, const std::vector<OrderSession>& sessions)
      : context_{context}, sessions_{sessions} {}

  void resize(std::size_t vehicles) { vehicles_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { vehicles_[vehicle] = {}; }
  [[nodiscard]] std::size_t size() const { return vehicles_.size(); }

  /// Stores a report, and the vehicle's position in the traffic.
  void set_reported(VehicleIndex vehicle, const ReportedPose& reported);
  [[nodiscard]] const ReportedPose& reported(VehicleIndex vehicle) const { return vehicles_[vehicle].reported; }
  /// Replaces the track position where a pose belongs to several sections. The vehicle has one already.
  void set_position(VehicleIndex vehicle, zone::TrackPosition position);

  /// The position at which an off-path vehicle joins the path; nothing: the vehicle is on the path, or has not been
  /// sent there.
  [[nodiscard]] const std::optional<zone::TrackPosition>& entry_point(VehicleIndex vehicle) const {
    return vehicles_[vehicle].entry_point;
  }
  void set_entry_point(VehicleIndex vehicle, zone::TrackPosition position);
  /// @param off_m  distance of the vehicle from that position
  void set_entry_point(VehicleIndex vehicle, zone::TrackPosition position, double off_m);
  /// True: the vehicle had an entry point.
  bool clear_entry_point(VehicleIndex vehicle);

  [[nodiscard]] bool is_off_path(VehicleIndex vehicle) const;
  /// The vehicle is a CoSiVA vehicle that joins the path, or that has to before it can drive along the path.
  [[nodiscard]] bool goes_onto_line(VehicleIndex vehicle) const;
  /// By its last state and by its twin.
  [[nodiscard]] bool is_stopped(VehicleIndex vehicle) const;
  /// The pose of the vehicle's twin at this time, body in map.
  [[nodiscard]] Pose2 body(VehicleIndex vehicle) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// Relates the reported pose to the entry point until the vehicle is on the path.
  void follow_line(VehicleIndex vehicle);

  struct Vehicle {
    ReportedPose reported;
    std::optional<zone::TrackPosition> entry_point;
  };
  OrderContext& context_;
  const std::vector<OrderSession>& sessions_;
  std::vector<Vehicle> vehicles_;
};

/// Whether the vehicle's own obstacle sensor detects the body of `ahead`, so that the sensor keeps the distance.
[[nodiscard]] bool detects(const Registry& registry, VehicleIndex vehicle, VehicleIndex ahead);

}  // namespace cosiva::virtual_side
