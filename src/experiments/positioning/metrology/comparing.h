#pragma once

#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::experiments {

/// Fills in the comparisons of all pairs and the ranks, from the runs' figures.
void compare_all(Qualification& qualification);

}  // namespace cosiva::experiments
