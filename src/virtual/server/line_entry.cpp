#include "virtual/server/line_entry.h"

#include <algorithm>

#include "base/math.h"

namespace cosiva::virtual_side {
namespace {

constexpr double clear_m = 0.02;  ///< between what is swept and a body

double swept_m(const zone::VehicleShape& shape) { return 0.5 * norm(shape.length_m, shape.width_m); }

double distance_to_segment(Point2 p, const LineEntry& segment) {
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
double side(const LineEntry& segment, Point2 c) {
  return (segment.to.x_m - segment.from.x_m) * (c.y_m - segment.from.y_m) -
         (segment.to.y_m - segment.from.y_m) * (c.x_m - segment.from.x_m);
}

double distance_between(const LineEntry& a, const LineEntry& b) {
  if (side(a, b.from) * side(a, b.to) < 0.0 && side(b, a.from) * side(b, a.to) < 0.0) return 0.0;
  return std::min({distance_to_segment(a.from, b), distance_to_segment(a.to, b), distance_to_segment(b.from, a),
                   distance_to_segment(b.to, a)});
}

}  // namespace

bool near_body(const LineEntry& entry, const zone::VehicleShape& shape, const Pose2& X_MB) {
  const double half_m = 0.5 * std::max(0.0, shape.length_m - shape.width_m);
  const LineEntry body{X_MB * Point2{-half_m, 0.0}, X_MB * Point2{half_m, 0.0}};
  return distance_between(entry, body) < swept_m(shape) + 0.5 * shape.width_m + clear_m;
}

bool near_entry(const LineEntry& a, const zone::VehicleShape& shape, const LineEntry& b) {
  return distance_between(a, b) < 2.0 * swept_m(shape) + clear_m;
}

}  // namespace cosiva::virtual_side
