#include "cosiva/aiv/estimation/next_position.h"

#include <optional>

#include "cosiva/base/expect.h"

namespace cosiva::estimation {
namespace {

/// Largest error along the track, and across it, of an estimate that states no arc length.
constexpr double reach_m = 0.5;
constexpr double across_m_max = 0.3;

}  // namespace

Pose2 next_position(const Estimate& estimate, const Track* track, double near_m, double move_m) {
  COSIVA_EXPECT(move_m >= 0.0);
  const Pose2& X_MB = estimate.pose;
  std::optional<double> along_m = estimate.along_m;
  if (track != nullptr && !along_m) along_m = track->foot(position(X_MB), near_m, reach_m, across_m_max);
  if (track == nullptr || !along_m) return X_MB * Pose2{move_m, 0.0, 0.0};
  return track->pose_at(*along_m + move_m) * (inverse(track->pose_at(*along_m)) * X_MB);
}

}  // namespace cosiva::estimation
