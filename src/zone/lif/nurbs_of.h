#pragma once

#include "cosiva/zone/geometry/section.h"
#include "cosiva/zone/lif/nurbs.h"

namespace cosiva::zone::lif {

/// The curve of a section that bends. An arc is exact: rational quadratic pieces of less than a quarter circle, their
/// weights at least 1 as the official schema wants it. A clothoid is cubic pieces within 0.05 mm and 0.1 mrad.
[[nodiscard]] Nurbs nurbs_of(const Section& section);

}  // namespace cosiva::zone::lif
