#pragma once

#include "cosiva/zone/opendrive/model.h"
#include "cosiva/zone/opendrive/report.h"
#include "cosiva/zone/opendrive/tracks.h"

namespace cosiva::zone::opendrive {

/// Fills `next`: from the file's links, and from ends that meet without a link.
void link_tracks(const Network& network, Tracks& tracks, Report& report);

}  // namespace cosiva::zone::opendrive
