#include "cosiva/zone/geometry/curve_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace cosiva::zone {
namespace {

constexpr std::size_t spans_first = 64;
constexpr std::size_t spans_max = 1U << 16U;
constexpr double length_error = 1e-10;  ///< of the length, from one number of spans to the next
/// Between samples a smooth curve may bend a little more than at any of them.
constexpr double curvature_reserve = 1.02;

double speed_of(const CurveFormulas::At& at) { return norm(at.velocity.x_m, at.velocity.y_m); }

double curvature_of(const CurveFormulas::At& at) {
  const double speed = speed_of(at);
  return (at.velocity.x_m * at.acceleration.y_m - at.velocity.y_m * at.acceleration.x_m) / (speed * speed * speed);
}

double heading_of(const CurveFormulas::At& at) { return det_atan2(at.velocity.y_m, at.velocity.x_m); }

/// ∫ |velocity| dt from a to b, by Gauss and Legendre with five points.
double length_between(const CurveFormulas& curve, double a, double b) {
  constexpr std::array<double, 3> abscissa{0.0, 0.5384693101056831, 0.9061798459386640};
  constexpr std::array<double, 3> weight{0.5688888888888889, 0.4786286704993665, 0.2369268850561891};
  const double centre = 0.5 * (a + b);
  const double half = 0.5 * (b - a);
  double sum = weight[0] * speed_of(curve.at(centre));
  for (const std::size_t i : {1U, 2U})
    sum +=
        weight[i] * (speed_of(curve.at(centre - half * abscissa[i])) + speed_of(curve.at(centre + half * abscissa[i])));
  return half * sum;
}

}  // namespace

CurveShape::CurveShape(std::string kind, std::vector<Field> fields, CurveFormulas curve)
    : kind_{std::move(kind)}, fields_{std::move(fields)}, curve_{std::move(curve)} {
  const CurveFormulas::At start = curve_.at(0.0);
  X_SM_ = inverse(Pose2{start.position.x_m, start.position.y_m, heading_of(start)});
}

Result<std::shared_ptr<const SectionShape>> CurveShape::make(std::string kind, std::vector<Field> fields,
                                                             CurveFormulas curve) {
  if (!(curve.t_max > 0.0) || !std::isfinite(curve.t_max))
    return fail("section.invalid", "a section of kind '" + kind + "' has an empty range of t");
  const std::shared_ptr<CurveShape> shape{new CurveShape(std::move(kind), std::move(fields), std::move(curve))};
  if (!shape->measure())
    return fail("section.invalid", "the arc length of a section of kind '" + shape->kind_ +
                                       "' cannot be computed: its formulas are not finite, or its velocity vanishes");
  if (auto checked = check_shape(*shape); !checked) return tl::unexpected(std::move(checked).error());
  return shape;
}

double CurveShape::speed_at(double t) const { return speed_of(curve_.at(t)); }

/// Doubles the number of spans until the length no longer changes and the table's t is exact between its knots.
bool CurveShape::measure() {
  double before_m = 0.0;
  for (std::size_t spans = spans_first; spans <= spans_max; spans *= 2) {
    std::vector<double> s_of(spans + 1, 0.0);
    const double step = curve_.t_max / static_cast<double>(spans);
    curvature_max_per_m_ = 0.0;
    for (std::size_t i = 0; i <= spans; ++i) {
      const double t = i == spans ? curve_.t_max : static_cast<double>(i) * step;
      const CurveFormulas::At at = curve_.at(t);
      const double speed = speed_of(at);
      if (!(speed > 0.0) || !std::isfinite(speed) || !std::isfinite(curvature_of(at))) return false;
      curvature_max_per_m_ = std::max(curvature_max_per_m_, curvature_reserve * std::fabs(curvature_of(at)));
      if (i > 0) s_of[i] = s_of[i - 1] + length_between(curve_, t - step, t);
    }
    length_m_ = s_of.back();
    if (!std::isfinite(length_m_)) return false;

    // The knots at equal steps of s: Newton's method from the table of s over t.
    knots_per_m_ = static_cast<double>(spans) / length_m_;
    knots_.resize(spans + 1);
    std::size_t below = 0;
    for (std::size_t i = 0; i <= spans; ++i) {
      const double s = static_cast<double>(i) / knots_per_m_;
      while (below + 1 < spans && s_of[below + 1] <= s) ++below;
      const double from = static_cast<double>(below) * step;
      double t = from + (s - s_of[below]) / speed_at(from);
      for (int round = 0; round < 8; ++round)
        t = std::clamp(t - (s_of[below] + length_between(curve_, from, t) - s) / speed_at(t), 0.0, curve_.t_max);
      knots_[i] = {t, 1.0 / speed_at(t)};
    }
    double worst_m = std::fabs(length_m_ - before_m);
    for (std::size_t i = 0; i < spans; ++i) {
      const double s = (static_cast<double>(i) + 0.5) / knots_per_m_;
      const double t = t_at(s);
      const double s_there = static_cast<double>(i) / knots_per_m_ + length_between(curve_, knots_[i].t, t);
      worst_m = std::max(worst_m, std::fabs(s_there - s));
    }
    if (worst_m <= length_error * length_m_) return true;
    before_m = length_m_;
  }
  return true;  // check_shape decides whether the rest of the error matters
}

double CurveShape::t_at(double s_m) const {
  const double at = std::max(0.0, s_m * knots_per_m_);
  const std::size_t i = std::min(static_cast<std::size_t>(at), knots_.size() - 2);
  const Knot& a = knots_[i];
  const Knot& b = knots_[i + 1];
  const double u = at - static_cast<double>(i);
  const double step_m = 1.0 / knots_per_m_;
  // The cubic with the knots' values and slopes.
  const double rise = b.t - a.t;
  const double from = a.t_per_m * step_m - rise;
  const double to = rise - b.t_per_m * step_m;
  return a.t + u * (rise + (1.0 - u) * ((1.0 - u) * from + u * to));
}

Pose2 CurveShape::pose_at(double s_m) const {
  const CurveFormulas::At at = curve_.at(t_at(s_m));
  return X_SM_ * Pose2{at.position.x_m, at.position.y_m, heading_of(at)};
}

double CurveShape::curvature_at(double s_m) const { return curvature_of(curve_.at(t_at(s_m))); }

}  // namespace cosiva::zone
