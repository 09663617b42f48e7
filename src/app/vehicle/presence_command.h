#pragma once

#include <string_view>

#include "cosiva/app/vehicle/vehicle_arguments.h"

namespace cosiva::app {

/// `cosiva vehicle exclude`, `include` and `retire`: gives the command to the platform for each vehicle in turn, and
/// ends at the first one that the platform refuses. Returns the exit status.
[[nodiscard]] int run_presence_command(const VehicleArguments& arguments, std::string_view command);

}  // namespace cosiva::app
