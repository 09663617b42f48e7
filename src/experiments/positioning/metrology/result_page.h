#pragma once

#include <string>

#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/metrology/result.h"

namespace cosiva::experiments {

/// One HTML page that needs nothing else.
[[nodiscard]] std::string to_html(const Qualification& qualification, const Conditions& conditions);

}  // namespace cosiva::experiments
