#pragma once

#include <string>
#include <vector>

#include "cosiva/zone/drawing/draw.h"

namespace cosiva::zone {

/// A self-contained SVG drawing, y up, with a legend and a scale bar; closed sections are hatched.
[[nodiscard]] std::string to_svg(const TrafficZone& zone, const std::vector<Primitive>& primitives);

}  // namespace cosiva::zone
