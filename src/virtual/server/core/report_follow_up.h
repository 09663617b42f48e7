#pragma once

#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/zone_session.h"

namespace cosiva::virtual_side {

/// The instant actions that follow from what a vehicle's reports lack: initPosition where the vehicle has lost its
/// position, factsheetRequest where no factsheet has been received.
/// Invariant: no request is sent before the startup synchronisation is done, and a factsheet is requested once in a
/// session of the vehicle.
class ReportFollowUp {
 public:
  ReportFollowUp(ServerContext& context, MasterControl& master, const ZoneSession& zones)
      : context_{context}, master_{master}, zones_{zones} {}

  /// In each cycle.
  void request_missing();

 private:
  void initialise_position(VehicleIndex vehicle);
  void request_factsheet(VehicleIndex vehicle);

  ServerContext& context_;
  MasterControl& master_;
  const ZoneSession& zones_;
};

}  // namespace cosiva::virtual_side
