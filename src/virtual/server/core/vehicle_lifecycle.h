#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// From the registration of a vehicle to its retirement: here alone a vehicle gets its rows in all parts of
/// the server, and where all parts forget the vehicle.
/// Invariant: each part that keeps a row per vehicle has one for every vehicle of the registry, and a vehicle that has
/// just been retired has no order and no open command.
class VehicleLifecycle {
 public:
  VehicleLifecycle(ServerContext& context, MasterControl& master, AugmentedParts& augmented)
      : context_{context}, master_{master}, augmented_{augmented} {}

  /// A vehicle that was received for the first time. Nothing: the server takes no more vehicles.
  std::optional<VehicleIndex> register_vehicle(const wire::VehicleId& id);
  /// Registers a vehicle, or renews one that was retired: from now on the server drives the vehicle. Nothing: the
  /// server takes no more vehicles.
  std::optional<VehicleIndex> begin_life(const wire::VehicleId& id);
  /// The vehicle leaves the table and the traffic; its name may come back.
  /// @param reason  why its open commands fail
  void retire(VehicleIndex vehicle, const std::string& reason);

  /// Gives each vehicle the priority that the zone in force gives its name.
  void apply_priorities();
  /// The vehicle of this name was paused for a virtual body when the state file was written.
  void restore_pause(std::string name) { restored_pauses_.push_back(std::move(name)); }

 private:
  void apply_priority(VehicleIndex vehicle);
  void renew_mission(VehicleIndex vehicle);

  ServerContext& context_;
  MasterControl& master_;
  AugmentedParts& augmented_;
  std::vector<std::string> restored_pauses_;  ///< of vehicles that are not registered yet
};

}  // namespace cosiva::virtual_side
