#pragma once

#include <optional>
#include <string>

#include "cosiva/app/cli/options.h"
#include "cosiva/app/gvs/gvs_calibrate_command.h"
#include "cosiva/app/gvs/gvs_render_command.h"
#include "cosiva/app/gvs/gvs_track_command.h"
#include "cosiva/app/gvs/gvs_watch_command.h"

/// The options of `cosiva gvs`.
namespace cosiva::app {

struct GvsArguments {
  GvsRenderArguments render;
  GvsCalibrateArguments calibrate;
  GvsTrackArguments track;
  GvsWatchArguments watch;
};

/// `cosiva gvs` and its subcommands.
struct GvsCommands {
  Command gvs;
  Command watch;
  Command calibrate;
  Command track;
  Command render;
};

[[nodiscard]] GvsCommands describe_gvs(Command root, GvsArguments& gvs);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_gvs_command(const GvsCommands& commands, const GvsArguments& gvs);

/// Options of a running platform's image source: --gvs-… of `up`, the same without gvs of `gvs watch`.
void add_gvs_source(Command command, GvsSource& source, const std::string& prefix);

}  // namespace cosiva::app
