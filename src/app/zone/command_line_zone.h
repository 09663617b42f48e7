#pragma once

#include <optional>

#include "cosiva/app/cli/options.h"
#include "cosiva/app/zone/zone_arguments.h"
#include "cosiva/app/zone/zone_generate_command.h"

/// The options of `cosiva zone`.
namespace cosiva::app {

/// `cosiva zone` and its subcommands.
struct ZoneCommands {
  Command zone;
  Command check;
  Command show;
  Command convert;
  Command generate;
  Command switch_to;
};

[[nodiscard]] ZoneCommands describe_zone(Command root, ZoneArguments& zone, GenerateArguments& generate);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_zone_command(const ZoneCommands& commands, const ZoneArguments& zone,
                                                  const GenerateArguments& generate);

}  // namespace cosiva::app
