#pragma once

#include <array>
#include <optional>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/physical/vision/floor_map.h"

/// The emulated floor as an overhead camera records it: images with all the disturbances of real ones.
namespace cosiva::vision {

/// A camera that points down. Its lens follows Brown's model *towards* the image, another form than the calibration
/// fits: a program that is evaluated on these images cannot have taken the result from them.
struct SceneCamera {
  ImageSize frame{2048, 2048};
  Point2 foot{};            ///< directly below it [m]
  double height_m{3.3};     ///< above the floor
  double yaw_rad{0.0};      ///< angle of the image's right from the floor's +x, left positive
  double tilt_x_rad{0.01};  ///< deviation from plumb
  double tilt_y_rad{-0.015};
  double focal_px{1900.0};
  PixelPoint principal{1030.0, 1015.0};
  std::array<double, 5> lens{-0.18, 0.05, -0.004, 4e-4, -3e-4};  ///< k1, k2, k3, p1, p2
  double exposure_s{0.004};
  double line_s{0.0};       ///< rolling shutter: delay of each row after the one above; 0: a global shutter
  double noise_grey{2.0};   ///< standard deviation per pixel
  double brightness{1.0};   ///< of all light; too much overexposes white
  double vignetting{0.25};  ///< part of the light that the corners lack

  /// The pixel of a position at this height above the floor. Nothing behind the camera, and where the lens folds.
  [[nodiscard]] std::optional<PixelPoint> pixel_of(Point2 position, double height_m) const;
  /// The floor position of a pixel.
  [[nodiscard]] std::optional<Point2> floor_of(PixelPoint pixel) const;
};

/// A vehicle with a tag on its roof, or a tag on the floor (no body). A moving body moves evenly during an image.
struct SceneBody {
  int tag{};
  Pose2 X_MB{};        ///< at the image's stamp
  double speed_mps{};  ///< along its heading
  double turn_radps{};
  double height_m{0.10};  ///< of the tag above the floor
  double side_m{0.08};    ///< of the tag's black square
  Pose2 X_BT{};           ///< the tag's position on it
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
