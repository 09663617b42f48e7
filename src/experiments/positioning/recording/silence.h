#pragma once

#include "cosiva/experiments/positioning/recording/recording.h"

namespace cosiva::experiments {

/// Handles long gaps in odometry, longer than a second and ten times the usual period. The increment after a gap is not
/// assumed to cover all of the gap: the vehicle is assumed to have moved with speeds between those before and after, as
/// far as in similar times elsewhere in the recording, with the variance observed there. An increment too large for one
/// usual step covers the whole gap and stays unchanged. Gaps are reported in the diagnostics.
/// @param speeds  odometry contains speeds, not increments
void bridge_silences(Recording& recording, bool speeds);

}  // namespace cosiva::experiments
