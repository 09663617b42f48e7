#pragma once

#include <optional>

#include "cosiva/zone/lif/lif_fields.h"
#include "cosiva/zone/lif/nurbs.h"

namespace cosiva::zone::lif {

/// The curve of an edge's `trajectory`, repaired where its parts contradict one another; nothing where it is no curve
/// at all, which is reported.
/// @param scale  metres per unit of the file
[[nodiscard]] std::optional<Nurbs> read_trajectory(const LifFields& fields, double scale);

}  // namespace cosiva::zone::lif
