#pragma once

#include "cosiva/base/math.h"
#include "cosiva/base/pose.h"

namespace cosiva::physical {

/// A pose with the sine and cosine of its heading, computed once per tick and used by ranging and collision detection.
struct BodyPose {
  Pose2 X_MB;
  double sin{0.0};
  double cos{1.0};

  [[nodiscard]] static BodyPose at(const Pose2& X_MB) {
    const auto [s, c] = sincos(X_MB.heading_rad);
    return {X_MB, s, c};
  }
  /// p_M of a point fixed to the body.
  [[nodiscard]] Point2 to_map(Point2 p_B) const {
    return {X_MB.x_m + cos * p_B.x_m - sin * p_B.y_m, X_MB.y_m + sin * p_B.x_m + cos * p_B.y_m};
  }
  /// p_B of a point of the map.
  [[nodiscard]] Point2 to_body(Point2 p_M) const {
    const double x = p_M.x_m - X_MB.x_m;
    const double y = p_M.y_m - X_MB.y_m;
    return {cos * x + sin * y, cos * y - sin * x};
  }
};

/// A round object in the zone.
struct Disc {
  Point2 centre;
  double radius_m;
};

}  // namespace cosiva::physical
