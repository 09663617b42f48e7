#pragma once

#include "cosiva/app/cli/options.h"
#include "cosiva/app/traffic/capacity_command.h"
#include "cosiva/app/traffic/traffic_arguments.h"

/// The options of `cosiva traffic` and `cosiva capacity`.
namespace cosiva::app {

/// `cosiva traffic`.
[[nodiscard]] Command describe_traffic(Command root, FleetTrafficArguments& traffic);

/// `cosiva capacity`.
[[nodiscard]] Command describe_capacity(Command root, CapacityArguments& capacity);

}  // namespace cosiva::app
