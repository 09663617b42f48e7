#pragma once

#include "cosiva/app/agent/fleet_arguments.h"

/// `cosiva agent search`.
namespace cosiva::app {

/// Searches better numbers for a rule file, and writes the rules and two reports into a folder.
[[nodiscard]] int run_agent_search(const AgentSearchArguments& arguments);

}  // namespace cosiva::app
