#pragma once

#include "cosiva/app/traffic/traffic_arguments.h"

namespace cosiva::app {

/// `cosiva traffic`, for one zone or several. Gives the exit status: 0 done, 1 the run's own checks failed, 2 bad usage
/// or bad input.
int run_traffic(const FleetTrafficArguments& arguments);

}  // namespace cosiva::app
