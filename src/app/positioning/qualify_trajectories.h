#pragma once

#include "cosiva/app/positioning/qualify_arguments.h"

namespace cosiva::app {

/// Evaluates `--reference` and `--estimate`: metrics of trajectories that third-party programs have estimated. Gives
/// the exit status.
int run_trajectories(const QualifyArguments& arguments);

}  // namespace cosiva::app
