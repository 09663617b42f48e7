#pragma once

#include <array>
#include <optional>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/physical/vision/points.h"

/// An object above the floor appears where its ray meets the floor, further out from the camera's foot.
namespace cosiva::vision {

/// The camera's position. Without a height, heights are not corrected.
struct CameraPose {
  Point2 foot;         ///< on the floor straight below it [m]
  double height_m{0};  ///< above the floor; 0: not known
  friend bool operator==(const CameraPose&, const CameraPose&) = default;
};

/// The position of an object that is `height_m` above the floor and is detected at `detected` on it: a ratio height_m/H
/// of the distance from there to the camera's foot.
[[nodiscard]] Point2 at_height(Point2 detected, double height_m, const CameraPose& camera);
/// The detected floor position of an object at this position and height: the inverse function.
[[nodiscard]] Point2 detected_from(Point2 there, double height_m, const CameraPose& camera);
/// The position of the camera with this image mapping, given its height: a plane alone determines a camera's height
/// only up to its lens's angle. Nothing where no height fits.
[[nodiscard]] std::optional<CameraPose> camera_over(const FloorMap& map, double height_m);

/// The map from detected poses of a marker to poses of its vehicle, fitted to surveyed poses:
///     surveyed heading = direction of A·(cos, sin of the detected heading) + turn + lean
///     surveyed position = A·detected + b + R(surveyed heading − lean)·lever
/// A and b hold all that the floor's calibration does not contain, such as the height: A = (1 − h/H)·I and b = h/H·foot
/// where the calibration itself is right. A full matrix is for surveys of another frame than the floor's. The front of
/// a leaning marker is higher than its back, and a higher point appears further out: the marker's direction is off by
/// the transverse part of a vector that grows from the camera's foot, lean_per_m·(detected − foot), which is what lean
/// is.
struct PoseFit {
  std::array<double, 4> linear{1, 0, 0, 1};  ///< A, row by row
  Point2 shift;                              ///< b [m]
  Point2 lever;                              ///< of the vehicle's reference point in the marker's frame [m]
  double turn_rad{};
  double lean_per_m{};  ///< 0: the marker does not lean, or a lean does not improve the fit
  Point2 lean;          ///< −lean_per_m·foot
  [[nodiscard]] Pose2 apply(const Pose2& detected) const;
  friend bool operator==(const PoseFit&, const PoseFit&) = default;
};
/// A marker on one vehicle, or on all of one model: its height, and its position on the vehicle.
struct MarkerProfile {
  int id{-1};          ///< of the tag; −1: of every vehicle without a profile of its own
  double height_m{0};  ///< of the tag above the floor
  Pose2 X_BT{};        ///< the tag's pose in the vehicle's body frame: the tag's x points to the right of its image
  /// Fitted to surveyed poses: replaces height and X_BT.
  std::optional<PoseFit> surveyed;
  friend bool operator==(const MarkerProfile&, const MarkerProfile&) = default;
};
/// The vehicle of this tag.
[[nodiscard]] const MarkerProfile& profile_of(int id, const std::vector<MarkerProfile>& profiles);
/// The vehicle's pose from its tag's, detected as if the tag were on the floor.
[[nodiscard]] Pose2 vehicle_at(const Pose2& detected, const MarkerProfile& profile, const CameraPose& camera);

struct PoseResiduals {
  PoseFit fit;              ///< to all poses
  double heading_sd_rad{};  ///< of the detected headings about the fit to all of them
  double rms_m{};           ///< from here on each pose is evaluated by the fit to all others
  double max_m{};
  double heading_rms_rad{};
  double heading_max_rad{};
  std::vector<Pose2> left_out;  ///< of each pose: its mapped position minus the surveyed one, on the floor
  double stopped_m{};           ///< scatter of a stationary marker, mean over the poses
};
/// @param full  A is any matrix; else a scale
/// A lean of the marker is accepted where it improves the positions of left-out poses. Fails ("gvs.poses") on fewer
/// than six poses, and where positions or headings are too few for a result.
[[nodiscard]] Result<PoseResiduals> fit_poses(const std::vector<SurveyedPose>& poses, bool full);

}  // namespace cosiva::vision
