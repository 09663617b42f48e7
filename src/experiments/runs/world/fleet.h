#pragma once

#include <cstdint>

#include "cosiva/virtual/server/core/server_core.h"

namespace cosiva::experiments {

/// Whether at least so many physical vehicles are there and have their twins: from then on a scenario counts its time.
[[nodiscard]] bool fleet_is_complete(const virtual_side::ServerCore& server, std::uint32_t aivs);

}  // namespace cosiva::experiments
