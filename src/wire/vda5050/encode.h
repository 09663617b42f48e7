#pragma once

#include <string>
#include <string_view>

#include "cosiva/wire/messages/messages.h"

namespace cosiva::wire::vda5050 {

/// One JSON object, as described in codec.h.
[[nodiscard]] std::string encode(const Order& message);
[[nodiscard]] std::string encode(const InstantActions& message);
[[nodiscard]] std::string encode(const State& message);
[[nodiscard]] std::string encode(const Visualization& message);
[[nodiscard]] std::string encode(const Connection& message);

/// The terms of the standard: "CONNECTIONBROKEN", "FINISHED", "HARD", "AUTOMATIC"…
[[nodiscard]] std::string_view to_string(ConnectionState state);
[[nodiscard]] std::string_view to_string(ActionStatus status);
[[nodiscard]] std::string_view to_string(BlockingType type);
[[nodiscard]] std::string_view to_string(OperatingMode mode);

}  // namespace cosiva::wire::vda5050
