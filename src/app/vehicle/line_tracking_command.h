#pragma once

#include "cosiva/app/vehicle/vehicle_arguments.h"

namespace cosiva::app {

/// `cosiva vehicle line-tracking`: compares the line-tracking algorithms of PILS on a zone's path, in virtual time: rms
/// and greatest offset at each speed, and with --out the offsets over the distance as a chart. Gives the exit status: 0
/// done, 2 bad usage or bad input.
int run_line_tracking(const LineTrackingArguments& arguments);

}  // namespace cosiva::app
