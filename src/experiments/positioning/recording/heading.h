#pragma once

#include "cosiva/experiments/positioning/recording/recording.h"

namespace cosiva::experiments {

/// Holds the truth's heading against the way that it goes, forwards by odometry. Where it is off by always the same,
/// more than the start's own doubt (its instrument's axis is another than the vehicle's, or it counts from behind), it
/// is turned by that; where it does not follow the way at all (degrees, a compass' sense of rotation, another vehicle),
/// it is left out, and the drive has places alone. Says so in the notes.
void check_heading(Recording& recording);

}  // namespace cosiva::experiments
