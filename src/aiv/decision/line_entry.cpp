#include "cosiva/aiv/decision/line_entry.h"

#include <algorithm>
#include <cmath>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::aiv {
namespace {

/// Error of reports: a foot this near may lie in any direction from the vehicle, and a foot this nearly behind it on
/// either side.
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

/// Extent of a box from its centre along the axes of a frame in which it is turned by `heading_rad`.
Point2 reach(const Box& box, double heading_rad) {
  const auto [sin, cos] = sincos(heading_rad);
  return {std::fabs(cos) * box.half_length_m + std::fabs(sin) * box.half_width_m,
          std::fabs(sin) * box.half_length_m + std::fabs(cos) * box.half_width_m};
}

/// Whether one of a's sides separates the two.
bool parted_by_sides_of(const Box& a, const Box& b) {
  const Pose2 X_AB = inverse(a.X_MB) * b.X_MB;
  const Point2 b_reach = reach(b, X_AB.heading_rad);
  return std::fabs(X_AB.x_m) > a.half_length_m + b_reach.x_m || std::fabs(X_AB.y_m) > a.half_width_m + b_reach.y_m;
}

bool touch(const Box& a, const Box& b) { return !parted_by_sides_of(a, b) && !parted_by_sides_of(b, a); }

/// One full turn on the spot, in either direction.
bool touched_turning(Point2 centre, const zone::VehicleShape& shape, const Box& other, double clear_m) {
  const Point2 p = inverse(other.X_MB) * centre;
  const double dx = std::max(0.0, std::fabs(p.x_m) - other.half_length_m);
  const double dy = std::max(0.0, std::fabs(p.y_m) - other.half_width_m);
  return norm(dx, dy) < swept_m(shape) + clear_m;
}

}  // namespace

bool near_bodies(const zone::VehicleShape& shape, const Pose2& X_MA, const Pose2& X_MB, double clear_m) {
  // Further apart than their corners reach: no need to turn anything.
  const double corner_m = 0.5 * norm(shape.length_m, shape.width_m);
  const double far_m = 2.0 * corner_m + norm(clear_m, clear_m) + 1e-6;
  if (distance(X_MA, X_MB) > far_m) return false;
  return touch(box(X_MA, shape, clear_m), box(X_MB, shape, 0.0));
}

bool lies_ahead(const zone::VehicleShape& shape, const Pose2& X_MA, const Pose2& X_MB) {
  const Pose2 X_AB = inverse(X_MA) * X_MB;
  return X_AB.x_m + reach(box(X_MB, shape, 0.0), X_AB.heading_rad).x_m > 0.5 * shape.length_m;
}

void EntrySweep::take(const LineEntry& entry) {
  entry_ = entry;
  const Pose2 X_SG = inverse(entry.from) * entry.to;
  const double behind_rad = pi - std::fabs(det_atan2(X_SG.y_m, X_SG.x_m));
  turns_either_direction_ = norm(X_SG.x_m, X_SG.y_m) < unsure_m || behind_rad < unsure_rad;
  constexpr double step_s = 0.05;
  constexpr double speed_mps = 0.15;
  poses_.clear();
  for (Manoeuvre manoeuvre{X_SG}; !manoeuvre.done(); manoeuvre.step(speed_mps, step_s))
    poses_.push_back(entry.from * manoeuvre.X_SB());
  poses_.push_back(entry.to);
}

void EntrySweep::take_rest(const LineEntry& entry, const Pose2& X_OB) {
  take(entry);
  turns_either_direction_ = false;
  const Pose2 X_MB = entry.from * X_OB;
  constexpr double m_per_rad = 0.1;  // at a corner
  const auto off_m = [&](const Pose2& X_MS) {
    return distance(X_MS, X_MB) + m_per_rad * std::fabs(wrap_angle(X_MS.heading_rad - X_MB.heading_rad));
  };
  poses_.erase(poses_.begin(), std::ranges::min_element(poses_, {}, off_m));
  COSIVA_EXPECT(!poses_.empty() && poses_.back() == entry_.to);
}

bool EntrySweep::near_body(const Pose2& X_MB, double clear_m) const {
  const double far_m = 2.0 * swept_m(shape_) + clear_m;
  if (distance_between(middles(entry_), {position(X_MB), position(X_MB)}) >= far_m) return false;
  const Box other = box(X_MB, shape_, 0.0);
  if (turns_either_direction_ && touched_turning(position(entry_.from), shape_, other, clear_m)) return true;
  return std::ranges::any_of(poses_, [&](const Pose2& X_MS) { return touch(box(X_MS, shape_, clear_m), other); });
}

bool EntrySweep::over(Point2 p_M) const {
  return std::ranges::any_of(poses_, [&](const Pose2& X_MS) {
    const Point2 p_S = inverse(X_MS) * p_M;
    return std::fabs(p_S.x_m) < 0.5 * shape_.length_m && std::fabs(p_S.y_m) < 0.5 * shape_.width_m;
  });
}

bool near_entry(const LineEntry& a, const zone::VehicleShape& shape, const LineEntry& b) {
  return distance_between(middles(a), middles(b)) < 2.0 * swept_m(shape) + entry_clear_m;
}

}  // namespace cosiva::aiv
