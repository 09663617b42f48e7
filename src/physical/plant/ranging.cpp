#include "cosiva/physical/plant/ranging.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"

namespace cosiva::physical {
namespace {

constexpr double no_range = -1.0;
constexpr double rounding_m = 1e-9;

double cross(Point2 a, Point2 b) { return a.x_m * b.y_m - a.y_m * b.x_m; }
double dot(Point2 a, Point2 b) { return a.x_m * b.x_m + a.y_m * b.y_m; }

}  // namespace

RangeFan::RangeFan(const zone::VehicleShape& shape)
    : half_length_m_{0.5 * shape.length_m},
      half_width_m_{0.5 * shape.width_m},
      half_diagonal_m_{0.5 * norm(shape.length_m, shape.width_m)} {
  for (std::size_t i = 0; i < border_.size(); ++i) {
    const double bearing_crad =
        DobsBoard::first_bearing_crad + (static_cast<double>(i) - 0.5) * DobsBoard::beam_width_crad;
    const auto [sin, cos] = sincos(bearing_crad * 0.01);
    border_[i] = {cos, sin};
  }
}

void RangeFan::aim(const BodyPose& body) {
  body_ = body;
  scan_.fill(no_range);
}

Point2 RangeFan::to_sensor(Point2 p_M) const {
  const Point2 p_B = body_.to_body(p_M);
  return {p_B.x_m - half_length_m_, p_B.y_m};
}

void RangeFan::take(std::size_t beam, double range_m) {
  if (range_m > DobsBoard::reach_m) return;
  COSIVA_EXPECT(range_m > -rounding_m);
  if (scan_[beam] < 0.0 || range_m < scan_[beam]) scan_[beam] = range_m;
}

void RangeFan::see(const BodyPose& other) {
  const Point2 centre = to_sensor(position(other.X_MB));
  // All beams point forward: a body behind the sensor, or out of reach, needs no further computation.
  if (centre.x_m < -half_diagonal_m_) return;
  const double far_m = DobsBoard::reach_m + half_diagonal_m_;
  if (dot(centre, centre) > far_m * far_m) return;
  // Nor does a body that lies wholly to the right or to the left of the fan.
  const double off_m = half_diagonal_m_ + rounding_m;
  if (cross(border_.front(), centre) < -off_m || cross(border_.back(), centre) > off_m) return;

  const double l = half_length_m_;
  const double w = half_width_m_;
  const std::array<Point2, 4> corner{to_sensor(other.to_map({l, w})), to_sensor(other.to_map({-l, w})),
                                     to_sensor(other.to_map({-l, -w})), to_sensor(other.to_map({l, -w}))};
  bool outside = false;
  for (std::size_t i = 0; i < corner.size(); ++i) {
    const Point2 from = corner[i];
    const Point2 to = corner[(i + 1) % corner.size()];
    // Corners are in counter-clockwise order, so the sensor detects the edges that pass it to the right.
    if (cross(from, to) >= 0.0) continue;
    outside = true;
    see_edge(from, to);
  }
  if (!outside) scan_.fill(0.0);  // the sensor is inside the other body
}

void RangeFan::see_edge(Point2 from, Point2 to) {
  const Point2 direction{to.x_m - from.x_m, to.y_m - from.y_m};
  const double length_sq = dot(direction, direction);
  const double foot = -dot(from, direction) / length_sq;
  // Of an edge in front of the sensor: once a beam lies to its left, so do all further beams.
  const bool in_front = from.x_m > 0.0 && to.x_m > 0.0;
  // The cross product of a border with a point to its left is positive; along the edge it changes linearly.
  double right_from = cross(border_[0], from);
  double right_to = cross(border_[0], to);
  for (std::size_t beam = 0; beam < DobsBoard::beams; ++beam) {
    const bool is_to_the_right = right_from < 0.0 && right_to < 0.0;
    if (is_to_the_right && in_front) return;
    const double left_from = cross(border_[beam + 1], from);
    const double left_to = cross(border_[beam + 1], to);
    if (!is_to_the_right && !(left_from > 0.0 && left_to > 0.0)) {
      double low = 0.0;
      double high = 1.0;
      if (right_from < 0.0) low = std::max(low, right_from / (right_from - right_to));
      if (right_to < 0.0) high = std::min(high, right_from / (right_from - right_to));
      if (left_from > 0.0) low = std::max(low, left_from / (left_from - left_to));
      if (left_to > 0.0) high = std::min(high, left_from / (left_from - left_to));
      const double ratio = std::max(low, std::min(high, foot));
      if (low <= high) take(beam, norm(from.x_m + ratio * direction.x_m, from.y_m + ratio * direction.y_m));
    }
    right_from = left_from;
    right_to = left_to;
  }
}

void RangeFan::see(const Disc& disc) {
  const Point2 centre = to_sensor(disc.centre);
  const double r = disc.radius_m;
  const double distance_sq = dot(centre, centre);
  if (distance_sq <= r * r) return scan_.fill(0.0);
  if (centre.x_m < -r || distance_sq > (DobsBoard::reach_m + r) * (DobsBoard::reach_m + r)) return;
  for (std::size_t beam = 0; beam < DobsBoard::beams; ++beam) {
    if (cross(border_[beam], centre) >= 0.0 && cross(border_[beam + 1], centre) <= 0.0) {
      take(beam, std::sqrt(distance_sq) - r);
      continue;
    }
    // The centre is outside the sector: its nearest point within lies on one of the two borders.
    for (const Point2 border : {border_[beam], border_[beam + 1]}) {
      const double off = cross(border, centre);
      const double along = dot(border, centre);
      if (along > 0.0 && off * off <= r * r) take(beam, along - std::sqrt(r * r - off * off));
    }
  }
}

Scan RangeFan::measured(const Scan& exact, double sd_m, double dropout, Random& random) {
  Scan scan = exact;
  for (double& range_m : scan) {
    if (range_m < 0.0) continue;
    if (random.chance(dropout))
      range_m = no_range;
    else
      range_m = std::max(0.0, range_m + random.gaussian(0.0, sd_m));
  }
  return scan;
}

}  // namespace cosiva::physical
