#pragma once

#include <array>
#include <optional>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/physical/vision/points.h"

/// What stands above the floor is seen where its ray meets the floor, further out from the camera's foot.
namespace cosiva::vision {

/// Where the camera hangs. Without a height, heights are not corrected.
struct CameraPose {
  Point2 foot;         ///< on the floor straight below it [m]
  double height_m{0};  ///< above the floor; 0: not known
  friend bool operator==(const CameraPose&, const CameraPose&) = default;
};

/// Where it is, that lies `height_m` above the floor and is seen at `detected` on it: a share height_m/H of the way
/// from there to the camera's foot.
[[nodiscard]] Point2 at_height(Point2 detected, double height_m, const CameraPose& camera);
/// Where on the floor it is seen, that is there so high: the other way round.
[[nodiscard]] Point2 detected_from(Point2 there, double height_m, const CameraPose& camera);
/// Where the camera hangs whose pictures are mapped so, from how high it hangs: a plane alone tells a camera's height
/// only up to its lens's angle. Nothing where no height fits.
[[nodiscard]] std::optional<CameraPose> camera_over(const FloorMap& map, double height_m);

/// What makes seen poses of a marker into poses of its vehicle, fitted to surveyed ones:
///     surveyed heading = direction of A·(cos, sin of the seen heading) + turn + lean
///     surveyed place = A·seen + b + R(surveyed heading − lean)·lever
/// A and b hold all that the floor's calibration does not know, height among it: A = (1 − h/H)·I and b = h/H·foot where
/// the calibration itself is right. A full matrix is for surveys of another frame than the floor's.
/// A marker that leans has its front higher than its back, and what is higher is seen further out: its direction is off
/// by the part across it of a vector that grows from the camera's foot, lean_per_m·(seen − foot), which is what lean
/// is.
struct PoseFit {
  std::array<double, 4> linear{1, 0, 0, 1};  ///< A, row by row
  Point2 shift;                              ///< b [m]
  Point2 lever;                              ///< of the vehicle's reference point in the marker's frame [m]
  double turn_rad{};
  double lean_per_m{};  ///< 0: it does not lean, or nothing is gained by believing that
  Point2 lean;          ///< −lean_per_m·foot
  [[nodiscard]] Pose2 apply(const Pose2& detected) const;
  /// h/H, as A has it, and the foot.
  [[nodiscard]] double height_ratio() const { return 1.0 - 0.5 * (linear[0] + linear[3]); }
  friend bool operator==(const PoseFit&, const PoseFit&) = default;
};
/// A marker on one vehicle, or on all of a make: how high, and where on it.
struct MarkerProfile {
  int id{-1};          ///< of the tag; −1: of everybody who has no profile of his own
  double height_m{0};  ///< of the tag above the floor
  Pose2 X_BT{};        ///< the tag's pose in the vehicle's body frame: the tag's x shows to the right of its picture
  /// Fitted to surveyed poses: stands for height and X_BT.
  std::optional<PoseFit> surveyed;
  friend bool operator==(const MarkerProfile&, const MarkerProfile&) = default;
};
/// Whose tag this is.
[[nodiscard]] const MarkerProfile& profile_of(int id, const std::vector<MarkerProfile>& profiles);
/// The vehicle's pose from its tag's, seen as if it lay on the floor.
[[nodiscard]] Pose2 vehicle_at(const Pose2& detected, const MarkerProfile& profile, const CameraPose& camera);

struct PoseResiduals {
  PoseFit fit;              ///< to all poses
  double heading_sd_rad{};  ///< of the seen headings about the fit to all of them
  double rms_m{};           ///< from here on each pose is judged by the fit to all others
  double max_m{};
  double heading_rms_rad{};
  double heading_max_rad{};
  std::vector<Pose2> left_out;  ///< of each pose: where it was put, less surveyed, on the floor
  double stopped_m{};           ///< how still a standing marker stands, mean over the poses
};
/// @param full  A is any matrix; else a scale
/// That the marker leans is believed where the poses left out are put better with it than without.
/// Fails ("gvs.poses") on fewer than six poses, and where places or headings are too few to tell.
[[nodiscard]] Result<PoseResiduals> fit_poses(const std::vector<SurveyedPose>& poses, bool full);

}  // namespace cosiva::vision
