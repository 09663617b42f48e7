#include "cosiva/aiv/perception/path_look_ahead.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"

namespace cosiva::aiv {

PathLookAhead::PathLookAhead(const zone::Circuit& circuit, double sample_m, double reach_m)
    : circuit_{circuit}, sample_m_{sample_m}, reach_m_{reach_m} {
  COSIVA_EXPECT(sample_m > 0.0 && reach_m > sample_m);
  samples_B_.reserve(static_cast<std::size_t>(reach_m / sample_m) + 2);
}

void PathLookAhead::sample(const Outlook& outlook) {
  const Pose2 X_ML = circuit_.pose_at(outlook.here);
  const Pose2 X_MB = outlook.X_MB.value_or(X_ML);
  const SinCos turn = sincos(X_MB.heading_rad);
  const auto add = [&](Point2 p_M) {
    const double x_m = p_M.x_m - X_MB.x_m;
    const double y_m = p_M.y_m - X_MB.y_m;
    samples_B_.push_back({turn.cos * x_m + turn.sin * y_m, turn.cos * y_m - turn.sin * x_m});
  };
  samples_B_.clear();
  double ahead_m = 0.0;
  double s_m = outlook.here.s_m;
  if (const double to_line_m = outlook.X_MB ? distance(X_MB, X_ML) : 0.0; to_line_m > 0.0) {
    for (; ahead_m < std::min(to_line_m, reach_m_); ahead_m += sample_m_) {
      const double part = ahead_m / to_line_m;
      add({X_MB.x_m + part * (X_ML.x_m - X_MB.x_m), X_MB.y_m + part * (X_ML.y_m - X_MB.y_m)});
    }
    s_m += ahead_m - to_line_m;
  }
  zone::SectionLookAhead ahead = section_look_ahead(circuit_, outlook);
  for (; ahead_m <= reach_m_; ahead_m += sample_m_, s_m += sample_m_) {
    while (s_m > circuit_.section(ahead.section()).length_m()) {
      const double length_m = circuit_.section(ahead.section()).length_m();
      if (!ahead.step()) return;
      s_m -= length_m;
    }
    add(position(circuit_.section(ahead.section()).pose_at(s_m)));
  }
}

PathLookAhead::Offset PathLookAhead::off_path(Point2 p_B) const {
  // Every fourth point first: adjacent points are no further apart than a step (and a little, where the path begins or
  // two sections meet), so the nearest point lies around one of the coarse points that are nearly as near.
  constexpr std::size_t stride = 4;
  const auto distance2 = [&](std::size_t i) {
    const double x_m = samples_B_[i].x_m - p_B.x_m;
    const double y_m = samples_B_[i].y_m - p_B.y_m;
    return x_m * x_m + y_m * y_m;
  };
  double coarse2_m2 = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < samples_B_.size(); i += stride) coarse2_m2 = std::min(coarse2_m2, distance2(i));
  const double near_m = std::sqrt(coarse2_m2) + 1.25 * static_cast<double>(stride - 1) * sample_m_;
  Offset nearest{0, std::numeric_limits<double>::infinity()};
  for (std::size_t first = 0; first < samples_B_.size(); first += stride) {
    if (distance2(first) > near_m * near_m) continue;
    for (std::size_t i = first; i < std::min(first + stride, samples_B_.size()); ++i) {
      if (const double d2_m2 = distance2(i); d2_m2 < nearest.distance2_m2) nearest = {i, d2_m2};
    }
  }
  return nearest;
}

double PathLookAhead::along_path_m(Point2 p_B, std::size_t sample) const {
  // Between the samples: along the chord of its neighbours.
  const Point2 before = samples_B_[sample == 0 ? 0 : sample - 1];
  const Point2 after = samples_B_[std::min(sample + 1, samples_B_.size() - 1)];
  const double chord_m = distance(before, after);
  const double along_m = static_cast<double>(sample) * sample_m_;
  if (chord_m <= 0.0) return along_m;
  const Point2 here = samples_B_[sample];
  return along_m +
         ((p_B.x_m - here.x_m) * (after.x_m - before.x_m) + (p_B.y_m - here.y_m) * (after.y_m - before.y_m)) / chord_m;
}

}  // namespace cosiva::aiv
