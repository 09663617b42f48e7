#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::aiv::test {

/// The readings of a fan of 13 beams, 0.14 rad apart, 0.1 m before the body origin of a vehicle stopped at `X_MB`, of
/// point obstacles given in the zone's frame [m]. The beams reach 2 m, and obstacles do not hide each other.
inline wire::Ranges ranges_to(const std::vector<Point2>& obstacles_M, const Pose2& X_MB) {
  wire::Ranges ranges{0, -84, 14, std::vector<std::uint16_t>(13, wire::no_echo)};
  const Pose2 X_BM = inverse(X_MB);
  for (const Point2& p_M : obstacles_M) {
    const Point2 p_B = X_BM * p_M;
    const double range_m = std::hypot(p_B.x_m - 0.1, p_B.y_m);
    const long beam = std::lround((std::atan2(p_B.y_m, p_B.x_m - 0.1) + 0.84) / 0.14);
    if (beam < 0 || beam > 12 || range_m > 2.0) continue;
    auto& detected = ranges.range_mm[static_cast<std::size_t>(beam)];
    detected = std::min(detected, static_cast<std::uint16_t>(std::lround(range_m * 1e3)));
  }
  return ranges;
}

}  // namespace cosiva::aiv::test
