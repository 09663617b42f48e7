#pragma once

#include "cosiva/base/math.h"

namespace cosiva {

struct Point2 {
  double x_m{};
  double y_m{};
  friend bool operator==(const Point2&, const Point2&) = default;
};

/// X_AB: the pose of frame B in frame A. Heading counter-clockwise from A's +x, in (−π, π].
struct Pose2 {
  double x_m{};
  double y_m{};
  double heading_rad{};
  friend bool operator==(const Pose2&, const Pose2&) = default;
};

[[nodiscard]] inline Point2 position(const Pose2& pose) noexcept { return {pose.x_m, pose.y_m}; }

[[nodiscard]] inline double distance(Point2 a, Point2 b) noexcept { return norm(b.x_m - a.x_m, b.y_m - a.y_m); }
[[nodiscard]] inline double distance(const Pose2& a, const Pose2& b) noexcept {
  return distance(position(a), position(b));
}

/// The same position, with the opposite heading.
[[nodiscard]] inline Pose2 turned_round(const Pose2& pose) noexcept {
  return {pose.x_m, pose.y_m, wrap_angle(pose.heading_rad + pi)};
}

/// X_AC = X_AB · X_BC.
[[nodiscard]] Pose2 operator*(const Pose2& X_AB, const Pose2& X_BC) noexcept;
/// p_A = X_AB · p_B.
[[nodiscard]] Point2 operator*(const Pose2& X_AB, Point2 p_B) noexcept;
/// X_BA from X_AB.
[[nodiscard]] Pose2 inverse(const Pose2& X_AB) noexcept;

}  // namespace cosiva
