#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/physical/vision/floor_map.h"
#include "cosiva/physical/vision/points.h"

namespace cosiva::vision {

/// The model that maps a camera's image to the floor.
enum class FloorModel {
  homography,       ///< a pinhole camera: from 6 points
  lens,             ///< and the lens, with its own centre: from 24 points
  polynomial,       ///< a pinhole camera, and its residuals as a polynomial over the image
  lens_polynomial,  ///< and the lens, and the residuals of both
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
/// one line, on the floor or in the image, that nothing is known across it; ("gvs.fit") where nothing fits: no image of
/// a floor.
/// @param near  a fit to nearly the same points, which shortens the search
[[nodiscard]] Result<FloorMap> fit_floor(const std::vector<FloorPoint>& points, ImageSize frame,
                                         const FitOptions& options, const FloorMap* near = nullptr);

}  // namespace cosiva::vision
