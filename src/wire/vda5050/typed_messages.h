#pragma once

#include <memory>
#include <string>

#include "cosiva/base/result.h"
#include "cosiva/wire/in_process/typed_message.h"
#include "cosiva/wire/runtime/core.h"

/// Received messages: the values where the message was passed on as values (wire/in_process/typed_message.h), else read
/// from the text.
namespace cosiva::wire::vda5050 {

// The very object that was passed on, where it was: every receiver has the same.
[[nodiscard]] Result<std::shared_ptr<const State>> state_from(const Input& input);
[[nodiscard]] Result<std::shared_ptr<const Visualization>> visualization_from(const Input& input);
[[nodiscard]] Result<std::shared_ptr<const Order>> order_from(const Input& input);

/// The text that would have been sent, for CoSiVA's own messages as well.
[[nodiscard]] std::string text_of(const InProcessMessage& message);

}  // namespace cosiva::wire::vda5050
