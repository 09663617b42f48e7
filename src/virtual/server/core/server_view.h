#pragma once

#include <string>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/instrument_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/position_view.h"
#include "cosiva/virtual/server/core/server_core.h"
#include "cosiva/virtual/server/core/vehicle_view.h"
#include "cosiva/virtual/server/core/zone_session.h"

namespace cosiva::virtual_side {

/// The server's data for the HMI and for the summary of a run (docs/protocols/hmi-api.md).
class ServerView {
 public:
  ServerView(const ServerContext& context, const MasterControl& master, const AugmentedParts& augmented,
             const ZoneSession& zones, const InstrumentParts& instruments)
      : context_{context},
        master_{master},
        augmented_{augmented},
        zones_{zones},
        instruments_{instruments},
        vehicle_{context, master, augmented, zones},
        positions_{context, augmented} {}

  [[nodiscard]] std::string snapshot_json() const;
  [[nodiscard]] std::string summary_json() const;
  [[nodiscard]] ServerCore::PageRevision page_revision() const;
  void positions(SimTime now, std::vector<PositionRecord>& out) const { positions_.positions(now, out); }

 private:
  void write_objects(JsonWriter& json) const;
  void write_obstacles(JsonWriter& json) const;
  void write_crossings(JsonWriter& json) const;
  void write_commands(JsonWriter& json) const;
  void add_vehicle(VehicleIndex vehicle, Digest& waited_for, Digest& events) const;

  const ServerContext& context_;
  const MasterControl& master_;
  const AugmentedParts& augmented_;
  const ZoneSession& zones_;
  const InstrumentParts& instruments_;
  VehicleView vehicle_;
  PositionView positions_;
};

}  // namespace cosiva::virtual_side
