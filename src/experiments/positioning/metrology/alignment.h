#pragma once

#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"

/// Alignment of estimates to the truth before they are judged. Nobody's default: where the frame is surveyed it hides
/// errors. For estimates in a frame of their own it leaves the shape, and who uses it says so.
namespace cosiva::experiments {

enum class Alignment {
  none,
  se2,     ///< least squares of a turn about the vertical and a shift
  se3,     ///< of any turn and a shift: evo's --align, Umeyama's without scale
  origin,  ///< the first pose is put on the truth's first: evo's --align_origin
};
[[nodiscard]] std::string_view to_string(Alignment alignment);
/// What was done, in words: "turned and shifted …".
[[nodiscard]] std::string_view text_of(Alignment alignment);

/// Of the rigid motions of the plane the X for which X · estimate is nearest to truth in the mean square.
/// Source: S. Umeyama, Least-Squares Estimation of Transformation Parameters Between Two Point Patterns, IEEE TPAMI 13
/// (1991), with scale 1, of which this is the case of two dimensions. Fails ("align.turn") where places are too alike
/// to tell a turn.
/// @param estimate  as many as truth
[[nodiscard]] Result<Pose2> rigid_alignment(const std::vector<Point2>& ground_truth,
                                            const std::vector<Point2>& estimate);

}  // namespace cosiva::experiments
