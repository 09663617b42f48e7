#include "cosiva/base/pose.h"

namespace cosiva {

Pose2 operator*(const Pose2& X_AB, const Pose2& X_BC) noexcept {
  const Point2 p = X_AB * position(X_BC);
  return {p.x_m, p.y_m, wrap_angle(X_AB.heading_rad + X_BC.heading_rad)};
}

Point2 operator*(const Pose2& X_AB, Point2 p_B) noexcept {
  const auto [s, c] = sincos(X_AB.heading_rad);
  return {X_AB.x_m + c * p_B.x_m - s * p_B.y_m, X_AB.y_m + s * p_B.x_m + c * p_B.y_m};
}

Pose2 inverse(const Pose2& X_AB) noexcept {
  const auto [s, c] = sincos(X_AB.heading_rad);
  return {-(c * X_AB.x_m + s * X_AB.y_m), s * X_AB.x_m - c * X_AB.y_m, wrap_angle(-X_AB.heading_rad)};
}

}  // namespace cosiva
