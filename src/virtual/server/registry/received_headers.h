#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/registry/sender_watch.h"
#include "cosiva/virtual/server/registry/vehicle_topic.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::virtual_side {

/// The last headers of each topic on which a vehicle publishes (VDA 5050 §6.4): what was sent, and did not arrive.
///
/// Invariant: the version is empty or one that the server reads, so that it can be written into the messages to the
/// vehicle; the ids stored as missing are below the newest one of their topic.
class ReceivedHeaders {
 public:
  /// Major version 2: "2.1.0", "2.0.0", "v2".
  [[nodiscard]] static bool readable(std::string_view version);

  /// A message this many ids behind the newest one was overtaken in transit; further back it shows a restart.
  static constexpr std::uint32_t overtaken_max = 64;

  /// What a message shows of the others of its topic in this session.
  struct Gap {
    std::uint32_t missing{0};  ///< header ids between it and the newest one before it
    bool late{false};          ///< it was overtaken, and counted as missing when the newer one arrived
    friend bool operator==(const Gap&, const Gap&) = default;
  };
  /// A message of the topic has been received; its version is empty or readable (checked). Of a message that arrives
  /// twice, the second one shows nothing.
  [[nodiscard]] Gap on_header(VehicleTopic topic, const wire::Header& header);
  /// A session begins: header ids start again.
  void on_session() {
    newest_id_ = {};
    missing_ = {};
    senders_.on_session();
  }

  [[nodiscard]] SenderWatch& senders() { return senders_; }
  [[nodiscard]] const SenderWatch& senders() const { return senders_; }
  /// Exactly as the vehicle writes it; empty until its first message.
  [[nodiscard]] const std::string& version() const { return version_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::array<std::optional<std::uint32_t>, vehicle_topics> newest_id_;
  std::array<std::uint64_t, vehicle_topics> missing_{};  ///< bit n: the id n + 1 below the newest one has not arrived
  std::string version_;
  SenderWatch senders_;
};

}  // namespace cosiva::virtual_side
