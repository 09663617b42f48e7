#pragma once

#include "cosiva/app/agent/agent_arguments.h"

namespace cosiva::app {

/// `cosiva agent explain`: which rules fire in a situation, and what they decide. Gives the exit status: 0 done, 1 the
/// run's own checks failed, 2 bad usage or bad input.
int run_agent_explain(const AgentArguments& arguments);

}  // namespace cosiva::app
