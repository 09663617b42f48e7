#pragma once

#include <CLI/CLI.hpp>
#include <optional>

#include "cosiva/app/agent/agent_arguments.h"

/// The options of `cosiva agent`.
namespace cosiva::app {

/// `cosiva agent` and its subcommands.
struct AgentCommands {
  CLI::App* agent;
  CLI::App* explain;
  CLI::App* surface;
};

[[nodiscard]] AgentCommands describe_agent(CLI::App& root, AgentArguments& agent);

/// The exit status of the requested subcommand, if any.
[[nodiscard]] std::optional<int> run_agent_command(const AgentCommands& commands, const AgentArguments& agent);

}  // namespace cosiva::app
