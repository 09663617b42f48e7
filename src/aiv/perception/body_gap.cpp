#include "cosiva/aiv/perception/body_gap.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// A long body is evaluated as discs on its centre line, no further apart than this.
constexpr double disc_spacing_m = 0.05;

}  // namespace

BodyGap::BodyGap(const zone::TrafficZone& zone, Model model)
    : zone_{zone}, model_{model}, look_ahead_{zone.circuit, model.sample_m, model.reach_m} {
  COSIVA_EXPECT(model.margin_m >= 0.0);
}

void BodyGap::update(const Outlook& outlook) {
  look_ahead_.sample(outlook);
  X_BM_ = inverse(outlook.X_MB ? *outlook.X_MB : zone_.circuit.pose_at(outlook.here));
}

double BodyGap::disc_gap_m(Point2 p_B, double radius_m) const {
  const double half_m = 0.5 * zone_.vehicle.width_m + model_.margin_m;
  const PathLookAhead::Offset there = look_ahead_.off_path(p_B);
  const double near_m = half_m + radius_m + look_ahead_.sample_m();
  if (!(there.distance2_m2 < near_m * near_m)) return infinite;
  const double along_m = look_ahead_.along_path_m(p_B, there.sample);
  // Beyond the last sample the path is unknown, and a body behind the body origin does not hold the vehicle.
  if (along_m <= 0.0 || along_m > look_ahead_.length_m() + 0.5 * look_ahead_.sample_m()) return infinite;
  const double beyond_m = along_m - static_cast<double>(there.sample) * look_ahead_.sample_m();
  const double aside_m = std::sqrt(std::max(0.0, there.distance2_m2 - beyond_m * beyond_m));
  // Extent along the path of the disc's part inside the corridor, to either side of the disc's centre.
  const double outside_m = std::max(0.0, aside_m - half_m);
  if (outside_m > radius_m) return infinite;
  const double extent_m = std::sqrt(radius_m * radius_m - outside_m * outside_m);
  return std::max(0.0, along_m - extent_m - 0.5 * zone_.vehicle.length_m);
}

double BodyGap::gap_m(const wire::Body& body, double carried_s) const {
  const Point2 centre_M{body.x_m + body.vx_mps * carried_s, body.y_m + body.vy_mps * carried_s};
  const Point2 centre_B = X_BM_ * centre_M;
  const double half_m = 0.5 * body.length_m;
  if (norm(centre_B.x_m, centre_B.y_m) > model_.reach_m + half_m + body.radius_m) return infinite;
  const auto discs = static_cast<int>(std::ceil(body.length_m / disc_spacing_m)) + 1;
  const auto [sin, cos] = sincos(body.heading_rad + X_BM_.heading_rad);
  double nearest_m = infinite;
  for (int i = 0; i < discs; ++i) {
    const double along_m = discs == 1 ? 0.0 : body.length_m * i / (discs - 1) - half_m;
    const Point2 p_B{centre_B.x_m + along_m * cos, centre_B.y_m + along_m * sin};
    nearest_m = std::min(nearest_m, disc_gap_m(p_B, body.radius_m));
  }
  // A vehicle touched by a body that is mostly behind it drives away from that body; of two vehicles that perceive each
  // other, only one waits.
  if (nearest_m <= 0.0 && centre_B.x_m <= 0.0) return infinite;
  return nearest_m;
}

}  // namespace cosiva::aiv
