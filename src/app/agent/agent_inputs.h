#pragma once

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/app/agent/agent_arguments.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// The agent's inputs from the command line: the operator's instruction from its name, the closing speed from metres
/// per second. Fails ("agent.instruction") on an unknown name, and as open_zone does.
[[nodiscard]] Result<aiv::AgentInputs> inputs_from(const AgentArguments& arguments);

}  // namespace cosiva::app
