#pragma once

#include <string>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/wire/messages/messages.h"

namespace cosiva::wire::vda5050 {

/// One JSON object, as described in codec.h.
[[nodiscard]] std::string encode(const Factsheet& message);
/// Fails with the codes of codec.h, and with the field's path.
[[nodiscard]] Result<Factsheet> decode_factsheet(std::string_view json);

}  // namespace cosiva::wire::vda5050
