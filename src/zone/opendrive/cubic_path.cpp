#include "cosiva/zone/opendrive/cubic_path.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::opendrive {
namespace {

constexpr std::size_t cells = 32;

/// The cell in which a table of arc lengths over equal cells of p reaches `arc`.
std::size_t cell_at(const std::vector<double>& table, double arc) {
  const auto above = std::upper_bound(table.begin() + 1, table.end() - 1, arc);
  return static_cast<std::size_t>(above - table.begin()) - 1;
}

}  // namespace

double CubicPath::speed(double p) const { return norm(cubics_.u.slope_at(p), cubics_.v.slope_at(p)); }

/// Gauss-Legendre with eight points: on a 32nd of a cubic that a road follows, exact to the last digits.
double CubicPath::arc_between(double from, double to) const {
  constexpr double nodes[] = {0.1834346424956498, 0.5255324099163290, 0.7966664774136267, 0.9602898564975363};
  constexpr double weights[] = {0.3626837833783620, 0.3137066458778873, 0.2223810344533745, 0.1012285362903763};
  const double centre = 0.5 * (from + to);
  const double half = 0.5 * (to - from);
  double sum = 0.0;
  for (std::size_t i = 0; i < 4; ++i)
    sum += weights[i] * (speed(centre - half * nodes[i]) + speed(centre + half * nodes[i]));
  return half * sum;
}

std::optional<CubicPath> CubicPath::make(const Pose2& start, const Cubics& cubics, double length) {
  CubicPath path;
  path.start_ = start;
  path.cubics_ = cubics;
  const auto lay = [&](double p_end) {
    path.cell_ = p_end / static_cast<double>(cells);
    path.arc_.assign(1, 0.0);
    for (std::size_t i = 0; i < cells; ++i) {
      const double from = static_cast<double>(i) * path.cell_;
      path.arc_.push_back(path.arc_.back() + path.arc_between(from, from + path.cell_));
    }
  };
  lay(cubics.range == Cubics::Range::normalized ? 1.0 : length);
  if (cubics.range == Cubics::Range::along_u && path.length() > length) {
    // Along u the curve is at least as long as u, so its end is where it has become as long as it should.
    double low = 0.0;
    double high = length;
    for (int round = 0; round < 60; ++round) {
      const double centre = 0.5 * (low + high);
      lay(centre);
      (path.length() < length ? low : high) = centre;
    }
  }
  if (!std::isfinite(path.length()) || path.length() < 1e-6 || path.length() > 1e5) return std::nullopt;
  return path;
}

Jet CubicPath::at(double arc) const {
  arc = std::clamp(arc, 0.0, length());
  const std::size_t cell = cell_at(arc_, arc);
  const double edge = static_cast<double>(cell) * cell_;
  const double within = arc_[cell + 1] - arc_[cell];
  double p = within > 0.0 ? edge + cell_ * (arc - arc_[cell]) / within : edge;
  for (int round = 0; round < 8; ++round) {
    const double v = speed(p);
    if (v < 1e-12) break;
    const double step = (arc_[cell] + arc_between(edge, p) - arc) / v;
    p = std::clamp(p - step, edge, edge + cell_);
    if (std::fabs(step) < 1e-15 * (1.0 + std::fabs(p))) break;
  }

  const double v = speed(p);
  const double du = cubics_.u.slope_at(p);
  const double dv = cubics_.v.slope_at(p);
  const SinCos turn = sincos(start_.heading_rad);
  const Point2 along = v > 1e-12 ? Point2{du / v, dv / v} : Point2{1.0, 0.0};
  const double bend = v > 1e-12 ? (du * cubics_.v.bend_at(p) - dv * cubics_.u.bend_at(p)) / (v * v * v) : 0.0;
  const Point2 tangent{turn.cos * along.x_m - turn.sin * along.y_m, turn.sin * along.x_m + turn.cos * along.y_m};
  return {start_ * Point2{cubics_.u.at(p), cubics_.v.at(p)}, tangent, {-bend * tangent.y_m, bend * tangent.x_m}};
}

}  // namespace cosiva::zone::opendrive
