#pragma once

#include <optional>

#include "cosiva/app/cli/options.h"
#include "cosiva/app/platform/aiv_command.h"
#include "cosiva/app/platform/plant_command.h"
#include "cosiva/app/platform/replay_command.h"
#include "cosiva/app/platform/scenario_commands.h"
#include "cosiva/app/platform/server_command.h"
#include "cosiva/app/platform/unit_command.h"
#include "cosiva/app/platform/up_arguments.h"

/// The options of `cosiva up`, of the parts that run alone, of `cosiva replay` and of `cosiva scenario`.
namespace cosiva::app {

struct PlatformArguments {
  UpArguments up;
  ServerArguments server;
  PlantArguments plant;
  AivArguments aiv;
  UnitArguments unit;
  ReplayArguments replay;
};
/// `cosiva up`, `server`, `plant`, `aiv`, `unit` and `replay`.
struct PlatformCommands {
  Command up;
  Command server;
  Command plant;
  Command aiv;
  Command unit;
  Command replay;
};
[[nodiscard]] PlatformCommands describe_platform(Command root, PlatformArguments& platform);
/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_platform_command(const PlatformCommands& commands, PlatformArguments& platform);

/// `cosiva scenario` and its subcommands.
struct ScenarioCommands {
  Command scenario;
  Command check;
  Command list;
};
[[nodiscard]] ScenarioCommands describe_scenario(Command root, ScenarioArguments& scenario);
/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_scenario_command(const ScenarioCommands& commands,
                                                      const ScenarioArguments& scenario);

}  // namespace cosiva::app
