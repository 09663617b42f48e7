#pragma once

#include <CLI/CLI.hpp>

#include "cosiva/app/traffic/capacity_command.h"
#include "cosiva/app/traffic/traffic_arguments.h"

/// The options of `cosiva traffic` and `cosiva capacity`.
namespace cosiva::app {

/// `cosiva traffic`.
[[nodiscard]] CLI::App* describe_traffic(CLI::App& root, FleetTrafficArguments& traffic);

/// `cosiva capacity`.
[[nodiscard]] CLI::App* describe_capacity(CLI::App& root, CapacityArguments& capacity);

}  // namespace cosiva::app
