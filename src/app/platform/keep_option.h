#pragma once

#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/journal/store/retention.h"

namespace cosiva::app {

/// What a store retains without `--keep`.
inline constexpr std::string_view keep_default = "30d/20GB";

/// The value of `--keep`: an age ("30d", "12h"), a size ("20GB", "500MB"), both with '/' between them, or "all". Fails
/// ("keep") with the forms that are possible.
[[nodiscard]] Result<journal::Keep> parse_keep(std::string_view text);

}  // namespace cosiva::app
