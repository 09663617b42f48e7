#include "cosiva/physical/vision/scene.h"

#include <cmath>

namespace cosiva::vision {
namespace {

/// Rows of the rotation from the floor's frame to the camera's: x right, y down, z away from it.
struct Rotation {
  std::array<double, 9> r;
};

Rotation rotation_of(const SceneCamera& camera) {
  const auto [sy, cy] = sincos(camera.yaw_rad);
  const auto [sa, ca] = sincos(camera.tilt_x_rad);
  const auto [sb, cb] = sincos(camera.tilt_y_rad);
  // Plumb: right is (cos yaw, sin yaw, 0), down in the image is (sin yaw, −cos yaw, 0), away is (0, 0, −1).
  const std::array<double, 9> plumb{cy, sy, 0.0, sy, -cy, 0.0, 0.0, 0.0, -1.0};
  const std::array<double, 9> tilt{cb, sa * sb, ca * sb, 0.0, ca, -sa, -sb, sa * cb, ca * cb};
  Rotation rotation{};
  for (std::size_t i = 0; i < 3; ++i)
    for (std::size_t j = 0; j < 3; ++j)
      for (std::size_t k = 0; k < 3; ++k) rotation.r[3 * i + j] += tilt[3 * i + k] * plumb[3 * k + j];
  return rotation;
}

/// Brown's model, and its growth along the radius: where it shrinks, the lens folds and shows nothing more.
struct Bent {
  double x;
  double y;
  bool folded;
};
Bent bend(double x, double y, const std::array<double, 5>& k) {
  const double r2 = x * x + y * y;
  const double radial = 1.0 + r2 * (k[0] + r2 * (k[1] + r2 * k[2]));
  const double growth = 1.0 + r2 * (3.0 * k[0] + r2 * (5.0 * k[1] + r2 * 7.0 * k[2]));
  return {x * radial + 2.0 * k[3] * x * y + k[4] * (r2 + 2.0 * x * x),
          y * radial + k[3] * (r2 + 2.0 * y * y) + 2.0 * k[4] * x * y, !(growth > 0.05)};
}

}  // namespace

std::optional<PixelPoint> SceneCamera::pixel_of(Point2 position, double above_m) const {
  const auto [r] = rotation_of(*this);
  const double x = position.x_m - foot.x_m;
  const double y = position.y_m - foot.y_m;
  const double z = above_m - height_m;
  const double away = r[6] * x + r[7] * y + r[8] * z;
  if (!(away > 1e-6)) return std::nullopt;
  const Bent bent = bend((r[0] * x + r[1] * y + r[2] * z) / away, (r[3] * x + r[4] * y + r[5] * z) / away, lens);
  if (bent.folded) return std::nullopt;
  return PixelPoint{principal.u + focal_px * bent.x, principal.v + focal_px * bent.y};
}

std::optional<Point2> SceneCamera::floor_of(PixelPoint pixel) const {
  const double wanted_x = (pixel.u - principal.u) / focal_px;
  const double wanted_y = (pixel.v - principal.v) / focal_px;
  double x = wanted_x;
  double y = wanted_y;
  // A fixed point: the lens's displacement is small, so its change is smaller still.
  constexpr int rounds = 40;
  for (int round = 0; round < rounds; ++round) {
    const Bent bent = bend(x, y, lens);
    x += wanted_x - bent.x;
    y += wanted_y - bent.y;
    if (std::fabs(wanted_x - bent.x) + std::fabs(wanted_y - bent.y) < 1e-12) break;
  }
  const Bent bent = bend(x, y, lens);
  if (bent.folded || !(std::fabs(bent.x - wanted_x) + std::fabs(bent.y - wanted_y) < 1e-8)) return std::nullopt;
  const auto [r] = rotation_of(*this);
  const double down = r[2] * x + r[5] * y + r[8];
  if (!(down < -1e-6)) return std::nullopt;
  const double far = -height_m / down;
  return Point2{foot.x_m + far * (r[0] * x + r[3] * y + r[6]), foot.y_m + far * (r[1] * x + r[4] * y + r[7])};
}

Pose2 SceneBody::after(double seconds) const {
  const double turned = turn_radps * seconds;
  const double travelled_m = speed_mps * seconds;
  const auto [s, c] = sincos(X_MB.heading_rad + 0.5 * turned);
  // The chord of so short an arc is its length to 1e-6 of it.
  return {X_MB.x_m + travelled_m * c, X_MB.y_m + travelled_m * s, wrap_angle(X_MB.heading_rad + turned)};
}

}  // namespace cosiva::vision
