#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/orders/line_join.h"
#include "cosiva/virtual/server/orders/order_context.h"
#include "cosiva/virtual/server/orders/order_session.h"
#include "cosiva/virtual/server/orders/path_positions.h"
#include "cosiva/virtual/server/orders/wait_graph.h"
#include "cosiva/virtual/server/orders/wait_records.h"
#include "cosiva/virtual/server/registry/proxy.h"

namespace cosiva::virtual_side {

/// Finds which vehicle waits for which and why: from what the last tick recorded, and from what the vehicles' own
/// obstacle sensors report.
///
/// Invariant: the time for which a vehicle has been stopped without a reason is measured only while it has an order.
class WaitAnalysis {
 public:
  WaitAnalysis(const OrderContext& context, const std::vector<OrderSession>& sessions, const PathPositions& positions,
               const LineJoin& joins, const WaitRecords& records)
      : context_{context}, sessions_{sessions}, positions_{positions}, joins_{joins}, records_{records} {}

  void resize(std::size_t vehicles) { unresponsive_since_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { unresponsive_since_[vehicle].reset(); }

  /// True once when a CoSiVA vehicle has been stopped with base ahead and no reason for so long that it needs a new
  /// order. The vehicle has an order.
  [[nodiscard]] bool is_stopped_without_reason(VehicleIndex vehicle);
  /// Adds the waits of this tick; only of stopped vehicles.
  void add_waits(WaitGraph& graph) const;

  /// What the vehicle waits for: a crossing or a vehicle; empty: nothing.
  [[nodiscard]] std::string waits_for(VehicleIndex vehicle) const;
  /// The name of the vehicle that occupies the goal of this vehicle's mission; empty: none.
  [[nodiscard]] std::string blocker_at_goal(VehicleIndex vehicle) const;
  /// "CoSiVA/AIV1 waits for X3, where CoSiVA/AIV2 is".
  [[nodiscard]] std::string sentence(const Wait& wait) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// The vehicle at which its own obstacle sensor stops it; no_vehicle: no known vehicle.
  [[nodiscard]] VehicleIndex detected_in_path(VehicleIndex vehicle) const;

  const OrderContext& context_;
  const std::vector<OrderSession>& sessions_;
  const PathPositions& positions_;
  const LineJoin& joins_;
  const WaitRecords& records_;
  std::vector<std::optional<SimTime>> unresponsive_since_;  ///< stopped with base ahead, no reason reported
};

}  // namespace cosiva::virtual_side
