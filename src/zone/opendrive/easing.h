#pragma once

#include <algorithm>
#include <cmath>

namespace cosiva::zone::opendrive {

/// A correction that is full at one end of a stretch and zero `over` metres away: Hermite's quintic, so that it adds no
/// curvature at either end. x is the distance from the end with the full correction, and slopes are by x.
struct Easing {
  double shift{};
  double slope{};
  double over{1.0};

  [[nodiscard]] double at(double x) const {
    const double t = x / over;
    if (t >= 1.0) return 0.0;
    const double u = 1.0 - t;
    return u * u * u * (shift * (1.0 + t * (3.0 + 6.0 * t)) + slope * over * t * (1.0 + 3.0 * t));
  }
  [[nodiscard]] double slope_at(double x) const {
    const double t = x / over;
    if (t >= 1.0) return 0.0;
    const double u = 1.0 - t;
    return u * u * (-30.0 * shift / over * t * t + slope * (1.0 + t * (2.0 - 15.0 * t)));
  }
  [[nodiscard]] double bend_at(double x) const {
    const double t = x / over;
    if (t >= 1.0) return 0.0;
    const double u = 1.0 - t;
    return u * t * (-60.0 * shift / over * (1.0 - 2.0 * t) - slope * (36.0 - 60.0 * t)) / over;
  }
};

/// The reach of a correction by `shift` metres and `slope` radians, in metres of the file, if there is room: so far
/// that a small shift changes the heading by at most a milliradian, and that a slope moves the line by at most half a
/// millimetre; both limits are relaxed where that would be too far, or too sharp for a road.
[[nodiscard]] inline double easing_reach(double shift, double slope) {
  shift = std::fabs(shift);
  slope = std::fabs(slope);
  const double for_shift = std::min(1500.0 * shift, std::max(2.0, 30.0 * shift));
  const double for_slope = std::max(std::min(2.5e-3 / std::max(slope, 1e-9), 5.0), 160.0 * slope);
  // A corner is cut by less than a metre, however far a gentler turn would reach.
  const double for_corner = 4.0 / std::max(slope, 1e-9);
  return std::max(for_shift, std::min(for_slope, for_corner));
}

/// The greatest gap and kink at joints of records and of lanes: a larger one is not bent to meet. Roads drawn as
/// polygons have corners of a right angle; linked lanes continue nearly straight.
inline constexpr double gap_max_m = 2.0;
inline constexpr double corner_max_rad = 1.6;
inline constexpr double kink_max_rad = 0.8;

}  // namespace cosiva::zone::opendrive
