#pragma once

#include "cosiva/app/agent/agent_arguments.h"

namespace cosiva::app {

/// `cosiva agent surface`: the output of the rules over two of their inputs. Gives the exit status: 0 done, 1 the run's
/// own checks failed, 2 bad usage or bad input.
int run_agent_surface(const AgentArguments& arguments);

}  // namespace cosiva::app
