#pragma once

#include <string>

#include "cosiva/base/result.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::zone {

/// The zone as the text of a native file. Fails ("zone.write") on a name that no file can hold.
[[nodiscard]] Result<std::string> native_text(const TrafficZone& zone);

/// For CircuitFactory::written: a sidecar file with the zone's data that another format cannot express. Limits,
/// stations and closed sections are included only where requested.
struct SidecarParts {
  bool limits{true};
  bool stations{true};
  bool closed{true};
};
[[nodiscard]] std::string sidecar_text(const TrafficZone& zone, SidecarParts parts = {});

}  // namespace cosiva::zone
