#pragma once

#include <string>
#include <vector>

#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/instrument_parts.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/core/ownership.h"
#include "cosiva/virtual/server/core/virtual_world.h"
#include "cosiva/virtual/server/core/zone_session.h"

namespace cosiva::virtual_side {

/// The server's own presence on the broker: connection, heartbeat, subscriptions, and the startup synchronisation after
/// the link came up.
/// Invariant: the parts are synchronised once for each time that the link comes up.
class BrokerSession {
 public:
  BrokerSession(ServerContext& context, AugmentedParts& augmented, InstrumentParts& instruments, ZoneSession& zones,
                Ownership& ownership, VirtualWorld& world)
      : context_{context},
        augmented_{augmented},
        instruments_{instruments},
        zones_{zones},
        ownership_{ownership},
        world_{world} {}

  void on_link(bool up);
  /// In each cycle, before the parts' own cycles.
  void send_heartbeat();
  /// In each cycle: synchronises as soon as every vehicle that drives on an earlier order has reported.
  void synchronise_if_due();
  void farewell(SimTime now, wire::Effects& effects);

  [[nodiscard]] wire::Will will() const;
  [[nodiscard]] std::vector<std::string> subscriptions() const;

 private:
  void came_up();
  [[nodiscard]] bool is_synchronisation_due() const;

  ServerContext& context_;
  AugmentedParts& augmented_;
  InstrumentParts& instruments_;
  ZoneSession& zones_;
  Ownership& ownership_;
  VirtualWorld& world_;
};

}  // namespace cosiva::virtual_side
