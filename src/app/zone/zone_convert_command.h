#pragma once

#include "cosiva/app/zone/zone_arguments.h"

namespace cosiva::app {

/// `cosiva zone convert`: writes a zone in another format, and reports what was lost. Gives the exit status: 0 done, 1
/// the run's own checks failed, 2 bad usage or bad input.
int run_zone_convert(const ZoneArguments& arguments);

}  // namespace cosiva::app
