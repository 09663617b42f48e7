#pragma once

#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/circuit_factory.h"

namespace cosiva::zone::lif {

/// The zone as a LIF 1.0 file, valid against the official schema, and its sidecar file. Data that neither can express
/// are in `lost`.
[[nodiscard]] Result<ZoneConfiguration> write_zone(const TrafficZone& zone, std::vector<Diagnostic>& lost);

}  // namespace cosiva::zone::lif
