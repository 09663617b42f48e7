#pragma once

#include <cstddef>
#include <vector>

#include "cosiva/base/pose.h"

namespace cosiva::zone::lif {

inline constexpr std::size_t nurbs_degree_max = 25;

/// A non-uniform rational B-spline in the plane, C(u) = Σ wᵢ Pᵢ Nᵢ(u) / Σ wᵢ Nᵢ(u).
struct Nurbs {
  std::size_t degree{1};          ///< 1 to nurbs_degree_max, less than there are points
  std::vector<double> knots{};    ///< ascending, points.size() + degree + 1 of them
  std::vector<Point2> points{};   ///< at least 2
  std::vector<double> weights{};  ///< positive, as many as points

  /// The knots between which the curve is defined.
  [[nodiscard]] double from() const { return knots[degree]; }
  [[nodiscard]] double to() const { return knots[points.size()]; }

  /// Position and direction (of growing u) at u in [from(), to()] (clamped); where the derivative vanishes, as at
  /// doubled end points, the direction is that of the continuation. At a corner it is that of the continuation.
  [[nodiscard]] Pose2 pose_at(double u) const;

  /// Where neighbouring spans meet, ascending, and whether the direction may jump there.
  struct Knot {
    double u;
    bool corner;
  };
  [[nodiscard]] std::vector<Knot> inner_knots() const;
};

/// Knots that begin and end on the first and last point, evenly spaced in [0, 1].
[[nodiscard]] std::vector<double> clamped_uniform_knots(std::size_t points, std::size_t degree);

}  // namespace cosiva::zone::lif
