#pragma once

#include <string>

#include "cosiva/base/result.h"
#include "cosiva/battery/fit/log.h"

namespace cosiva::battery {

/// Whether a log of ten samples or more can be trusted: no gap, no spike, the right sign, times that a battery keeps.
[[nodiscard]] Result<void> check_log(const Log& log);

/// Six digits at most, for people.
[[nodiscard]] std::string short_number(double value);

}  // namespace cosiva::battery
