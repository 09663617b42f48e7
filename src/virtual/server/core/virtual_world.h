#pragma once

#include <string>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/reports/vehicle_lifecycle.h"

namespace cosiva::virtual_side {

/// The objects that are added only virtually (A3): persons, obstacles and virtual AIVs, as operators add, move and
/// remove them, and as the state file restores them.
/// Invariant: the monitor counts as many virtual AIVs as run in this process, and each of them is a vehicle of the
/// registry that is not retired.
class VirtualWorld {
 public:
  VirtualWorld(ServerContext& context, AugmentedParts& augmented, VehicleLifecycle& vehicles)
      : context_{context}, augmented_{augmented}, vehicles_{vehicles} {}

  void follow(const VirtualObjectCommand& command);
  /// To be called after every possible change of the virtual world: sends each vehicle the bodies near its path.
  void update();
  /// In each cycle: removes obstacles that a vehicle has driven through.
  void remove_passed_obstacles();
  /// Virtual AIVs of an earlier process that ended without signing off: only this server can report them offline.
  void sign_off_orphans();

  /// Once the zone is known: adds the restored virtual AIVs, each as near to its previous position as there is room.
  void put_restored();
  /// The state file's "aivs".
  void write_state(JsonWriter& json) const;

 private:
  bool add_aiv(const std::string& serial, zone::TrackPosition position);
  void remove_aiv(VehicleIndex vehicle);
  /// @param id  "*" means all
  void remove(const std::string& id, bool is_aiv);
  [[nodiscard]] std::optional<zone::TrackPosition> room_near(const RestoredAivs::Aiv& aiv) const;

  ServerContext& context_;
  AugmentedParts& augmented_;
  VehicleLifecycle& vehicles_;
};

}  // namespace cosiva::virtual_side
