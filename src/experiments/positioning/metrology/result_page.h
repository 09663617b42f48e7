#pragma once

#include <string>

#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/metrology/result.h"

namespace cosiva::experiments {

/// Writes one self-contained HTML page.
[[nodiscard]] std::string to_html(const Qualification& qualification, const Conditions& conditions);

}  // namespace cosiva::experiments
