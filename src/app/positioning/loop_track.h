#pragma once

#include <memory>
#include <string>

#include "cosiva/aiv/estimation/track.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::app {

/// The loop that runs in virtual time drive along.
struct LoopTrack {
  std::shared_ptr<const zone::TrafficZone> zone;
  std::shared_ptr<const estimation::Track> track;
};

/// The zone's first declared loop, or its circuit where that is a loop. Fails as open_zone and Track::make do.
[[nodiscard]] Result<LoopTrack> loop_of(const std::string& name_or_file);

}  // namespace cosiva::app
