#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/physical/vision/floor_map.h"
#include "cosiva/physical/vision/points.h"

namespace cosiva::vision {

/// How a camera's picture is mapped to the floor.
enum class FloorModel {
  homography,       ///< a pinhole camera: from 6 points
  lens,             ///< and the lens, with a centre of its own: from 24 points
  polynomial,       ///< a pinhole camera, and what it leaves over as a polynomial over the picture
  lens_polynomial,  ///< and the lens, and what both leave over
};
inline constexpr std::array floor_models{FloorModel::homography, FloorModel::lens, FloorModel::polynomial,
                                         FloorModel::lens_polynomial};
[[nodiscard]] std::string_view name_of(FloorModel model);

struct FitOptions {
  FloorModel model{FloorModel::polynomial};
  std::size_t degree{5};  ///< of the polynomial, 2 … degree_max
};
/// Four per term of a polynomial: fewer follow the noise.
[[nodiscard]] std::size_t points_needed(const FitOptions& options);

/// Least squares on the floor. Fails ("gvs.points") where there are too few points for the model, or all lie so near
/// one line, on the floor or in the picture, that nothing is known across it; ("gvs.fit") where nothing fits: no
/// picture of a floor.
/// @param near  a fit to nearly the same points, from which it is found sooner
[[nodiscard]] Result<FloorMap> fit_floor(const std::vector<FloorPoint>& points, ImageSize frame,
                                         const FitOptions& options, const FloorMap* near = nullptr);

}  // namespace cosiva::vision
