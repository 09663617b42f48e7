#pragma once

#include <vector>

#include "cosiva/planning/layout_check/well_formed.h"
#include "cosiva/zone/check/check.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::planning {

/// The findings as sentences, each with a remedy, warnings first; of one code twenty at most, the others counted.
///
/// - "layout.no_transport": of several stations none leads to another one.
/// - "layout.no_entry", "layout.no_exit", "layout.no_onward": a station at which no vehicle can arrive, which it cannot
///   leave, or from which it can reach no other station.
/// - "layout.cut": a station at which a stopped vehicle cuts others off; a notice.
/// - "layout.obstructed": the layout is not well-formed; a notice.
[[nodiscard]] std::vector<zone::Problem> layout_problems(const zone::TrafficZone& zone, const WellFormed& found);

}  // namespace cosiva::planning
