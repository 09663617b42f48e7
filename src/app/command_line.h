#pragma once

namespace cosiva::app {

/// The `cosiva` command: parses its arguments, runs the subcommand, returns the exit status.
int run_command_line(int argc, const char* const* argv);

}  // namespace cosiva::app
