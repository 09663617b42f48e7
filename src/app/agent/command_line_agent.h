#pragma once

#include <optional>

#include "cosiva/app/agent/agent_arguments.h"
#include "cosiva/app/cli/options.h"

/// The options of `cosiva agent`.
namespace cosiva::app {

/// `cosiva agent` and its subcommands.
struct AgentCommands {
  Command agent;
  Command explain;
  Command surface;
};

[[nodiscard]] AgentCommands describe_agent(Command root, AgentArguments& agent);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_agent_command(const AgentCommands& commands, const AgentArguments& agent);

}  // namespace cosiva::app
