#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::aiv {

/// The path ahead of the vehicle as evenly spaced points in its body frame, and the position of other points relative
/// to this path. Detected obstacles (Corridor) and bodies known from messages (PerceivedWorld) are evaluated by the
/// same path. A body off the path drives straight to where it joins the path. Invariant: 0 < step < reach.
class PathLookAhead {
 public:
  /// @param sample_m  between two points of the path
  /// @param reach_m   of the body origin, ahead
  PathLookAhead(const zone::Circuit& circuit, double sample_m, double reach_m);

  void sample(const Outlook& outlook);
  /// Of the path sampled last: less than the reach where the circuit ends.
  [[nodiscard]] double length_m() const {
    return samples_B_.empty() ? 0.0 : static_cast<double>(samples_B_.size() - 1) * sample_m_;
  }
  [[nodiscard]] double sample_m() const { return sample_m_; }

  /// The point of the path nearest to another point.
  struct Offset {
    std::size_t sample;
    double distance2_m2;
  };
  [[nodiscard]] Offset off_path(Point2 p_B) const;
  /// From the body origin along the path to the point next to p, near the sample; negative behind the body origin.
  [[nodiscard]] double along_path_m(Point2 p_B, std::size_t sample) const;

 private:
  const zone::Circuit& circuit_;
  double sample_m_;
  double reach_m_;
  std::vector<Point2> samples_B_;  ///< reused to spare allocations
};

}  // namespace cosiva::aiv
