#pragma once

#include <functional>
#include <string>

#include "cosiva/base/result.h"
#include "cosiva/experiments/runs/scenario/scenario.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {

/// Finds the zones that the scenario switches to, and inserts their complete text into the steps' commands: a server
/// that plays the scenario needs no files. Fails as `load` does, naming the line.
using LoadZone = std::function<Result<zone::ZoneConfiguration>(const std::string& name_or_file)>;
[[nodiscard]] Result<void> resolve_zones(Scenario& scenario, const LoadZone& load, const std::string& origin);
/// Checks what depends on the zone in force at each step: positions on it, existing sections, stations and loops,
/// vehicles 1…aivs or named virtual ones that are present at that time, ids used twice or removed before they were
/// added. The scenario's zones must have been resolved.
/// @param zone  in force at the beginning
[[nodiscard]] Result<void> check(const Scenario& scenario, const zone::TrafficZone& zone, const std::string& origin);

}  // namespace cosiva::experiments
