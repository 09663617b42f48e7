#pragma once

#include <array>
#include <optional>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/physical/vision/floor_map.h"

/// The emulated world, as a camera under the roof sees it: pictures with everything that makes real ones bad.
namespace cosiva::vision {

/// A camera that looks down. Its lens bends as Brown's model has it *towards* the picture, which is another form than
/// the calibration fits: who is judged by these pictures cannot have read the answer out of them.
struct SceneCamera {
  ImageSize frame{2048, 2048};
  Point2 foot{};            ///< straight below it [m]
  double height_m{3.3};     ///< above the floor
  double yaw_rad{0.0};      ///< the picture's right shows so far left of the floor's +x
  double tilt_x_rad{0.01};  ///< it does not hang quite plumb
  double tilt_y_rad{-0.015};
  double focal_px{1900.0};
  PixelPoint principal{1030.0, 1015.0};
  std::array<double, 5> lens{-0.18, 0.05, -0.004, 4e-4, -3e-4};  ///< k1, k2, k3, p1, p2
  double exposure_s{0.004};
  double line_s{0.0};       ///< rolling shutter: each row begins so much after the one above; 0: a global shutter
  double noise_grey{2.0};   ///< standard deviation per pixel
  double brightness{1.0};   ///< of all light; too much and white is lost
  double vignetting{0.25};  ///< share of light that the corners lack

  /// The pixel that shows a place so high above the floor. Nothing behind the camera, and where the lens folds.
  [[nodiscard]] std::optional<PixelPoint> pixel_of(Point2 position, double height_m) const;
  /// The place of the floor that a pixel looks at.
  [[nodiscard]] std::optional<Point2> floor_of(PixelPoint pixel) const;
};

/// A vehicle with a tag on its roof, or a tag that lies on the floor (no body). What moves, moves evenly during a
/// picture.
struct SceneBody {
  int tag{};
  Pose2 X_MB{};        ///< at the picture's stamp
  double speed_mps{};  ///< along its heading
  double turn_radps{};
  double height_m{0.10};  ///< of the tag above the floor
  double side_m{0.08};    ///< of the tag's black square
  Pose2 X_BT{};           ///< where the tag is on it
  double length_m{0.20};  ///< of the roof; 0: there is none
  double width_m{0.12};

  [[nodiscard]] Pose2 after(double seconds) const;
};

/// A painted line on the floor.
struct SceneLine {
  std::vector<Point2> points;
  double width_m{0.02};
};

}  // namespace cosiva::vision
