#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/registry/vehicle_topic.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::virtual_side {

/// The last header of each topic on which a vehicle publishes (VDA 5050 §6.4).
///
/// Invariant: the version is empty or one that the server reads, so that it can be written into the messages to the
/// vehicle.
class ReceivedHeaders {
 public:
  /// Major version 2: "2.1.0", "2.0.0", "v2".
  [[nodiscard]] static bool readable(std::string_view version);

  /// A message of the topic has been received; its version is empty or readable (checked).
  /// @return  how many header ids are missing between it and the last message of the topic in this session
  [[nodiscard]] std::uint32_t on_header(VehicleTopic topic, const wire::Header& header);
  /// A session begins: header ids start again.
  void on_session() { last_id_ = {}; }

  /// Exactly as the vehicle writes it; empty until its first message.
  [[nodiscard]] const std::string& version() const { return version_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::array<std::optional<std::uint32_t>, vehicle_topics> last_id_;
  std::string version_;
};

}  // namespace cosiva::virtual_side
