#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// The lifecycle of vehicles from registration to retirement: only this class adds a vehicle's rows to all parts of the
/// server, and removes the vehicle from all parts.
/// Invariant: each part with a row per vehicle has one for every vehicle of the registry, and a vehicle that has just
/// been retired has no order and no open command.
class VehicleLifecycle {
 public:
  VehicleLifecycle(ServerContext& context, MasterControl& master, AugmentedParts& augmented)
      : context_{context}, master_{master}, augmented_{augmented} {}

  /// Registers a vehicle whose first message was received. Where the registry is full, an entry that never sent a state
  /// makes room. Nothing: the server accepts no more vehicles.
  std::optional<VehicleIndex> register_vehicle(const wire::VehicleId& id);
  /// Registers a vehicle of which nothing has been received, but which a server before a restart controlled.
  void register_awaited(const wire::VehicleId& id);
  /// Registers a vehicle, or renews one that was retired: from now on the server drives the vehicle. Nothing: the
  /// server accepts no more vehicles.
  std::optional<VehicleIndex> begin_life(const wire::VehicleId& id);
  /// Removes the vehicle from the table and the traffic; a vehicle of the same name may return.
  /// @param reason  of the failure of its open commands
  void retire(VehicleIndex vehicle, const std::string& reason);

  /// The inverse of an arrival (figure 9): an absent vehicle has left the zone, so its twin leaves, too. Its next
  /// report begins its life again.
  /// @param by  who found that: "operator", "GVS"
  void depart(VehicleIndex vehicle, std::string_view by, std::string_view reason);

  /// Removes the entries that never proved to be a vehicle and have sent nothing for
  /// ServerOptions::entries_expire_after. A twin stays for as long as the server runs.
  void remove_expired();

  /// Gives each vehicle the priority that the zone in force gives its name.
  void apply_priorities();
  /// The vehicle of this name was paused for a virtual body when the state file was written.
  void restore_pause(std::string name) { restored_pauses_.push_back(std::move(name)); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  /// Removes an entry that is no vehicle (checked).
  void remove(VehicleIndex vehicle);
  void apply_priority(VehicleIndex vehicle);
  /// An operator may have stopped the vehicle before it was known.
  void apply_stop(AivProxy& proxy) const;
  /// The entity of a vehicle in the bijection monitor.
  [[nodiscard]] BijectionMonitor::Entity entity_for(const std::string& name);
  void renew_mission(VehicleIndex vehicle);

  ServerContext& context_;
  MasterControl& master_;
  AugmentedParts& augmented_;
  SimTime expiry_checked_at_{};
  std::vector<BijectionMonitor::Entity> spare_entities_;  ///< of removed entries
  std::vector<std::string> restored_pauses_;              ///< of vehicles that are not registered yet
};

}  // namespace cosiva::virtual_side
