#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// From one zone to another while vehicles drive: which vehicles are still on the old map, when orders may be given
/// again, and which vehicles are off-route on the new zone.
/// Invariant: the vehicles are counted, and the first one moves, only after every vehicle has stopped driving on the
/// old map.
class ZoneChange {
 public:
  ZoneChange(ServerContext& context, MasterControl& master) : context_{context}, master_{master} {}

  /// The waypoint graph of the zone in force; null while there is none.
  void set_map(const WaypointGraph* map) { map_ = map; }
  /// The zone in force has just replaced the zone named `from`.
  void begin(std::string from);
  /// No zone has been changed: earlier changes are not shown.
  void clear() { last_.reset(); }
  /// In each cycle: deploys the map to third-party vehicles, and follows the vehicles to the new zone.
  void follow();

  /// No vehicle drives on the old map any more, so orders on the new one may be sent.
  [[nodiscard]] bool may_send_orders() const { return !last_ || last_->sent_off; }
  /// Why a vehicle gets no orders on the zone in force; empty: the vehicle is not off-route.
  [[nodiscard]] std::string off_route(VehicleIndex vehicle) const;
  /// The snapshot's "switched".
  void write(JsonWriter& json) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// The last switch of the zone while vehicles were present.
  struct Change {
    SimTime at{};
    std::string from;
    bool sent_off{false};  ///< no vehicle drives on the old map any more
    bool counted{false};   ///< every vehicle is on the new map, or is not waited for any more
    std::optional<SimTime> first_moving;
    std::size_t snapped{0};
    std::vector<std::string> off_route;
  };
  [[nodiscard]] bool is_changing(VehicleIndex vehicle) const;
  [[nodiscard]] bool all_stopped_off_old_map() const;
  [[nodiscard]] bool no_vehicle_changes_map() const;
  void deploy_map();
  void count_vehicles();
  void find_first_moving();

  ServerContext& context_;
  MasterControl& master_;
  const WaypointGraph* map_{};
  std::optional<Change> last_;
};

}  // namespace cosiva::virtual_side
