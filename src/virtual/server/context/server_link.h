#pragma once

#include <cstdint>
#include <optional>
#include <string>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// The server's link to the broker: whether the link is up, whether the startup synchronisation after it came up is
/// done, and when the next heartbeat is due.
/// Invariant: the server is synchronised only while the link is up, and no heartbeat is made while the link is down. No
/// message counts as received then.
class ServerLink {
 public:
  static constexpr SimDuration heartbeat_period{std::chrono::milliseconds{100}};

  [[nodiscard]] bool up() const { return up_; }
  /// When the link came up last.
  [[nodiscard]] SimTime up_since() const { return up_since_; }
  [[nodiscard]] bool synchronised() const { return synchronised_; }

  void came_up(SimTime now);
  void went_down();
  /// The retained messages and the vehicles that drive on earlier orders have been received.
  void set_synchronised();
  /// A message has arrived from the broker.
  void on_message() { message_received_ = up_; }
  /// Whether the broker has sent anything since the call before: an open connection does not prove that it is alive.
  [[nodiscard]] bool take_message_received();
  /// The payload of the heartbeat that is due now, once for each; nothing while none is due.
  [[nodiscard]] std::optional<std::string> take_heartbeat(SimTime now);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  bool up_{false};
  bool synchronised_{false};
  SimTime up_since_{};
  SimTime next_heartbeat_{};
  std::uint32_t heartbeat_id_{0};
  bool message_received_{false};
};

}  // namespace cosiva::virtual_side
