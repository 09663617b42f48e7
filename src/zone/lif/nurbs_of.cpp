#include "cosiva/zone/lif/nurbs_of.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::lif {
namespace {

constexpr double position_m = 5e-5;
constexpr double heading_rad = 1e-4;
constexpr double quarter_rad = 0.49 * pi;
constexpr std::size_t pieces_max = 4096;

/// `times` equal knots between pieces, degree + 1 at both ends.
std::vector<double> piecewise_knots(std::size_t pieces, std::size_t degree) {
  std::vector<double> knots(degree + 1, 0.0);
  for (std::size_t i = 1; i < pieces; ++i)
    knots.insert(knots.end(), degree, static_cast<double>(i) / static_cast<double>(pieces));
  knots.insert(knots.end(), degree + 1, 1.0);
  return knots;
}

Point2 ahead(const Pose2& pose, double distance_m) {
  const SinCos direction = sincos(pose.heading_rad);
  return {pose.x_m + distance_m * direction.cos, pose.y_m + distance_m * direction.sin};
}

Nurbs arc(const Section& section) {
  const double curvature = section.curvature_at(0.0);
  const double turn_rad = std::fabs(curvature) * section.length_m();
  const auto pieces = static_cast<std::size_t>(std::floor(turn_rad / quarter_rad)) + 1;
  const double half_rad = 0.5 * turn_rad / static_cast<double>(pieces);
  const SinCos half = sincos(half_rad);
  // Of weights only the ratios count: 1, cos, 1 … is as good as 1/cos, 1, 1/cos ….
  const double tangent_m = half.sin / half.cos / std::fabs(curvature);

  Nurbs curve{2, piecewise_knots(pieces, 2), {}, {}};
  for (std::size_t i = 0; i < pieces; ++i) {
    const Pose2 pose = section.pose_at(section.length_m() * static_cast<double>(i) / static_cast<double>(pieces));
    curve.points.push_back(position(pose));
    curve.weights.push_back(1.0 / half.cos);
    curve.points.push_back(ahead(pose, tangent_m));
    curve.weights.push_back(1.0);
  }
  curve.points.push_back(position(section.end()));
  curve.weights.push_back(1.0 / half.cos);
  return curve;
}

Nurbs cubic(const Section& section, std::size_t pieces) {
  const double piece_m = section.length_m() / static_cast<double>(pieces);
  Nurbs curve{3, piecewise_knots(pieces, 3), {position(section.start())}, {}};
  Pose2 from = section.start();
  for (std::size_t i = 1; i <= pieces; ++i) {
    const Pose2 to = i == pieces ? section.end() : section.pose_at(piece_m * static_cast<double>(i));
    curve.points.push_back(ahead(from, piece_m / 3.0));
    curve.points.push_back(ahead(to, -piece_m / 3.0));
    curve.points.push_back(position(to));
    from = to;
  }
  curve.weights.assign(curve.points.size(), 1.0);
  return curve;
}

bool keeps_to(const Nurbs& curve, const Section& section, std::size_t pieces) {
  const std::size_t checks = 8 * pieces;
  for (std::size_t i = 1; i < checks; ++i) {
    const double u = static_cast<double>(i) / static_cast<double>(checks);
    const Pose2 pose = curve.pose_at(u);
    // The curve runs nearly at constant speed: its parameter is nearly the arc length, and Newton's method corrects the
    // rest.
    double s = u * section.length_m();
    Pose2 foot;
    for (int round = 0; round < 3; ++round) {
      foot = section.pose_at(s);
      const SinCos direction = sincos(foot.heading_rad);
      s += direction.cos * (pose.x_m - foot.x_m) + direction.sin * (pose.y_m - foot.y_m);
    }
    foot = section.pose_at(s);
    if (!(distance(foot, pose) <= position_m)) return false;
    if (!(std::fabs(wrap_angle(foot.heading_rad - pose.heading_rad)) <= heading_rad)) return false;
  }
  return true;
}

}  // namespace

Nurbs nurbs_of(const Section& section) {
  if (section.kind() == SectionKind::straight)
    return {1, {0.0, 0.0, 1.0, 1.0}, {position(section.start()), position(section.end())}, {1.0, 1.0}};
  if (section.kind() == SectionKind::arc) return arc(section);
  for (std::size_t pieces = 1;; pieces *= 2) {
    Nurbs curve = cubic(section, pieces);
    if (pieces >= pieces_max || keeps_to(curve, section, pieces)) return curve;
  }
}

}  // namespace cosiva::zone::lif
