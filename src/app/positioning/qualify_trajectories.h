#pragma once

#include "cosiva/app/positioning/qualify_arguments.h"

namespace cosiva::app {

/// Of `--reference` and `--estimate`: figures of trajectories that others have estimated. Gives the exit
/// status.
int run_trajectories(const QualifyArguments& arguments);

}  // namespace cosiva::app
