#pragma once

#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::virtual_side {

/// The connection of a vehicle to the broker, as the vehicle or its last will has published it.
///
/// Invariant: the connection changes at times that never decrease.
class ConnectionRecord {
 public:
  /// A vehicle that still reports this long after the publication of its last will is connected: the will was of an old
  /// session.
  static constexpr SimDuration will_outlived{std::chrono::seconds{2}};

  /// The vehicle or its last will has published `state`.
  /// @param now    not before the last change (checked)
  /// @param stamp  of the message
  /// @return       a session begins: the vehicle is ONLINE, and was not, or the message is another one than that which
  ///               began its session. A broker that dies publishes no last will.
  bool on_connection(wire::ConnectionState state, SimTime now, SimTime stamp = {});
  /// The vehicle has reported.
  /// @return  the vehicle was not online and has outlived its will: from now on it counts as ONLINE
  [[nodiscard]] bool on_report(SimTime now);
  /// The server has retired the vehicle, or signs it off.
  void on_offline(SimTime now) { on_connection(wire::ConnectionState::offline, now); }

  [[nodiscard]] std::optional<wire::ConnectionState> state() const { return state_; }  ///< nothing: never reported
  /// As shown: a vehicle that never reported its connection counts as ONLINE.
  [[nodiscard]] wire::ConnectionState shown() const { return state_.value_or(wire::ConnectionState::online); }
  [[nodiscard]] bool online() const { return shown() == wire::ConnectionState::online; }
  [[nodiscard]] SimTime changed_at() const { return changed_at_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::optional<wire::ConnectionState> state_;
  SimTime changed_at_{};
  SimTime online_stamp_{};  ///< of the message that began the last session
};

}  // namespace cosiva::virtual_side
