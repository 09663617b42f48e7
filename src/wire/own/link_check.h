#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/time.h"

namespace cosiva::wire {

/// A vehicle's messages to itself, through the broker (LinkCheck).
inline constexpr std::string_view link_check_topic_prefix = "cosiva/v1/link_check/";

/// Vehicle → the same vehicle, QoS 0: sent while nothing else arrives from the broker. A message that returns proves
/// that the broker is alive, which an open connection does not; its content is not read.
struct LinkCheck {
  std::uint32_t header_id{};
  SimTime timestamp{};
};
[[nodiscard]] std::string to_json(const LinkCheck& check);

}  // namespace cosiva::wire
