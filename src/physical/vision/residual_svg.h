#pragma once

#include <string>
#include <vector>

#include "cosiva/physical/vision/calibration.h"

namespace cosiva::vision {

/// The residual map as an SVG drawing: the size of left-out residuals over the floor, and each as an arrow, enlarged.
[[nodiscard]] std::string residual_svg(const std::vector<FloorPoint>& points, const Calibrated& calibrated);

}  // namespace cosiva::vision
