#pragma once

#include <memory>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::wire {

/// What intent_from_json gives, kept for those who hear the same words next: in one process a vehicle's intent reaches
/// a dozen others within milliseconds, and reading it costs far more than hearing it. The last few dozen texts are
/// known, byte for byte; a fault is found anew each time.
[[nodiscard]] Result<std::shared_ptr<const Intent>> received_intent(std::string_view json);
/// Likewise, of a message that may have been passed on as values (said.h).
[[nodiscard]] Result<std::shared_ptr<const Intent>> received_intent(const Input& input);

}  // namespace cosiva::wire
