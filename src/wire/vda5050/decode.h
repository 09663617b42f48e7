#pragma once

#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::wire::vda5050 {

/// Each fails with the codes of codec.h, and with the field's path.
[[nodiscard]] Result<Order> decode_order(std::string_view json);
[[nodiscard]] Result<InstantActions> decode_instant_actions(std::string_view json);
[[nodiscard]] Result<State> decode_state(std::string_view json);
[[nodiscard]] Result<Visualization> decode_visualization(std::string_view json);
[[nodiscard]] Result<Connection> decode_connection(std::string_view json);

}  // namespace cosiva::wire::vda5050
