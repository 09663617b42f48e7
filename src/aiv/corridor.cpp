#include "aiv/corridor.h"

#include <algorithm>
#include <cmath>

#include "base/expect.h"

namespace cosiva::aiv {

Corridor::Corridor(const zone::TrafficZone& zone, Model model) : zone_{zone}, model_{model} {
  COSIVA_EXPECT(model.sample_m > 0.0 && model.reach_m > model.sample_m);
  way_B_.reserve(static_cast<std::size_t>(model.reach_m / model.sample_m) + 2);
}

void Corridor::sample_way(zone::Place here) {
  const zone::Circuit& circuit = zone_.circuit;
  const Pose2 X_MB = circuit.pose_at(here);
  const auto [sin, cos] = sincos(X_MB.heading_rad);
  way_B_.clear();
  zone::SectionId id = here.section;
  double s_m = here.s_m;
  for (double ahead_m = 0.0; ahead_m <= model_.reach_m; ahead_m += model_.sample_m, s_m += model_.sample_m) {
    while (s_m > circuit.section(id).length_m()) {
      if (circuit.next(id).empty()) return;
      s_m -= circuit.section(id).length_m();
      id = circuit.next(id).front();
    }
    const Point2 p_M = position(circuit.section(id).pose_at(s_m));
    const double x_m = p_M.x_m - X_MB.x_m;
    const double y_m = p_M.y_m - X_MB.y_m;
    way_B_.push_back({cos * x_m + sin * y_m, cos * y_m - sin * x_m});
  }
}

Corridor::Beside Corridor::beside(Point2 p_B) const {
  Beside nearest{0, std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i < way_B_.size(); ++i) {
    const double x_m = way_B_[i].x_m - p_B.x_m;
    const double y_m = way_B_[i].y_m - p_B.y_m;
    const double d2_m2 = x_m * x_m + y_m * y_m;
    if (d2_m2 < nearest.distance2_m2) nearest = {i, d2_m2};
  }
  return nearest;
}

double Corridor::along_way_m(Point2 p_B, std::size_t sample) const {
  // Between the samples: along the chord of its neighbours.
  const Point2 before = way_B_[sample == 0 ? 0 : sample - 1];
  const Point2 after = way_B_[std::min(sample + 1, way_B_.size() - 1)];
  const double chord_m = distance(before, after);
  const double along_m = static_cast<double>(sample) * model_.sample_m;
  if (chord_m <= 0.0) return along_m;
  const Point2 here = way_B_[sample];
  return along_m +
         ((p_B.x_m - here.x_m) * (after.x_m - before.x_m) + (p_B.y_m - here.y_m) * (after.y_m - before.y_m)) / chord_m;
}

double Corridor::echo_ahead_m(double range_m, double bearing_rad, double spread_rad) const {
  const double front_m = 0.5 * zone_.vehicle.length_m;
  const double half_m = 0.5 * zone_.vehicle.width_m + model_.margin_m;
  // A point beside the way is at most half a step from a sample's normal.
  const double near_m = norm(half_m, 0.5 * model_.sample_m);
  double nearest_m = std::numeric_limits<double>::infinity();
  for (const double side : {0.0, -1.0, 1.0}) {
    const auto [sin, cos] = sincos(bearing_rad + side * spread_rad);
    const Point2 echo_B{front_m + range_m * cos, range_m * sin};
    const Beside there = beside(echo_B);
    if (there.distance2_m2 < near_m * near_m)
      nearest_m = std::min(nearest_m, along_way_m(echo_B, there.sample) - front_m);
    // Most echoes come from other lanes: where the middle is this far off, the sides of the beam are off too.
    const double spread_m = near_m + spread_rad * range_m;
    if (side == 0.0 && there.distance2_m2 > spread_m * spread_m) break;
  }
  // Beside the body or behind its front is no obstacle ahead, but one that touches.
  return std::max(0.0, nearest_m);
}

double Corridor::obstacle_ahead_m(zone::Place here, const wire::Ranges& ranges) {
  const double reach_m = model_.reach_m - 0.5 * zone_.vehicle.length_m;
  const double width_rad = 0.01 * ranges.beam_width_crad;
  double nearest_m = std::numeric_limits<double>::infinity();
  bool sampled = false;
  for (std::size_t beam = 0; beam < ranges.range_mm.size(); ++beam) {
    if (ranges.range_mm[beam] == wire::no_echo) continue;
    const double range_m = 0.001 * ranges.range_mm[beam];
    if (range_m > reach_m) continue;
    if (!sampled) sample_way(here);
    sampled = true;
    const double bearing_rad = 0.01 * ranges.first_bearing_crad + width_rad * static_cast<double>(beam);
    nearest_m = std::min(nearest_m, echo_ahead_m(range_m, bearing_rad, model_.beam_share * width_rad));
  }
  return nearest_m;
}

void ObstacleFilter::add(double obstacle_ahead_m, double travelled_m) {
  seen_m_[next_] = obstacle_ahead_m + travelled_m;
  next_ = (next_ + 1) % seen_m_.size();
  const auto& [a, b, c] = seen_m_;
  median_m_ = std::max(std::min(a, b), std::min(std::max(a, b), c));
}

}  // namespace cosiva::aiv
