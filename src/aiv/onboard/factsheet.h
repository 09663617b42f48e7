#pragma once

#include "cosiva/base/time.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// What this vehicle is and can do, from the zone it drives in.
struct SessionTiming {
  SimDuration state_period;
  SimDuration state_interval_min;
  SimDuration visualization_period;
};
[[nodiscard]] wire::Factsheet make_factsheet(const zone::TrafficZone& zone, const SessionTiming& timing);

}  // namespace cosiva::aiv
