#include "cosiva/zone/lif/lif_trajectory.h"

#include <algorithm>
#include <cmath>

namespace cosiva::zone::lif {
namespace {

constexpr auto mended = Diagnostic::Kind::mended;

/// Whether the knots make one unbroken curve of these points.
bool fit_together(const std::vector<double>& knots, std::size_t points, std::size_t degree) {
  if (knots.size() != points + degree + 1 || !std::is_sorted(knots.begin(), knots.end())) return false;
  if (!(knots[degree] < knots[points])) return false;
  std::size_t same = 1;
  for (std::size_t i = 1; i < knots.size(); ++i) {
    same = knots[i] == knots[i - 1] ? same + 1 : 1;
    const bool inner = knots[i] > knots[degree] && knots[i] < knots[points];
    if (same > degree + (inner ? 0 : 1)) return false;
  }
  return true;
}

bool read_points(const LifFields& fields, double scale, Nurbs& curve) {
  bool whole = true;
  fields.each("controlPoints", [&](const LifFields& point) {
    point.known({"x", "y", "weight"});
    const auto x = point.number("x");
    const auto y = point.number("y");
    if (x && y)
      curve.points.push_back({scale * *x, scale * *y});
    else
      whole = false;
    double weight = point.number("weight").value_or(1.0);
    if (!(weight > 1e-6 && weight < 1e6)) {
      point.record(mended, "weight", "a control point's weight must be positive; taken as 1");
      weight = 1.0;
    } else if (weight < 1.0) {
      point.record(mended, "weight",
                   "a weight below 1 breaks the official schema, though not the standard; taken as it is");
    }
    curve.weights.push_back(weight);
  });
  if (whole && curve.points.size() >= 2) return true;
  fields.record(mended, "controlPoints",
                whole ? "fewer than two control points make no curve; a straight line instead"
                      : "a control point lacks a coordinate; a straight line instead");
  return false;
}

void read_degree(const LifFields& fields, Nurbs& curve) {
  const double degree = fields.number("degree").value_or(1.0);
  const std::size_t most = std::min(curve.points.size() - 1, nurbs_degree_max);
  if (degree >= 1.0 && degree <= static_cast<double>(most) && degree == std::floor(degree)) {
    curve.degree = static_cast<std::size_t>(degree);
    return;
  }
  curve.degree = degree > static_cast<double>(most) ? most : 1;
  fields.record(mended, "degree",
                "a degree must be a whole number of at least 1, less than there are control points; taken as " +
                    std::to_string(curve.degree));
}

void read_knots(const LifFields& fields, Nurbs& curve) {
  bool whole = true;
  const bool there = fields
                         .each("knotVector",
                               [&](const LifFields& knot) {
                                 const auto value = knot.number();
                                 if (!value) whole = false;
                                 curve.knots.push_back(value.value_or(0.0));
                               })
                         .has_value();
  if (whole && fit_together(curve.knots, curve.points.size(), curve.degree)) {
    if (curve.knots.front() < 0.0 || curve.knots.back() > 1.0)
      fields.record(mended, "knotVector", "knots must lie between 0 and 1; taken as they are");
    return;
  }
  // Some programs leave out the first and the last knot, which change nothing.
  if (whole && curve.knots.size() >= 2) {
    std::vector<double> longer = curve.knots;
    longer.insert(longer.begin(), longer.front());
    longer.push_back(longer.back());
    if (fit_together(longer, curve.points.size(), curve.degree)) {
      curve.knots = std::move(longer);
      fields.record(mended, "knotVector", "the knot vector lacks its first and its last knot; they are doubled");
      return;
    }
  }
  const std::string found = there ? std::to_string(curve.knots.size()) + " knots" : "no knots";
  curve.knots = clamped_uniform_knots(curve.points.size(), curve.degree);
  fields.record(mended, "knotVector",
                "expected " + std::to_string(curve.knots.size()) + " ascending knots that hold together, found " +
                    found + "; evenly spaced ones instead",
                "uniform knots");
}

}  // namespace

std::optional<Nurbs> read_trajectory(const LifFields& fields, double scale) {
  fields.known({"degree", "knotVector", "controlPoints"});
  Nurbs curve;
  if (!read_points(fields, scale, curve)) return std::nullopt;
  read_degree(fields, curve);
  read_knots(fields, curve);
  return curve;
}

}  // namespace cosiva::zone::lif
