#pragma once

#include "cosiva/app/traffic/traffic_arguments.h"
#include "cosiva/base/result.h"
#include "cosiva/experiments/transport/traffic/traffic.h"

namespace cosiva::app {

/// The terms of `cosiva traffic` that are common to one zone and several. Fails on rules that cannot be read or used.
[[nodiscard]] Result<experiments::TrafficTerms> terms_from(const FleetTrafficArguments& arguments);

}  // namespace cosiva::app
