#pragma once

#include "cosiva/aiv/decision/agent_rules.h"
#include "cosiva/app/agent/agent_arguments.h"
#include "cosiva/base/result.h"

namespace cosiva::app {

/// The inputs as the command line gave them: what the operator asks for from its word, the speed of closing in from
/// metres per second. Fails ("agent.instruction") on an unknown word, and as open_zone does.
[[nodiscard]] Result<aiv::AgentInputs> inputs_from(const AgentArguments& arguments);

}  // namespace cosiva::app
