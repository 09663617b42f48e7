#pragma once

#include <cstddef>
#include <optional>
#include <string>

#include "cosiva/base/time.h"
#include "cosiva/experiments/battery/procedure.h"

namespace cosiva::app {

/// "run 1 of 4: 37 %, its end in 12 min", for tests in virtual time and on a running platform.
[[nodiscard]] std::string progress_text(const experiments::Procedure& procedure, SimTime now);

/// Whether the wanted half width of the mean was reached, and after how many batteries.
/// @param half_width_percent  of the mean
[[nodiscard]] std::string stop_text(const std::optional<std::size_t>& stopped_after, double half_width_percent);

}  // namespace cosiva::app
