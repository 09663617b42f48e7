#pragma once

#include "cosiva/aiv/order/action_catalogue.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

struct SessionTiming {
  SimDuration state_period;
  SimDuration state_interval_min;
  SimDuration visualization_period;
};
/// What this vehicle is and can do, from the zone it drives in and the actions that it performs.
[[nodiscard]] wire::Factsheet make_factsheet(const zone::TrafficZone& zone, const SessionTiming& timing,
                                             const ActionCatalogue& catalogue);

}  // namespace cosiva::aiv
