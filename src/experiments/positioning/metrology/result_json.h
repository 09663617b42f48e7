#pragma once

#include <string>

#include "cosiva/experiments/positioning/metrology/qualification.h"
#include "cosiva/experiments/positioning/metrology/result.h"

namespace cosiva::experiments {

/// Writes one JSON document: `algorithms[]` with name, rmse_m, mean_m, variance_m2, precision and the rest,
/// `comparisons[]`, `ranks`, `conditions`, `digest`. Missing numbers are null.
[[nodiscard]] std::string to_json(const Qualification& qualification, const Conditions& conditions);

}  // namespace cosiva::experiments
