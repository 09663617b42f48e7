#pragma once

#include "cosiva/zone/opendrive/model.h"
#include "cosiva/zone/opendrive/report.h"
#include "cosiva/zone/opendrive/tracks.h"

namespace cosiva::zone::opendrive {

/// Moves ends of linked tracks to where they meet; unlinks those that are too far apart.
void join_tracks(const Network& network, Tracks& tracks, Report& report);

}  // namespace cosiva::zone::opendrive
