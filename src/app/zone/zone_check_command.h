#pragma once

#include "cosiva/app/zone/zone_arguments.h"

namespace cosiva::app {

/// `cosiva zone check`: reports a zone's contents and weak spots, or all its errors. Gives the exit status: 0 done, 1
/// the run's own checks failed, 2 bad usage or bad input.
int run_zone_check(const ZoneArguments& arguments);

}  // namespace cosiva::app
