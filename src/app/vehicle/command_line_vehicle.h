#pragma once

#include <optional>

#include "cosiva/app/cli/options.h"
#include "cosiva/app/vehicle/vehicle_arguments.h"

/// The options of `cosiva vehicle`.
namespace cosiva::app {

/// `cosiva vehicle` and its subcommands.
struct VehicleCommands {
  Command vehicle;
  Command list;
  Command exclude;
  Command include;
  Command retire;
  Command self_test;
  Command boards;
  Command line_tracking;
};

[[nodiscard]] VehicleCommands describe_vehicle(Command root, VehicleArguments& arguments);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_vehicle_command(const VehicleCommands& commands,
                                                     const VehicleArguments& arguments);

}  // namespace cosiva::app
