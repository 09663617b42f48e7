#include "cosiva/aiv/perception/sighting.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// Neighbouring beams detect the same body when their ranges differ from the nearest one's by no more than this. Two
/// adjacent bodies that are taken for one would have a centre where there is none of them.
constexpr int same_body_mm = 50;
constexpr double radius_m_min = 0.02;
constexpr double radius_m_max = 0.15;

bool same_body(std::uint16_t a_mm, std::uint16_t b_mm) {
  return a_mm != wire::no_echo && b_mm != wire::no_echo && std::abs(int{a_mm} - int{b_mm}) <= same_body_mm;
}

}  // namespace

wire::DetectedObstacleReport::Obstacle body_in_beams(const Corridor::Scan& scan, const wire::Ranges& ranges,
                                                     const Pose2& X_MS) {
  const auto& range_mm = ranges.range_mm;
  std::size_t first = scan.beam;
  std::size_t last = scan.beam;
  const std::uint16_t nearest_mm = range_mm[scan.beam];
  while (first > 0 && same_body(range_mm[first - 1], nearest_mm)) --first;
  while (last + 1 < range_mm.size() && same_body(range_mm[last + 1], nearest_mm)) ++last;
  double range_m = 0.001 * nearest_mm;
  for (std::size_t i = first; i <= last; ++i) range_m = std::min(range_m, 0.001 * range_mm[i]);

  const double width_rad = 0.01 * ranges.beam_width_crad;
  const double bearing_rad = 0.01 * ranges.first_bearing_crad + 0.5 * width_rad * static_cast<double>(first + last);
  // A disc of radius r, its centre R = range + r away, spans 2·asin(r/R); of the beams that the disc touches, the two
  // outer ones are half filled on average.
  const double half_rad = std::min(0.5 * width_rad * static_cast<double>(last - first), 0.25 * pi);
  const double ratio = det_sin(half_rad);
  const double radius_m = std::clamp(range_m * ratio / (1.0 - ratio), radius_m_min, radius_m_max);
  const auto [sin, cos] = sincos(bearing_rad);
  const double away_m = range_m + radius_m;
  const Point2 centre_M = X_MS * Point2{away_m * cos, away_m * sin};
  return {centre_M.x_m, centre_M.y_m, radius_m, scan.ahead_m};
}

std::optional<wire::DetectedObstacleReport> Sighting::on_frame(SimTime now, const Corridor::Scan& scan,
                                                               const wire::Ranges& ranges, const Pose2& X_MS,
                                                               double reach_m) {
  COSIVA_EXPECT(!there_ || (misses_ < misses_max && farewells_left_ == farewells));
  wire::DetectedObstacleReport detected;
  detected.clear_m = std::min(scan.ahead_m, reach_m);
  if (scan.ahead_m <= reported_m_max) {
    const bool fresh = !there_;
    there_ = true;
    misses_ = 0;
    farewells_left_ = farewells;
    if (!fresh && !due(now)) return std::nullopt;
    detected.obstacle = body_in_beams(scan, ranges, X_MS);
  } else {
    if (there_ && ++misses_ < misses_max) return std::nullopt;
    const bool fresh = there_;
    there_ = false;
    if (farewells_left_ == 0 || (!fresh && !due(now))) return std::nullopt;
    --farewells_left_;
  }
  reported_at_ = now;
  return detected;
}

void Sighting::fold(Digest& digest) const {
  digest.add(std::uint64_t{there_});
  digest.add(std::int64_t{misses_});
  digest.add(std::int64_t{farewells_left_});
}

void Sighting::archive(Archive& archive) { archive(there_, misses_, farewells_left_, reported_at_); }

}  // namespace cosiva::aiv
