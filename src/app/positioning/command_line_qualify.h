#pragma once

#include <memory>
#include <optional>

#include "cosiva/app/cli/options.h"
#include "cosiva/app/positioning/qualify_arguments.h"
#include "cosiva/app/positioning/qualify_live.h"

/// The options of `cosiva qualify` and `cosiva compare`.
namespace cosiva::app {

/// `cosiva qualify` and `cosiva compare`.
struct QualifyCommands {
  Command qualify;
  Command compare;
  std::shared_ptr<LiveQualifyArguments> live;
};

[[nodiscard]] QualifyCommands describe_qualify(Command root, QualifyArguments& qualify);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_qualify_command(const QualifyCommands& commands, QualifyArguments& qualify,
                                                     int argc, const char* const* argv);

}  // namespace cosiva::app
