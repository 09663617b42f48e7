#pragma once

#include "cosiva/experiments/positioning/recording/recording.h"

namespace cosiva::experiments {

/// Compares the ground truth's heading with its direction of motion, forwards by odometry. A constant offset larger
/// than the start's own uncertainty (the instrument's axis differs from the vehicle's, or faces backwards) is
/// corrected; a heading that does not follow the motion at all (degrees, a compass' sense of rotation, another vehicle)
/// is left out, and the drive has positions only. Both are reported in the diagnostics.
void check_heading(Recording& recording);

}  // namespace cosiva::experiments
