#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/virtual_world.h"
#include "cosiva/virtual/server/core/zone_session.h"
#include "cosiva/virtual/server/reports/vehicle_lifecycle.h"

namespace cosiva::virtual_side {

/// The content of the server's state file, which survives a crash of the process: the virtual world, the zone's edits,
/// the missions, which vehicles there were and which crossings they hold.
/// Invariant: a state is persisted only when it differs from the last one, and never before the zone data of the file
/// have been restored.
class PersistedState {
 public:
  PersistedState(ServerContext& context, MasterControl& master, AugmentedParts& augmented, VehicleLifecycle& vehicles,
                 ZoneSession& zones, const VirtualWorld& world)
      : context_{context}, master_{master}, augmented_{augmented}, vehicles_{vehicles}, zones_{zones}, world_{world} {}

  /// Restores the parts from the content of the state file; unreadable items are logged and skipped.
  void restore(std::string_view bytes);
  /// After each input.
  void persist_if_stale();
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] std::string to_json() const;
  void restore_world(const JsonValue& state);

  ServerContext& context_;
  MasterControl& master_;
  AugmentedParts& augmented_;
  VehicleLifecycle& vehicles_;
  ZoneSession& zones_;
  const VirtualWorld& world_;
  std::string persisted_;
  SimTime due_at_{};        ///< the positions of virtual AIVs are persisted again
  std::uint64_t holds_{0};  ///< of the traffic, when the state was persisted
  SimTime holds_due_at_{};  ///< not persisted before, if only the crossings that vehicles hold have changed
};

}  // namespace cosiva::virtual_side
