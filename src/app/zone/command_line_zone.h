#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include "cosiva/app/zone/zone_arguments.h"
#include "cosiva/app/zone/zone_generate_command.h"

/// The options of `cosiva zone`.
namespace cosiva::app {

/// `cosiva zone` and its subcommands.
struct ZoneCommands {
  CLI::App* zone;
  CLI::App* check;
  CLI::App* show;
  CLI::App* convert;
  CLI::App* generate;
  CLI::App* switch_to;
};

[[nodiscard]] ZoneCommands describe_zone(CLI::App& root, ZoneArguments& zone, GenerateArguments& generate);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_zone_command(const ZoneCommands& commands, const ZoneArguments& zone,
                                                  const GenerateArguments& generate);

}  // namespace cosiva::app
