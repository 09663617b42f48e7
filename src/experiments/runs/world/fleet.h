#pragma once

#include <cstdint>

#include "cosiva/virtual/server/core/server_core.h"

namespace cosiva::experiments {

/// Whether at least this number of physical vehicles is present with twins: a scenario's time starts then.
[[nodiscard]] bool fleet_is_complete(const virtual_side::ServerCore& server, std::uint32_t aivs);

}  // namespace cosiva::experiments
