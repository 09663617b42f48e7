#include "cosiva/aiv/perception/corridor.h"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

constexpr double rounding_m = 1e-9;

double squared_m2(Point2 a, Point2 b) {
  const double x_m = a.x_m - b.x_m;
  const double y_m = a.y_m - b.y_m;
  return x_m * x_m + y_m * y_m;
}

}  // namespace

Corridor::Corridor(const zone::TrafficZone& zone, Model model)
    : zone_{zone}, model_{model}, look_ahead_{zone.circuit, model.sample_m, model.reach_m} {
  COSIVA_EXPECT(model.margin_m >= 0.0);
  COSIVA_EXPECT(model.beam_ratio >= 0.0 && model.beam_ratio <= 0.5);
}

void Corridor::aim(const wire::Ranges& ranges) {
  const std::size_t count = ranges.range_mm.size();
  if (beams_.size() == count && ranges.first_bearing_crad == first_bearing_crad_ &&
      ranges.beam_width_crad == beam_width_crad_)
    return;
  first_bearing_crad_ = ranges.first_bearing_crad;
  beam_width_crad_ = ranges.beam_width_crad;
  beams_.clear();
  const double width_rad = 0.01 * beam_width_crad_;
  const double spread_rad = model_.beam_ratio * width_rad;
  for (std::size_t beam = 0; beam < count; ++beam) {
    const double bearing_rad = 0.01 * first_bearing_crad_ + width_rad * static_cast<double>(beam);
    beams_.push_back({sincos(bearing_rad), sincos(bearing_rad - spread_rad), sincos(bearing_rad + spread_rad)});
  }
}

double Corridor::echo_forward_m(double range_m, const Beam& beam, double spread_rad) const {
  const double front_m = 0.5 * zone_.vehicle.length_m;
  const double half_m = 0.5 * zone_.vehicle.width_m + model_.margin_m;
  // A point next to the path is at most half a step from a sample's normal.
  const double near_m = norm(half_m, 0.5 * model_.sample_m);
  std::array<Point2, std::tuple_size_v<Beam>> echo_B;
  for (std::size_t side = 0; side < beam.size(); ++side)
    echo_B[side] = {front_m + range_m * beam[side].cos, range_m * beam[side].sin};
  // Most echoes come from other lanes: what is this far from the centre of the beam is off its sides, too.
  const double spread_m = near_m + spread_rad * range_m + rounding_m;
  constexpr PathLookAhead::Offset nowhere{0, std::numeric_limits<double>::infinity()};
  std::array<PathLookAhead::Offset, std::tuple_size_v<Beam>> nearest{nowhere, nowhere, nowhere};
  look_ahead_.visit_near(echo_B.front(), spread_m, [&](std::size_t sample, Point2 sample_B) {
    if (squared_m2(sample_B, echo_B.front()) > spread_m * spread_m) return;
    for (std::size_t side = 0; side < beam.size(); ++side)
      if (const double d2_m2 = squared_m2(sample_B, echo_B[side]); d2_m2 < nearest[side].distance2_m2)
        nearest[side] = {sample, d2_m2};
  });
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t side = 0; side < beam.size(); ++side)
    if (nearest[side].distance2_m2 < near_m * near_m)
      nearest_m = std::min(nearest_m, look_ahead_.along_path_m(echo_B[side], nearest[side].sample) - front_m);
  // An echo next to the body or behind its front is not an obstacle ahead but a contact.
  return std::max(0.0, nearest_m);
}

Corridor::Scan Corridor::scan(const Outlook& outlook, const wire::Ranges& ranges) {
  aim(ranges);
  COSIVA_EXPECT(beams_.size() == ranges.range_mm.size());
  const double width_rad = 0.01 * ranges.beam_width_crad;
  Scan nearest;
  bool sampled = false;
  for (std::size_t beam = 0; beam < ranges.range_mm.size(); ++beam) {
    if (ranges.range_mm[beam] == wire::no_echo) continue;
    const double range_m = 0.001 * ranges.range_mm[beam];
    if (range_m > reach_m()) continue;
    if (!sampled) look_ahead_.sample(outlook);
    sampled = true;
    const double ahead_m = echo_forward_m(range_m, beams_[beam], model_.beam_ratio * width_rad);
    if (ahead_m < nearest.ahead_m) nearest = {ahead_m, beam};
  }
  return nearest;
}

Point2 Corridor::echo(const wire::Ranges& ranges, std::size_t beam) const {
  const double range_m = 0.001 * ranges.range_mm[beam];
  const auto [sin, cos] =
      sincos(0.01 * ranges.first_bearing_crad + 0.01 * ranges.beam_width_crad * static_cast<double>(beam));
  return {0.5 * zone_.vehicle.length_m + range_m * cos, range_m * sin};
}

double Corridor::nearest_m(const wire::Ranges& ranges) const {
  double nearest_m = std::numeric_limits<double>::infinity();
  for (std::size_t beam = 0; beam < ranges.range_mm.size(); ++beam) {
    if (ranges.range_mm[beam] == wire::no_echo) continue;
    // The body origin is further away than the sensor at the front, for any beam ahead.
    if (0.001 * ranges.range_mm[beam] > nearest_m) continue;
    const Point2 echo_B = echo(ranges, beam);
    nearest_m = std::min(nearest_m, norm(echo_B.x_m, echo_B.y_m));
  }
  return nearest_m;
}

void ObstacleFilter::add(double obstacle_ahead_m, double travelled_m) {
  detected_m_[next_] = obstacle_ahead_m + travelled_m;
  next_ = (next_ + 1) % detected_m_.size();
  const auto& [a, b, c] = detected_m_;
  median_m_ = std::max(std::min(a, b), std::min(std::max(a, b), c));
  COSIVA_EXPECT(std::ranges::count_if(detected_m_, [this](double frame_m) { return frame_m <= median_m_; }) >= 2);
  COSIVA_EXPECT(std::ranges::count_if(detected_m_, [this](double frame_m) { return frame_m >= median_m_; }) >= 2);
}

void ObstacleFilter::archive(Archive& archive) { archive(detected_m_, next_, median_m_); }

}  // namespace cosiva::aiv
