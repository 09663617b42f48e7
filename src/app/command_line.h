#pragma once

namespace cosiva::app {

/// The `cosiva` command: understands its arguments, runs the verb, gives the exit status.
int run_command_line(int argc, const char* const* argv);

}  // namespace cosiva::app
