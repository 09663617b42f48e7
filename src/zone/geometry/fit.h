#pragma once

#include <cstddef>
#include <functional>
#include <string>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/zone/geometry/section.h"

namespace cosiva::zone {

struct FitTolerance {
  double position_m{1e-3};
  double heading_rad{1e-3};
};

/// A plane curve: position and heading at parameter u. The heading need not be wrapped.
struct PlaneCurve {
  std::function<Pose2(double u)> at;
  double from{};
  double to{};                 ///< > from
  std::vector<double> breaks;  ///< between from and to, ascending: where its shape changes, and where it may kink
};

/// Sections of linear curvature, joined end to end exactly, that follow a curve. An offset to the outer side of a bend
/// makes them longer than the curve: by up to worst_position_m for each radian.
struct Fit {
  std::vector<Section> sections;
  double length_m{};
  double worst_position_m{};   ///< from the curve to the sections
  double worst_heading_rad{};  ///< likewise; over the curve's own kinks too, where it cannot be within the tolerance
};

/// Each piece is the clothoid that meets the curve's pose at both of its ends (G¹ Hermite); a piece that deviates
/// further than the tolerance is cut in two. A straight line, or an arc, up to a hundredth of the tolerance, its end
/// included, is returned as such. Where the curve itself kinks, by at most 0.2 rad, or jumps by no more than the
/// position tolerance at one of its breaks, the kink or jump is rounded within the position tolerance. Pieces join
/// exactly (1e-9). Fails ("fit.curve") where the curve is not finite, has a sharp corner, a cusp or a jump, or takes
/// more than `pieces_max` pieces.
[[nodiscard]] Result<Fit> fit(const PlaneCurve& curve, FitTolerance tolerance = {}, std::size_t pieces_max = 100'000);

}  // namespace cosiva::zone
