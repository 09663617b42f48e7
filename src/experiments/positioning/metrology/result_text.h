#pragma once

#include <string>

#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::experiments {

/// A short text for a terminal.
[[nodiscard]] std::string to_text(const Qualification& qualification);
/// algorithm,run,rmse_m,mean_m,variance_m2,precision,max_m,nees: a line per vote.
[[nodiscard]] std::string to_csv(const Qualification& qualification);

}  // namespace cosiva::experiments
