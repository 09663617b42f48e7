#include "cosiva/aiv/perception/path_look_ahead.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"

namespace cosiva::aiv {
PathLookAhead::PathLookAhead(const zone::Circuit& circuit, double sample_m, double reach_m)
    : circuit_{circuit}, sample_m_{sample_m}, reach_m_{reach_m} {
  COSIVA_EXPECT(sample_m > 0.0 && reach_m > sample_m);
  samples_.reserve(static_cast<std::size_t>(reach_m / sample_m) + 2);
}

Point2 PathLookAhead::in_body(Point2 p_M) const {
  const double x_m = p_M.x_m - X_MB_.x_m;
  const double y_m = p_M.y_m - X_MB_.y_m;
  return {turn_.cos * x_m + turn_.sin * y_m, turn_.cos * y_m - turn_.sin * x_m};
}

void PathLookAhead::compute(std::size_t sample) const {
  Sample& here = samples_[sample];
  here.p_B = in_body(circuit_.section(here.position.section).point_at(here.position.s_m));
  here.computed = true;
}

void PathLookAhead::sample(const Outlook& outlook) {
  const Pose2 X_ML = circuit_.pose_at(outlook.here);
  X_MB_ = outlook.X_MB.value_or(X_ML);
  turn_ = sincos(X_MB_.heading_rad);
  samples_.clear();
  double ahead_m = 0.0;
  double s_m = outlook.here.s_m;
  if (const double to_line_m = outlook.X_MB ? distance(X_MB_, X_ML) : 0.0; to_line_m > 0.0) {
    for (; ahead_m < std::min(to_line_m, reach_m_); ahead_m += sample_m_) {
      const double part = ahead_m / to_line_m;
      const Point2 p_M{X_MB_.x_m + part * (X_ML.x_m - X_MB_.x_m), X_MB_.y_m + part * (X_ML.y_m - X_MB_.y_m)};
      samples_.push_back({outlook.here, in_body(p_M), true});
    }
    s_m += ahead_m - to_line_m;
  }
  zone::SectionLookAhead ahead = section_look_ahead(circuit_, outlook);
  double length_m = circuit_.section(ahead.section()).length_m();
  for (; ahead_m <= reach_m_; ahead_m += sample_m_, s_m += sample_m_) {
    while (s_m > length_m) {
      if (!ahead.step()) return begin();
      s_m -= length_m;
      length_m = circuit_.section(ahead.section()).length_m();
    }
    samples_.push_back({{ahead.section(), s_m}, {}, false});
  }
  begin();
}

void PathLookAhead::begin() {
  constexpr double infinite_m = std::numeric_limits<double>::infinity();
  Point2 low_B{infinite_m, infinite_m};
  Point2 high_B{-infinite_m, -infinite_m};
  for (std::size_t i = 0; i < samples_.size(); i += stride) {
    const Point2 p_B = at(i);
    low_B = {std::min(low_B.x_m, p_B.x_m), std::min(low_B.y_m, p_B.y_m)};
    high_B = {std::max(high_B.x_m, p_B.x_m), std::max(high_B.y_m, p_B.y_m)};
  }
  coarse_m2_.resize((samples_.size() + stride - 1) / stride);
  low_B_ = low_B;
  high_B_ = high_B;
}

double PathLookAhead::coarse_distance_m(Point2 p_B, double within_m) const {
  constexpr double infinite_m = std::numeric_limits<double>::infinity();
  // Most points are echoes of another lane, beyond the box around the path.
  const double box_m = within_m + skipped_m();
  if (samples_.empty() || p_B.x_m < low_B_.x_m - box_m || p_B.x_m > high_B_.x_m + box_m ||
      p_B.y_m < low_B_.y_m - box_m || p_B.y_m > high_B_.y_m + box_m)
    return infinite_m;
  double least_m2 = infinite_m;
  const Sample* coarse = samples_.data();
  for (std::size_t k = 0; k < coarse_m2_.size(); ++k, coarse += stride) {
    const double x_m = coarse->p_B.x_m - p_B.x_m;
    const double y_m = coarse->p_B.y_m - p_B.y_m;
    coarse_m2_[k] = x_m * x_m + y_m * y_m;
    least_m2 = std::min(least_m2, coarse_m2_[k]);
  }
  return std::sqrt(least_m2);
}

PathLookAhead::Offset PathLookAhead::off_path(Point2 p_B, double within_m) const {
  Offset nearest{0, std::numeric_limits<double>::infinity()};
  const double coarse_m = coarse_distance_m(p_B, within_m);
  if (coarse_m - skipped_m() > within_m) return nearest;
  visit_blocks(std::min(coarse_m, within_m), [&](std::size_t i, Point2 sample_B) {
    const double x_m = sample_B.x_m - p_B.x_m;
    const double y_m = sample_B.y_m - p_B.y_m;
    if (const double d2_m2 = x_m * x_m + y_m * y_m; d2_m2 < nearest.distance2_m2) nearest = {i, d2_m2};
  });
  return nearest;
}

double PathLookAhead::along_path_m(Point2 p_B, std::size_t sample) const {
  // Between the samples: along the chord of its neighbours.
  const Point2 before = at(sample == 0 ? 0 : sample - 1);
  const Point2 after = at(std::min(sample + 1, samples_.size() - 1));
  const double chord_m = distance(before, after);
  const double along_m = static_cast<double>(sample) * sample_m_;
  if (chord_m <= 0.0) return along_m;
  const Point2 here = at(sample);
  return along_m +
         ((p_B.x_m - here.x_m) * (after.x_m - before.x_m) + (p_B.y_m - here.y_m) * (after.y_m - before.y_m)) / chord_m;
}

}  // namespace cosiva::aiv
