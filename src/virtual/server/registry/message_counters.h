#pragma once

#include <cstdint>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/registry/message_rate.h"

namespace cosiva::virtual_side {

/// Numbers of the messages of a vehicle.
///
/// Invariant: each counted message is refused, outdated and dropped at most once each, and shows fewer than
/// missed_per_message_max others to be missing.
class MessageCounters {
 public:
  /// Header ids that differ by this much or more show a restart or an old message, not thousands of lost ones.
  static constexpr std::uint32_t missed_per_message_max = 999;

  /// A message has been received; the functions below are about that message.
  void on_message() { ++messages_; }
  /// @param missed  header ids between the message and the last one of its topic, fewer than missed_per_message_max
  ///                (checked)
  void on_missed(std::uint32_t missed);
  /// The message was counted as missing before (checked): it was overtaken in transit.
  void on_late();
  /// The message could not be decoded or did not originate from this vehicle.
  void on_refused();
  /// The message was overtaken by a newer one, or is about a zone that is not in force.
  void on_outdated();
  /// The same of a V2X message: other vehicles receive V2X messages, so these are not among the messages().
  void on_v2x_refused() { ++v2x_refused_; }
  /// The message exceeded the vehicle's rate (MessageRate) and has not been evaluated.
  void on_dropped();

  /// Decides which messages are dropped.
  [[nodiscard]] MessageRate& rate() { return rate_; }
  [[nodiscard]] const MessageRate& rate() const { return rate_; }

  [[nodiscard]] std::uint64_t messages() const { return messages_; }
  [[nodiscard]] std::uint64_t missed() const { return missed_; }  ///< gaps in header ids: lost in transit, or dropped
  [[nodiscard]] std::uint64_t refused() const { return refused_ + v2x_refused_; }
  [[nodiscard]] std::uint64_t outdated() const { return outdated_; }
  [[nodiscard]] std::uint64_t dropped() const { return dropped_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::uint64_t messages_{0};
  std::uint64_t missed_{0};
  std::uint64_t refused_{0};
  std::uint64_t v2x_refused_{0};
  std::uint64_t outdated_{0};
  std::uint64_t dropped_{0};
  MessageRate rate_;
};

}  // namespace cosiva::virtual_side
