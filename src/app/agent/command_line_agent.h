#pragma once

#include <optional>

#include "cosiva/app/agent/agent_arguments.h"
#include "cosiva/app/agent/fleet_arguments.h"
#include "cosiva/app/cli/options.h"

/// The options of `cosiva agent`.
namespace cosiva::app {

/// `cosiva agent` and its subcommands.
struct AgentCommands {
  Command agent;
  Command explain;
  Command surface;
  Command measure;
  Command search;
};

struct AllAgentArguments {
  AgentArguments inspect;
  AgentMeasureArguments measure;
  AgentSearchArguments search;
};

[[nodiscard]] AgentCommands describe_agent(Command root, AllAgentArguments& agent);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_agent_command(const AgentCommands& commands, const AllAgentArguments& agent);

}  // namespace cosiva::app
