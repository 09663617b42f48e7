#include "virtual/server/line_entry.h"

#include <algorithm>
#include <cmath>

#include "aiv/manoeuvre.h"
#include "base/math.h"

namespace cosiva::virtual_side {
namespace {

/// Reports are as wrong as this: a foot so near may lie anywhere round the vehicle, one so far behind it on either
/// side.
constexpr double unsure_m = 0.03;
constexpr double unsure_rad = 0.3;

struct Segment {
  Point2 from;
  Point2 to;
};
Segment middles(const LineEntry& entry) { return {position(entry.from), position(entry.to)}; }

double swept_m(const zone::VehicleShape& shape) { return 0.5 * norm(shape.length_m, shape.width_m); }

double distance_to_segment(Point2 p, const Segment& segment) {
  const double dx = segment.to.x_m - segment.from.x_m;
  const double dy = segment.to.y_m - segment.from.y_m;
  const double length2 = dx * dx + dy * dy;
  const double along =
      length2 > 0.0
          ? std::clamp(((p.x_m - segment.from.x_m) * dx + (p.y_m - segment.from.y_m) * dy) / length2, 0.0, 1.0)
          : 0.0;
  return norm(p.x_m - segment.from.x_m - along * dx, p.y_m - segment.from.y_m - along * dy);
}

/// Positive where c lies to the left of the segment.
double side(const Segment& segment, Point2 c) {
  return (segment.to.x_m - segment.from.x_m) * (c.y_m - segment.from.y_m) -
         (segment.to.y_m - segment.from.y_m) * (c.x_m - segment.from.x_m);
}

double distance_between(const Segment& a, const Segment& b) {
  if (side(a, b.from) * side(a, b.to) < 0.0 && side(b, a.from) * side(b, a.to) < 0.0) return 0.0;
  return std::min({distance_to_segment(a.from, b), distance_to_segment(a.to, b), distance_to_segment(b.from, a),
                   distance_to_segment(b.to, a)});
}

/// A body, `more_m` larger on all sides, in its own frame.
struct Box {
  Pose2 X_MB;
  double half_length_m;
  double half_width_m;
};
Box box(const Pose2& X_MB, const zone::VehicleShape& shape, double more_m) {
  return {X_MB, 0.5 * shape.length_m + more_m, 0.5 * shape.width_m + more_m};
}

/// Whether one of a's sides lies between the two.
bool parted_by_sides_of(const Box& a, const Box& b) {
  const Pose2 X_AB = inverse(a.X_MB) * b.X_MB;
  const auto [sin, cos] = sincos(X_AB.heading_rad);
  const double reach_x = std::fabs(cos) * b.half_length_m + std::fabs(sin) * b.half_width_m;
  const double reach_y = std::fabs(sin) * b.half_length_m + std::fabs(cos) * b.half_width_m;
  return std::fabs(X_AB.x_m) > a.half_length_m + reach_x || std::fabs(X_AB.y_m) > a.half_width_m + reach_y;
}

bool touch(const Box& a, const Box& b) { return !parted_by_sides_of(a, b) && !parted_by_sides_of(b, a); }

/// Turning once round where it stands, whichever way.
bool touched_turning(Point2 middle, const zone::VehicleShape& shape, const Box& other, double clear_m) {
  const Point2 p = inverse(other.X_MB) * middle;
  const double dx = std::max(0.0, std::fabs(p.x_m) - other.half_length_m);
  const double dy = std::max(0.0, std::fabs(p.y_m) - other.half_width_m);
  return norm(dx, dy) < swept_m(shape) + clear_m;
}

}  // namespace

bool near_body(const LineEntry& entry, const zone::VehicleShape& shape, const Pose2& X_MB, double clear_m) {
  const double far_m = 2.0 * swept_m(shape) + clear_m;
  if (distance_between(middles(entry), {position(X_MB), position(X_MB)}) >= far_m) return false;
  const Box other = box(X_MB, shape, 0.0);
  const Pose2 X_SG = inverse(entry.from) * entry.to;
  const double behind_rad = pi - std::fabs(det_atan2(X_SG.y_m, X_SG.x_m));
  if ((norm(X_SG.x_m, X_SG.y_m) < unsure_m || behind_rad < unsure_rad) &&
      touched_turning(position(entry.from), shape, other, clear_m))
    return true;
  constexpr double step_s = 0.05;  // a corner moves by less than a centimetre
  constexpr double speed_mps = 0.15;
  for (aiv::Manoeuvre manoeuvre{X_SG}; !manoeuvre.done(); manoeuvre.step(speed_mps, step_s))
    if (touch(box(entry.from * manoeuvre.X_SB(), shape, clear_m), other)) return true;
  return touch(box(entry.to, shape, clear_m), other);
}

bool near_entry(const LineEntry& a, const zone::VehicleShape& shape, const LineEntry& b) {
  return distance_between(middles(a), middles(b)) < 2.0 * swept_m(shape) + entry_clear_m;
}

}  // namespace cosiva::virtual_side
