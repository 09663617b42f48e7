#pragma once

#include <string>

#include "cosiva/app/agent/surface.h"

namespace cosiva::app {

/// The surface drawn: the level as colour, lines where the profile changes, axes with their units, a legend.
[[nodiscard]] std::string to_svg(const Surface& surface);

}  // namespace cosiva::app
