#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "cosiva/virtual/fleet/fleet.h"

namespace cosiva::virtual_side {

/// As Fleet::spread().
[[nodiscard]] std::vector<FleetStart> spread_starts(const zone::TrafficZone& zone, std::size_t count,
                                                    std::uint32_t copy);

}  // namespace cosiva::virtual_side
