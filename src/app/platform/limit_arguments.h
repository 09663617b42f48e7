#pragma once

#include <cstdint>

namespace cosiva::app {

/// Limits that `cosiva up` passes on to its server; all of them bound memory, whatever is received.
struct ServerLimitArguments {
  std::uint32_t vehicles_max{2'000};
  double entries_expire_s{600.0};        ///< 0: never
  double vehicle_rate_max_per_s{500.0};  ///< messages of one vehicle; 0: unlimited
};

/// Limits of the logs of the parts that `cosiva up` starts.
struct LogLimitArguments {
  std::uint32_t file_size_max_mb{10};
  std::uint32_t files_max{3};
};

}  // namespace cosiva::app
