#pragma once

#include <string>

#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/zone_session.h"
#include "cosiva/virtual/server/reports/twin_placement.h"
#include "cosiva/virtual/server/reports/vehicle_lifecycle.h"
#include "cosiva/virtual/server/reports/vehicle_reports.h"

namespace cosiva::virtual_side {

/// Several control areas on one broker: claims a vehicle that no area owns, takes over a vehicle that has become this
/// area's, hands over a vehicle that has arrived, and releases a vehicle that another area owns.
/// Invariant: the server drives the vehicles that its own area owns and no others; messages of other vehicles are not
/// passed on by this class.
class Ownership {
 public:
  Ownership(ServerContext& context, MasterControl& master, VehicleLifecycle& vehicles, TwinPlacement& twins,
            VehicleReports& reports, const ZoneSession& zones);

  /// Takes the messages of other areas, of owners, and of vehicles that this area does not own. False: the message is
  /// for the server's other parts.
  [[nodiscard]] bool receive(const wire::Input& input);
  /// After the startup synchronisation: a restarted broker may have lost which area owns which vehicle.
  void publish_lost_owners();
  /// In each cycle.
  void claim_and_hand_over();

 private:
  void on_owner(const wire::VehicleId& id, const wire::Input& input);
  /// @param retained  the message of the owner was a retained one
  void take_over(ControlAreas::Vehicle& vehicle, bool retained);
  void give_mission(VehicleIndex vehicle, const wire::Owner::Mission& handed_on);
  void let_go(VehicleIndex vehicle, const std::string& new_area);
  /// The sequence number follows the last one received.
  void publish_owner(const ControlAreas::Vehicle& vehicle, wire::Owner owner);
  void claim_vehicles();
  void hand_over_arrived();

  ServerContext& context_;
  MasterControl& master_;
  VehicleLifecycle& vehicles_;
  TwinPlacement& twins_;
  VehicleReports& reports_;
  const ZoneSession& zones_;
};

}  // namespace cosiva::virtual_side
