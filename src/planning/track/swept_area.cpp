#include "cosiva/planning/track/swept_area.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::planning {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();
constexpr double turn_step_rad = pi / 16.0;

double dot(Point2 a, Point2 b) { return a.x_m * b.x_m + a.y_m * b.y_m; }

}  // namespace

SweptArea::SweptArea(const zone::VehicleShape& shape, double clearance_m)
    : half_length_m_{0.5 * shape.length_m + clearance_m},
      half_width_m_{0.5 * shape.width_m + clearance_m},
      box_{infinity, -infinity, infinity, -infinity} {
  COSIVA_EXPECT(half_length_m_ > 0.0 && half_width_m_ > 0.0);
}

void SweptArea::add_pose(const Pose2& X_MB) {
  const double c = det_cos(X_MB.heading_rad);
  const double s = det_sin(X_MB.heading_rad);
  const Rectangle added{
      position(X_MB), {half_length_m_ * c, half_length_m_ * s}, {-half_width_m_ * s, half_width_m_ * c}};
  const double reach_x_m = std::fabs(added.along.x_m) + std::fabs(added.left.x_m);
  const double reach_y_m = std::fabs(added.along.y_m) + std::fabs(added.left.y_m);
  box_.x_min_m = std::min(box_.x_min_m, X_MB.x_m - reach_x_m);
  box_.x_max_m = std::max(box_.x_max_m, X_MB.x_m + reach_x_m);
  box_.y_min_m = std::min(box_.y_min_m, X_MB.y_m - reach_y_m);
  box_.y_max_m = std::max(box_.y_max_m, X_MB.y_m + reach_y_m);
  rectangles_.push_back(added);
}

void SweptArea::add_turn(const Pose2& X_MB, double turn_rad) {
  const auto steps = static_cast<int>(std::ceil(std::fabs(turn_rad) / turn_step_rad));
  for (int i = 0; i <= steps; ++i)
    add_pose({X_MB.x_m, X_MB.y_m, wrap_angle(X_MB.heading_rad + (steps == 0 ? 0.0 : turn_rad * i / steps))});
}

void SweptArea::add_drive(const zone::Circuit& circuit, zone::SectionId section, double from_m, double to_m) {
  // Half a body's width apart, the rectangles of a bend leave no gap wider than the clearance they were enlarged by.
  const auto steps = std::max(1, static_cast<int>(std::ceil((to_m - from_m) / half_width_m_)));
  for (int i = 0; i <= steps; ++i) add_pose(circuit.pose_at({section, from_m + (to_m - from_m) * i / steps}));
}

bool SweptArea::boxes_touch(const SweptArea& other) const {
  return box_.x_max_m >= other.box_.x_min_m && other.box_.x_max_m >= box_.x_min_m &&
         box_.y_max_m >= other.box_.y_min_m && other.box_.y_max_m >= box_.y_min_m;
}

std::optional<std::size_t> SweptArea::last_touching(const SweptArea& other) const {
  if (!boxes_touch(other)) return std::nullopt;
  for (std::size_t i = rectangles_.size(); i-- > 0;)
    if (std::ranges::any_of(other.rectangles_, [&](const Rectangle& its) { return touch(rectangles_[i], its); }))
      return i;
  return std::nullopt;
}

bool SweptArea::touches(const SweptArea& other) const {
  if (!boxes_touch(other)) return false;
  return std::ranges::any_of(rectangles_, [&](const Rectangle& mine) {
    return std::ranges::any_of(other.rectangles_, [&](const Rectangle& its) { return touch(mine, its); });
  });
}

bool SweptArea::touch(const Rectangle& a, const Rectangle& b) {
  // Separating axes: two rectangles are apart if they are along one of their four edges' directions.
  const Point2 between{b.centre.x_m - a.centre.x_m, b.centre.y_m - a.centre.y_m};
  const auto apart = [&](Point2 axis) {
    return std::fabs(dot(between, axis)) > std::fabs(dot(a.along, axis)) + std::fabs(dot(a.left, axis)) +
                                               std::fabs(dot(b.along, axis)) + std::fabs(dot(b.left, axis));
  };
  return !apart(a.along) && !apart(a.left) && !apart(b.along) && !apart(b.left);
}

}  // namespace cosiva::planning
