#pragma once

#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/zone_session.h"

namespace cosiva::virtual_side {

/// One vehicle in the snapshot (docs/protocols/hmi-api.md).
class VehicleView {
 public:
  VehicleView(const ServerContext& context, const MasterControl& master, const AugmentedParts& augmented,
              const ZoneSession& zones)
      : context_{context}, master_{master}, augmented_{augmented}, zones_{zones} {}

  /// @param vehicle  one that has a twin
  void write(JsonWriter& json, VehicleIndex vehicle) const;

 private:
  void write_pose_and_mission(JsonWriter& json, VehicleIndex vehicle, const Twin::Image& image, double speed_mps) const;
  void write_agent(JsonWriter& json, VehicleIndex vehicle, bool lost) const;
  void write_reserved(JsonWriter& json, VehicleIndex vehicle) const;
  void write_contract(JsonWriter& json, const AivProxy& proxy) const;

  const ServerContext& context_;
  const MasterControl& master_;
  const AugmentedParts& augmented_;
  const ZoneSession& zones_;
};

}  // namespace cosiva::virtual_side
