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
    const Pose2 X_MP = circuit.section(id).pose_at(s_m);
    const double x_m = X_MP.x_m - X_MB.x_m;
    const double y_m = X_MP.y_m - X_MB.y_m;
    way_B_.push_back({cos * x_m + sin * y_m, cos * y_m - sin * x_m});
  }
}

/// Along the way from the vehicle's middle to the place beside p, if p is within the corridor there.
double Corridor::nearest_on_way_m(Point2 p_B) const {
  const double half_m = 0.5 * zone_.vehicle.width_m + model_.margin_m;
  // A point beside the way is at most half a step from a sample's normal.
  double best2_m2 = half_m * half_m + 0.25 * model_.sample_m * model_.sample_m;
  std::size_t best = way_B_.size();
  for (std::size_t i = 0; i < way_B_.size(); ++i) {
    const double x_m = way_B_[i].x_m - p_B.x_m;
    const double y_m = way_B_[i].y_m - p_B.y_m;
    const double d2_m2 = x_m * x_m + y_m * y_m;
    if (d2_m2 < best2_m2) {
      best2_m2 = d2_m2;
      best = i;
    }
  }
  if (best == way_B_.size()) return std::numeric_limits<double>::infinity();
  // Between the samples: along the chord of its neighbours.
  const Point2 before = way_B_[best == 0 ? 0 : best - 1];
  const Point2 after = way_B_[std::min(best + 1, way_B_.size() - 1)];
  const double chord_m = distance(before, after);
  double along_m = static_cast<double>(best) * model_.sample_m;
  if (chord_m > 0.0) {
    const Point2 here = way_B_[best];
    along_m +=
        ((p_B.x_m - here.x_m) * (after.x_m - before.x_m) + (p_B.y_m - here.y_m) * (after.y_m - before.y_m)) / chord_m;
  }
  return along_m;
}

double Corridor::obstacle_ahead_m(zone::Place here, const wire::Ranges& ranges) {
  const double front_m = 0.5 * zone_.vehicle.length_m;
  const double reach_m = model_.reach_m - front_m;
  double nearest_m = std::numeric_limits<double>::infinity();
  bool sampled = false;
  const double width_rad = 0.01 * ranges.beam_width_crad;
  for (std::size_t beam = 0; beam < ranges.range_mm.size(); ++beam) {
    if (ranges.range_mm[beam] == wire::no_echo) continue;
    const double range_m = 0.001 * ranges.range_mm[beam];
    if (range_m > reach_m) continue;
    if (!sampled) sample_way(here);
    sampled = true;
    const double bearing_rad = 0.01 * ranges.first_bearing_crad + width_rad * static_cast<double>(beam);
    for (const double side : {0.0, -1.0, 1.0}) {
      const auto [sin, cos] = sincos(bearing_rad + side * model_.beam_share * width_rad);
      const Point2 echo_B{front_m + range_m * cos, range_m * sin};
      const double along_m = nearest_on_way_m(echo_B);
      // Beside the body or behind its front is no obstacle ahead, but one that touches: still zero.
      nearest_m = std::min(nearest_m, std::max(0.0, along_m - front_m));
    }
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
