#pragma once

#include <optional>

#include "cosiva/app/cli/options.h"
#include "cosiva/app/simulate/simulate_arguments.h"

namespace cosiva::app {

[[nodiscard]] Command describe_simulate(Command root, SimulateArguments& arguments);
/// Runs the command where the command line names it; gives the exit status then.
[[nodiscard]] std::optional<int> run_simulate_command(const Command& command, const SimulateArguments& arguments);

}  // namespace cosiva::app
