#pragma once

#include "cosiva/app/simulate/simulate_arguments.h"

namespace cosiva::app {

/// Exit status 1 where a seed violates an invariant.
[[nodiscard]] int run_simulate(const SimulateArguments& arguments);

}  // namespace cosiva::app
