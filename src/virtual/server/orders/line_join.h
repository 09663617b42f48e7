#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/orders/path_positions.h"
#include "cosiva/virtual/server/orders/wait_records.h"
#include "cosiva/virtual/server/registry/proxy.h"

namespace cosiva::virtual_side {

/// Brings off-path vehicles onto the path: finds out whether an entry position is free, sends a vehicle to another
/// position (joinLine) when the nearest one is not, and keeps on-path vehicles clear of the bodies of the others.
///
/// Invariant: at most one joinLine of a vehicle is pending.
class LineJoin {
 public:
  LineJoin(OrderContext& context, const std::vector<OrderSession>& sessions, PathPositions& positions,
           const WaitRecords& waits)
      : context_{context}, sessions_{sessions}, positions_{positions}, waits_{waits} {}

  void resize(std::size_t vehicles) { vehicles_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { vehicles_[vehicle] = {}; }
  /// To be called once per tick: finds the vehicles whose bodies count, not their track positions.
  void find_neighbours();

  /// The vehicle has a joinLine that has not ended for this server.
  [[nodiscard]] bool is_pending(VehicleIndex vehicle) const { return vehicles_[vehicle].handle != 0; }
  /// Follows a pending joinLine. False: there is none, or it has just ended.
  [[nodiscard]] bool continue_joining(VehicleIndex vehicle);
  /// Sends the vehicle to another position on the path when the nearest one is not free.
  void try_other_positions(VehicleIndex vehicle);
  /// @param drives_on  only positions from which it can continue; otherwise to make room
  /// @param within_m   of the nearest position, along the path
  bool join_elsewhere(VehicleIndex vehicle, bool drives_on, double within_m);
  /// The vehicle no longer joins the path.
  void end(VehicleIndex vehicle);

  /// The first vehicle that prevents this vehicle from joining the path at `entry_point`; no_vehicle: none.
  [[nodiscard]] VehicleIndex obstructs_line_entry(VehicleIndex vehicle, zone::TrackPosition entry_point) const;
  /// An off-path vehicle, or one joining the path, that prevents this vehicle from driving from `from_m` to `to_m`
  /// ahead.
  [[nodiscard]] VehicleIndex off_path_obstruction(VehicleIndex vehicle, double from_m, double to_m) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] bool is_free_entry(VehicleIndex vehicle, zone::TrackPosition position, bool drives_on);
  /// A vehicle stopped at X_MB would prevent `other` from joining the path.
  [[nodiscard]] bool blocks_entry(VehicleIndex other, const Pose2& X_MB) const;
  [[nodiscard]] std::vector<zone::TrackPosition> positions_near(VehicleIndex vehicle, double within_m) const;
  /// The position where an off-path vehicle is to join the path, or would join if it were let in.
  [[nodiscard]] std::optional<zone::TrackPosition> comes_onto_line_at(VehicleIndex vehicle) const;

  struct Vehicle {
    InstantActionSender::ActionHandle handle{0};  ///< of the pending joinLine; 0: none
    SimTime sent_at{};
  };
  OrderContext& context_;
  const std::vector<OrderSession>& sessions_;
  PathPositions& positions_;
  const WaitRecords& waits_;
  std::vector<Vehicle> vehicles_;
  std::vector<VehicleIndex> neighbours_;
};

}  // namespace cosiva::virtual_side
