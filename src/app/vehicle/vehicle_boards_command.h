#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "cosiva/app/vehicle/vehicle_arguments.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// `cosiva vehicle boards`: one paragraph for each vehicle that reports its boards (A18).
int run_vehicle_boards(const VehicleArguments& arguments);

/// The same from a snapshot of the platform.
/// @param vehicles  ids or unique serial numbers; empty: all
/// @param as_json   an array with one object for each vehicle
[[nodiscard]] Result<std::string> boards_in(std::string_view snapshot_json, const std::vector<std::string>& vehicles,
                                            bool as_json);

}  // namespace cosiva::app
