#pragma once

#include <optional>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/reports/forecast.h"

namespace cosiva::virtual_side {

/// Moves the twin of a vehicle to the pose that the vehicle reported, and informs the order manager and the bijection
/// monitor.
/// Invariant: a vehicle gets its twin with its first pose, and retains that twin.
class TwinPlacement {
 public:
  TwinPlacement(ServerContext& context, MasterControl& master)
      : context_{context}, master_{master}, forecast_{context, master} {}

  /// The waypoint graph of the zone in force; null while there is none.
  void set_map(const WaypointGraph* map) {
    map_ = map;
    forecast_.set_map(map);
  }
  /// @param at  when the vehicle was there, on the server's clock
  void put(VehicleIndex vehicle, SimTime at, const Pose2& pose, const std::optional<wire::Velocity>& velocity);
  /// The twin may drive to the end of the base that the vehicle's last state lists.
  void apply_base_end(VehicleIndex vehicle);
  /// The vehicle is present physically from now on.
  void set_present(AivProxy& proxy);
  /// Counts an event of a physical vehicle with the time that passed since it was reported.
  void record_event(const AivProxy& proxy, PhysicalEvent kind, SimTime reported_at);

 private:
  [[nodiscard]] bool at_crossing(const Twin& twin);

  ServerContext& context_;
  MasterControl& master_;
  const WaypointGraph* map_{};
  Forecast forecast_;
  std::vector<CrossingIndex> crossings_near_;
};

}  // namespace cosiva::virtual_side
