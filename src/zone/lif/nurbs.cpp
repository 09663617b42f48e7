#include "cosiva/zone/lif/nurbs.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "cosiva/base/expect.h"

namespace cosiva::zone::lif {
namespace {

/// A point and its weight: the curve is polynomial in these, and so is de Boor's triangle.
struct Homogeneous {
  double x;
  double y;
  double w;
};

struct Local {
  Point2 position;
  double dx;  ///< d position / du
  double dy;
};

/// De Boor's algorithm in the span [knots[span], knots[span + 1]).
Local de_boor(const Nurbs& curve, std::size_t span, double u) {
  const std::size_t p = curve.degree;
  std::array<Homogeneous, nurbs_degree_max + 1> d;
  for (std::size_t j = 0; j <= p; ++j) {
    const Point2 point = curve.points[span - p + j];
    const double w = curve.weights[span - p + j];
    d[j] = {point.x_m * w, point.y_m * w, w};
  }
  Homogeneous slope{};
  for (std::size_t round = 1; round <= p; ++round) {
    if (round == p) {
      const double width = curve.knots[span + 1] - curve.knots[span];
      const double k = static_cast<double>(p) / width;
      slope = {k * (d[p].x - d[p - 1].x), k * (d[p].y - d[p - 1].y), k * (d[p].w - d[p - 1].w)};
    }
    for (std::size_t j = p; j >= round; --j) {
      const double low = curve.knots[span - p + j];
      const double high = curve.knots[span + 1 + j - round];
      const double a = (u - low) / (high - low);
      const Homogeneous& before = d[j - 1];
      d[j] = {before.x + a * (d[j].x - before.x), before.y + a * (d[j].y - before.y),
              before.w + a * (d[j].w - before.w)};
    }
  }
  const Homogeneous& at = d[p];
  const Point2 position{at.x / at.w, at.y / at.w};
  return {position, (slope.x - slope.w * position.x_m) / at.w, (slope.y - slope.w * position.y_m) / at.w};
}

}  // namespace

Pose2 Nurbs::pose_at(double u) const {
  COSIVA_EXPECT(degree >= 1 && degree <= nurbs_degree_max && points.size() > degree &&
                weights.size() == points.size() && knots.size() == points.size() + degree + 1);
  const double here = u > from() ? std::min(u, to()) : from();
  // The span that holds `here` and is not empty; at the very end, the last such.
  const auto begin = knots.begin() + static_cast<std::ptrdiff_t>(degree);
  const auto end = knots.begin() + static_cast<std::ptrdiff_t>(points.size());
  auto after = std::upper_bound(begin, end, here);
  if (after == end)
    while (after != begin + 1 && !(*(after - 1) < *after)) --after;
  const auto span = static_cast<std::size_t>(after - knots.begin()) - 1;

  const Local local = de_boor(*this, span, here);
  double dx = local.dx;
  double dy = local.dy;
  // Where the derivative vanishes, the direction is the limit of those next to it, within the span.
  const double low = knots[span];
  const double high = knots[span + 1];
  double size_m = 0.0;
  for (std::size_t i = span - degree; i < span; ++i) size_m = std::max(size_m, distance(points[i], points[i + 1]));
  double step = 1e-7 * (high - low);
  while (norm(dx, dy) * (high - low) <= 1e-9 * size_m && step < 0.1 * (high - low)) {
    const Local neighbour = de_boor(*this, span, here + step < high ? here + step : here - step);
    dx = neighbour.dx;
    dy = neighbour.dy;
    step *= 10.0;
  }
  return {local.position.x_m, local.position.y_m, det_atan2(dy, dx)};
}

std::vector<Nurbs::Knot> Nurbs::inner_knots() const {
  std::vector<Knot> inner;
  for (std::size_t i = degree + 1; i < points.size();) {
    std::size_t same = i;
    while (same < points.size() && knots[same] == knots[i]) ++same;
    if (knots[i] > from() && knots[i] < to()) inner.push_back({knots[i], same - i >= degree});
    i = same;
  }
  return inner;
}

std::vector<double> clamped_uniform_knots(std::size_t points, std::size_t degree) {
  COSIVA_EXPECT(degree >= 1 && points > degree);
  std::vector<double> knots(points + degree + 1, 0.0);
  const std::size_t spans = points - degree;
  for (std::size_t i = 1; i < spans; ++i) knots[degree + i] = static_cast<double>(i) / static_cast<double>(spans);
  std::fill(knots.end() - static_cast<std::ptrdiff_t>(degree) - 1, knots.end(), 1.0);
  return knots;
}

}  // namespace cosiva::zone::lif
