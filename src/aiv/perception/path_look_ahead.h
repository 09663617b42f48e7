#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/base/math.h"
#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::aiv {

/// The path ahead of the vehicle as evenly spaced points in its body frame, and the position of other points relative
/// to this path. Detected obstacles (Corridor) and bodies known from messages (PerceivedWorld) are evaluated by the
/// same path. A body off the path drives straight to where it joins the path. Most points of the path are never
/// compared with anything, so each is computed when it is first needed. Invariant: 0 < step < reach.
class PathLookAhead {
 public:
  /// @param sample_m  between two points of the path
  /// @param reach_m   of the body origin, ahead
  PathLookAhead(const zone::Circuit& circuit, double sample_m, double reach_m);

  void sample(const Outlook& outlook);
  /// Of the path sampled last: less than the reach where the circuit ends.
  [[nodiscard]] double length_m() const {
    return samples_.empty() ? 0.0 : static_cast<double>(samples_.size() - 1) * sample_m_;
  }
  [[nodiscard]] double sample_m() const { return sample_m_; }

  /// The point of the path nearest to another point.
  struct Offset {
    std::size_t sample;
    double distance2_m2;
  };
  /// @param within_m  of interest: beyond it the distance may be given as infinite, which is found out sooner
  [[nodiscard]] Offset off_path(Point2 p_B, double within_m = std::numeric_limits<double>::infinity()) const;
  /// Calls `visit(sample, point)` for the points of the path that can be within this distance of p, in order, and for
  /// some others.
  template <typename Visit>
  void visit_near(Point2 p_B, double within_m, Visit visit) const {
    if (coarse_distance_m(p_B, within_m) - skipped_m() <= within_m) visit_blocks(within_m, visit);
  }
  /// From the body origin along the path to the point next to p, near the sample; negative behind the body origin.
  [[nodiscard]] double along_path_m(Point2 p_B, std::size_t sample) const;

 private:
  struct Sample {
    zone::TrackPosition position;
    Point2 p_B;
    bool computed;
  };
  [[nodiscard]] Point2 in_body(Point2 p_M) const;
  /// Computes the sample at its first use.
  [[nodiscard]] Point2 at(std::size_t sample) const {
    if (!samples_[sample].computed) compute(sample);
    return samples_[sample].p_B;
  }
  void compute(std::size_t sample) const;
  /// Computes every coarse sample, and the box around them.
  void begin();
  /// Adjacent points are no further apart than a step (and a little, where the path begins or two sections meet), so
  /// every fourth point bounds the distance of the three after it.
  static constexpr std::size_t stride = 4;
  /// The squared distances of all coarse samples from a point, to coarse_m2_, and the least distance: no sample is
  /// nearer than that by more than `skipped_m()`. Infinite, without coarse_m2_, for a point that lies further than
  /// `within_m` from the box around the samples.
  [[nodiscard]] double coarse_distance_m(Point2 p_B, double within_m) const;
  [[nodiscard]] double skipped_m() const { return 1.25 * static_cast<double>(stride - 1) * sample_m_; }
  /// Visits the samples of each block of `stride` samples that coarse_m2_ permits to be within this distance.
  template <typename Visit>
  void visit_blocks(double within_m, Visit visit) const;

  const zone::Circuit& circuit_;
  double sample_m_;
  double reach_m_;
  Pose2 X_MB_{};
  SinCos turn_{0.0, 1.0};                  ///< of the body's heading
  mutable std::vector<Sample> samples_;    ///< reused to spare allocations
  mutable std::vector<double> coarse_m2_;  ///< likewise: one for every fourth sample
  Point2 low_B_{};                         ///< the box around the coarse samples
  Point2 high_B_{};
};

template <typename Visit>
void PathLookAhead::visit_blocks(double within_m, Visit visit) const {
  // Between two coarse points the path is at most `stride` steps long, so that no point of it is nearer than half of
  // their two distances less half of that length. After the last one there is only its own distance.
  const double half_block_m = 0.5 * 1.25 * static_cast<double>(stride) * sample_m_;
  const double far_m2 = (within_m + half_block_m) * (within_m + half_block_m);
  for (std::size_t k = 0; k < coarse_m2_.size(); ++k) {
    if (k + 1 == coarse_m2_.size()) {
      if (std::sqrt(coarse_m2_[k]) - skipped_m() > within_m) continue;
    } else {
      // Most often both distances are too large, which needs no square root.
      if (coarse_m2_[k] > far_m2 && coarse_m2_[k + 1] > far_m2) continue;
      if (0.5 * (std::sqrt(coarse_m2_[k]) + std::sqrt(coarse_m2_[k + 1])) - half_block_m > within_m) continue;
    }
    const std::size_t end = std::min(stride * (k + 1), samples_.size());
    for (std::size_t i = stride * k; i < end; ++i) visit(i, at(i));
  }
}

}  // namespace cosiva::aiv
