#pragma once

#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::experiments {

/// Computes the comparisons of all pairs and the ranks, from the runs' metrics.
void compare_all(Qualification& qualification);

}  // namespace cosiva::experiments
