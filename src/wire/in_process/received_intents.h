#pragma once

#include <memory>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/wire/own/crossing_claims.h"
#include "cosiva/wire/own/crossing_status.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::wire {

/// The result of intent_from_json, cached for further receivers of the same text: in one process a vehicle's intent
/// reaches a dozen others within milliseconds, and parsing costs far more than a look-up. The last few dozen texts are
/// cached, byte for byte; a faulty text is parsed anew each time.
[[nodiscard]] Result<std::shared_ptr<const Intent>> received_intent(std::string_view json);
/// Likewise, of a message that may have been passed on as values (said.h).
[[nodiscard]] Result<std::shared_ptr<const Intent>> received_intent(const Input& input);

/// Likewise, the result of crossing_claims_from_json.
[[nodiscard]] Result<std::shared_ptr<const CrossingClaims>> received_claims(std::string_view json);
/// Likewise, the result of crossing_status_from_json.
[[nodiscard]] Result<std::shared_ptr<const CrossingStatus>> received_status(std::string_view json);

/// The result of parse_v2x_topic, cached likewise; null where that gives nothing. Valid until the next call.
[[nodiscard]] const V2xTopic* received_v2x_topic(std::string_view topic);

}  // namespace cosiva::wire
