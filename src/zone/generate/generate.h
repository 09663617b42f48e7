#pragma once

#include <string>

#include "cosiva/base/result.h"
#include "cosiva/zone/generate/plant_size.h"

namespace cosiva::zone {

/// The factory layout as a zone file in the native format (docs/guide/zones.md). Every section can be reached from
/// every other. The same options give the same bytes. Fails ("generate.options") on numbers out of range, naming the
/// number.
[[nodiscard]] Result<std::string> generate_plant(const PlantOptions& options);

}  // namespace cosiva::zone
