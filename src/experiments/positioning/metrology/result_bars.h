#pragma once

#include <string>

#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::experiments {

/// Draws an SVG with a row per algorithm with metrics: a bar to its rmse with the 95 % interval, for several runs a box
/// of them (smallest, quartiles, largest), the limit as a stroke, and the gap to it in percent. Where the best and the
/// worst are too far apart for a linear scale, the scale is logarithmic.
[[nodiscard]] std::string limits_beside_bars(const Qualification& all);

}  // namespace cosiva::experiments
