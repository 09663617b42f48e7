#pragma once

#include "cosiva/app/platform/up_arguments.h"

namespace cosiva::app {

/// `cosiva up`: the whole platform, in real time as processes of this one, or in virtual time. Gives the exit status: 0
/// done, 1 the run's own checks failed, 2 bad usage or bad input.
int run_up(const UpArguments& arguments);

}  // namespace cosiva::app
