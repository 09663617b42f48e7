#pragma once

#include "cosiva/app/traffic/traffic_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/transport/traffic/traffic.h"

namespace cosiva::app {

/// What `cosiva traffic` says that holds for one zone and for many. Fails on rules that cannot be read or used.
[[nodiscard]] Result<experiments::TrafficTerms> terms_from(const FleetTrafficArguments& arguments);

}  // namespace cosiva::app
