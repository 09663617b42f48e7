#pragma once

#include <optional>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/zone/opendrive/model.h"

namespace cosiva::zone::opendrive {

/// A point of a curve with its first and second derivative by the road's s.
struct Jet {
  Point2 p;
  Point2 d;
  Point2 dd;

  [[nodiscard]] double heading_rad() const { return det_atan2(d.y_m, d.x_m); }
};

/// Cubics by their arc length.
class CubicPath {
 public:
  /// Fails (nothing) where its derivative vanishes everywhere or is not finite.
  [[nodiscard]] static std::optional<CubicPath> make(const Pose2& start, const Cubics& cubics, double length);

  [[nodiscard]] double length() const { return arc_.back(); }
  [[nodiscard]] Jet at(double arc) const;  ///< derivatives by arc length

 private:
  [[nodiscard]] double speed(double p) const;
  [[nodiscard]] double arc_between(double from, double to) const;

  Pose2 start_;
  Cubics cubics_;
  double cell_{};            ///< width of a cell of p
  std::vector<double> arc_;  ///< at each cell's edge
};

}  // namespace cosiva::zone::opendrive
