#pragma once

#include <optional>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/commands/commands.h"
#include "cosiva/virtual/server/commands/intentions.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/registry.h"

namespace cosiva::virtual_side {

/// Has every vehicle fulfil the intentions of operators: a vehicle that reports without being stopped, for example
/// because it was switched off at the Stop, or has been restarted since, gets the command again. A Stop is published
/// over a connection of its own, too: messages of an older restart may arrive after it, and end it.
///
/// Invariant: a vehicle gets at most one command in each period from here, and none while another one is open; a Stop
/// waits for no other command than a Stop that the vehicle has not performed.
class IntentionEnforcer {
 public:
  static constexpr SimDuration period{std::chrono::seconds{1}};

  IntentionEnforcer(Registry& registry, const MessagePublisher& publisher, const Intentions& intentions,
                    Commands& commands)
      : registry_{registry}, publisher_{publisher}, intentions_{intentions}, commands_{commands} {}

  /// Before orders are given: a vehicle whose Stop is not confirmed gets none.
  void tick();
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void enforce(VehicleIndex vehicle);
  [[nodiscard]] bool waits(VehicleIndex vehicle, OperatorCommandKind kind) const;
  /// The command that the vehicle's last state contradicts.
  [[nodiscard]] static std::optional<OperatorCommandKind> unfulfilled(const AivProxy& proxy,
                                                                      const Intention& intention);

  Registry& registry_;
  const MessagePublisher& publisher_;
  const Intentions& intentions_;
  Commands& commands_;
  std::vector<std::optional<SimTime>> tried_at_;  ///< of each vehicle
};

}  // namespace cosiva::virtual_side
