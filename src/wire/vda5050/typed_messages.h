#pragma once

#include <string>

#include "cosiva/base/result.h"
#include "cosiva/wire/in_process/typed_message.h"
#include "cosiva/wire/runtime/core.h"

/// Messages either way: as values where they were passed on so (wire/in_process/typed_message.h), else read from their
/// text.
namespace cosiva::wire::vda5050 {

[[nodiscard]] Result<State> state_from(const Input& input);
[[nodiscard]] Result<Visualization> visualization_from(const Input& input);
[[nodiscard]] Result<Order> order_from(const Input& input);

/// The text that would have been sent, our own messages' too.
[[nodiscard]] std::string text_of(const InProcessMessage& message);

}  // namespace cosiva::wire::vda5050
