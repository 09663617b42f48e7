#pragma once

#include <string>

#include "cosiva/base/result.h"
#include "cosiva/wire/in_process/said.h"
#include "cosiva/wire/runtime/core.h"

/// Messages either way: as values where they were passed on so (wire/in_process/said.h), else read from their text.
namespace cosiva::wire::vda5050 {

[[nodiscard]] Result<State> heard_state(const Input& input);
[[nodiscard]] Result<Visualization> heard_visualization(const Input& input);
[[nodiscard]] Result<Order> heard_order(const Input& input);

/// The text that would have been sent, our own messages' too.
[[nodiscard]] std::string text_of(const InProcessMessage& message);

}  // namespace cosiva::wire::vda5050
