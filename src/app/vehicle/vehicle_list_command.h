#pragma once

#include "cosiva/app/vehicle/vehicle_arguments.h"

namespace cosiva::app {

/// `cosiva vehicle list`: prints each vehicle of the platform with its twin. Returns the exit status.
[[nodiscard]] int run_vehicle_list(const VehicleArguments& arguments);

}  // namespace cosiva::app
