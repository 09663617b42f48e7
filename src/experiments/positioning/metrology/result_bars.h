#pragma once

#include <string>

#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::experiments {

/// An SVG with a row per algorithm that has figures: a bar to its rmse with the 95 % interval, over several runs a box
/// of them (smallest, quartiles, largest), the limit as a stroke, and the gap to it in percent beside. Where the best
/// and the worst are too far apart to be seen together the scale is logarithmic.
[[nodiscard]] std::string limits_beside_bars(const Qualification& all);

}  // namespace cosiva::experiments
