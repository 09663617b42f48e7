#pragma once

#include <cstddef>
#include <limits>
#include <vector>

#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::aiv {

/// The way before the vehicle as evenly spaced points in its body frame, and where other points lie beside it. What it
/// sees (Corridor) and what it is told (PerceivedWorld) are judged by the same way. A body off the line goes straight
/// to where it comes onto it.
class PathLookAhead {
 public:
  /// @param sample_m  between two points of the way
  /// @param reach_m   of the vehicle's middle, ahead
  PathLookAhead(const zone::Circuit& circuit, double sample_m, double reach_m);

  void sample(const Outlook& outlook);
  /// Of the way sampled last: less than the reach where the circuit ends.
  [[nodiscard]] double length_m() const {
    return samples_B_.empty() ? 0.0 : static_cast<double>(samples_B_.size() - 1) * sample_m_;
  }
  [[nodiscard]] double sample_m() const { return sample_m_; }

  /// The point of the way nearest to another point.
  struct Offset {
    std::size_t sample;
    double distance2_m2;
  };
  [[nodiscard]] Offset off_path(Point2 p_B) const;
  /// From the vehicle's middle along the way to the place beside p, near the sample; negative behind the middle.
  [[nodiscard]] double along_path_m(Point2 p_B, std::size_t sample) const;

 private:
  const zone::Circuit& circuit_;
  double sample_m_;
  double reach_m_;
  std::vector<Point2> samples_B_;  ///< kept to spare allocations
};

}  // namespace cosiva::aiv
