#pragma once

#include "cosiva/experiments/positioning/recording/recording.h"

namespace cosiva::experiments {

/// Where odometry is silent for long, longer than a second and ten times as long as usual, what it says next is not
/// believed for all of that time: the vehicle is taken to have gone on between the speeds before and after as far as it
/// does elsewhere in the recording, give or take what it differs from that there. An increment too large for one usual
/// step counts for all of the silence and stands. Says so in the notes.
/// @param speeds  odometry told speeds, not increments
void bridge_silences(Recording& recording, bool speeds);

}  // namespace cosiva::experiments
