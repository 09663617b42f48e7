#pragma once

#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/instrument_parts.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/ownership.h"
#include "cosiva/virtual/server/core/zone_session.h"
#include "cosiva/virtual/server/reports/v2x_intake.h"
#include "cosiva/virtual/server/reports/vehicle_reports.h"

namespace cosiva::virtual_side {

/// Passes each message of the broker to the one part that handles it.
/// Invariant: a message that registers no vehicle and is handled by no part changes nothing but the count of refused
/// messages.
class MessageIntake {
 public:
  MessageIntake(ServerContext& context, AugmentedParts& augmented, InstrumentParts& instruments, Ownership& ownership,
                VehicleReports& reports, ZoneSession& zones)
      : context_{context},
        augmented_{augmented},
        instruments_{instruments},
        ownership_{ownership},
        reports_{reports},
        zones_{zones},
        v2x_{context, augmented} {}

  void receive(const wire::Input& input);

 private:
  void on_battery(const wire::Input& input);
  void on_gvs(const wire::Input& input);
  void on_unit(const wire::Input& input);
  void on_zone(const wire::Input& input);

  ServerContext& context_;
  AugmentedParts& augmented_;
  InstrumentParts& instruments_;
  Ownership& ownership_;
  VehicleReports& reports_;
  ZoneSession& zones_;
  V2xIntake v2x_;
};

}  // namespace cosiva::virtual_side
