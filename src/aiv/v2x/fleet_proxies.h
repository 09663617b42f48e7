#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "cosiva/aiv/v2x/intent_topic.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// The proxies that a vehicle hosts of the other AIVs (A26): an intent is handed to the proxies of all known AIVs at
/// once, which send it as one message, and an intent of another AIV is delivered by that AIV's proxy. An AIV is known
/// from its first accepted intent on.
///
/// Invariant: at most count_max proxies exist, in the order of the AIVs' names, and the number of the next intent is
/// the number of intents sent, modulo 2³².
class FleetProxies {
 public:
  static constexpr std::size_t count_max = wire::BoardsReport::proxies_max - 1;
  /// An AIV of which no intent has been delivered for this long is not counted as a receiver.
  static constexpr SimDuration receives_for{std::chrono::seconds{1}};
  /// The links by which an intent is sent.
  struct Links {
    bool broker{true};
    bool direct{false};
  };

  /// @param as_values  intents are passed on as values (wire/in_process/typed_message.h)
  explicit FleetProxies(wire::VehicleId self, bool as_values = false);

  /// To vehicles near this cell of the intent's map, and to all in reach where the vehicle has a direct link.
  void send(SimTime now, wire::Cell cell, wire::Intent&& intent, Links links, wire::Effects& effects);
  /// An intent of this vehicle has been accepted. Where count_max proxies exist, the one unused for longest is removed.
  void deliver(SimTime now, const wire::VehicleId& sender);
  /// The counts of each proxy, in the order of the names.
  [[nodiscard]] std::vector<wire::ProxyCounts> counts() const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Proxy {
    wire::ProxyCounts counts;
    SimTime received_at{};
  };

  bool as_values_;
  IntentTopic intent_topic_;
  std::uint32_t next_{0};
  std::vector<Proxy> proxies_;
};

}  // namespace cosiva::aiv
