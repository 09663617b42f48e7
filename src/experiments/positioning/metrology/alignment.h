#pragma once

#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

/// Alignment of estimates with the ground truth before they are evaluated. Alignment is never the default: in a
/// surveyed frame it hides errors. For estimates in a frame of their own only the shape is evaluated, and the result
/// states this.
namespace cosiva::experiments {

enum class Alignment {
  none,
  se2,     ///< least squares over rotations about the vertical and shifts
  se3,     ///< over all rotations and shifts: evo's --align, Umeyama's without scale
  origin,  ///< the first pose is moved onto that of the ground truth: evo's --align_origin
};
[[nodiscard]] std::string_view to_string(Alignment alignment);
/// A description of the alignment: "turned and shifted …".
[[nodiscard]] std::string_view text_of(Alignment alignment);

/// The rigid motion X of the plane with the smallest mean square distance between X · estimate and the ground truth.
/// Source: S. Umeyama, Least-Squares Estimation of Transformation Parameters Between Two Point Patterns, IEEE TPAMI 13
/// (1991), with scale 1, of which this is the case of two dimensions. Fails ("align.turn") where positions are too
/// close together to determine a rotation.
/// @param estimate  as many as ground_truth
[[nodiscard]] Result<Pose2> rigid_alignment(const std::vector<Point2>& ground_truth,
                                            const std::vector<Point2>& estimate);

}  // namespace cosiva::experiments
