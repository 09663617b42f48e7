#include "cosiva/experiments/statistics/crossed.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "cosiva/base/expect.h"
#include "cosiva/experiments/statistics/sample.h"
#include "cosiva/experiments/statistics/special.h"

namespace cosiva::statistics {
namespace {

using Column = std::vector<double>;

double dot(const Column& a, const Column& b) {
  double sum = 0.0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += a[i] * b[i];
  return sum;
}

/// The span of columns, by modified Gram–Schmidt applied twice; dependent columns are left out.
///
/// Invariant: the axes are orthonormal, and all columns have the same length.
class Span {
 public:
  void add(Column column) {
    COSIVA_EXPECT(axes_.empty() || axes_.front().size() == column.size());
    const double before = std::sqrt(dot(column, column));
    for (int round = 0; round < 2; ++round)
      for (const Column& axis : axes_) subtract(column, axis, dot(column, axis));
    const double left = std::sqrt(dot(column, column));
    if (!(left > 1e-9 * before)) return;
    for (double& x : column) x /= left;
    axes_.push_back(std::move(column));
  }
  [[nodiscard]] Column residual(Column y) const {
    for (const Column& axis : axes_) subtract(y, axis, dot(y, axis));
    return y;
  }
  [[nodiscard]] double rank() const { return static_cast<double>(axes_.size()); }

 private:
  static void subtract(Column& from, const Column& axis, double amount) {
    for (std::size_t i = 0; i < from.size(); ++i) from[i] -= amount * axis[i];
  }
  std::vector<Column> axes_;
};

struct Design {
  std::span<const Trial> trials;
  std::vector<std::size_t> units;
  std::vector<std::size_t> carriers;

  [[nodiscard]] Column column(auto of) const {
    Column values;
    values.reserve(trials.size());
    for (const Trial& trial : trials) values.push_back(of(trial));
    return values;
  }
  void add_units(Span& span) const {
    for (const std::size_t unit : units) span.add(column([=](const Trial& t) { return t.unit == unit ? 1.0 : 0.0; }));
  }
  void add_carriers(Span& span) const {
    for (const std::size_t c : carriers) span.add(column([=](const Trial& t) { return t.carrier == c ? 1.0 : 0.0; }));
  }
  void add_run(Span& span) const {
    span.add(column([](const Trial& t) { return t.run; }));
  }
  [[nodiscard]] Span of(bool with_units, bool with_carriers, bool with_run) const {
    Span span;
    span.add(Column(trials.size(), 1.0));
    if (with_units) add_units(span);
    if (with_carriers) add_carriers(span);
    if (with_run) add_run(span);
    return span;
  }
};

double squares_left(const Span& span, const Column& y) {
  const Column left = span.residual(y);
  return dot(left, left);
}

/// Effects of levels about their mean: the residuals after all else has been removed, averaged.
std::vector<double> effects(const Design& design, const std::vector<std::size_t>& levels, const Span& others,
                            const Column& y, auto level_of) {
  // Least squares for the levels' columns after projection onto the complement of the others: a few rounds of
  // Gauss–Seidel, which converge at once for a crossed design.
  std::vector<Column> columns;
  columns.reserve(levels.size());
  for (const std::size_t level : levels)
    columns.push_back(others.residual(design.column([&](const Trial& t) { return level_of(t) == level ? 1.0 : 0.0; })));
  std::vector<double> found(levels.size(), 0.0);
  Column left = others.residual(y);
  for (int round = 0; round < 500; ++round) {
    for (std::size_t k = 0; k < levels.size(); ++k) {
      const double norm = dot(columns[k], columns[k]);
      if (!(norm > 1e-12)) continue;
      const double step = dot(columns[k], left) / norm;
      found[k] += step;
      for (std::size_t i = 0; i < left.size(); ++i) left[i] -= step * columns[k][i];
    }
  }
  const double centre = mean(found);
  for (double& effect : found) effect -= centre;
  return found;
}

}  // namespace

std::optional<Crossed> crossed(std::span<const Trial> trials) {
  std::set<std::size_t> units;
  std::set<std::size_t> carriers;
  for (const Trial& trial : trials) {
    units.insert(trial.unit);
    carriers.insert(trial.carrier);
  }
  const Design design{trials, {units.begin(), units.end()}, {carriers.begin(), carriers.end()}};
  const Column y = design.column([](const Trial& t) { return t.value; });
  const auto n = static_cast<double>(trials.size());
  const Span whole = design.of(true, true, true);
  if (!(n > whole.rank())) return std::nullopt;

  Crossed found{};
  found.noise_degrees = n - whole.rank();
  const double noise = squares_left(whole, y) / found.noise_degrees;
  const auto evaluate = [&](const Span& without, double levels) {
    Factor factor{};
    factor.degrees = whole.rank() - without.rank();
    if (factor.degrees < 0.5) return factor;
    const double mean_square = (squares_left(without, y) - noise * found.noise_degrees) / factor.degrees;
    factor.f = noise > 0.0 ? mean_square / noise : 0.0;
    factor.p = noise > 0.0 ? 1.0 - fisher_cdf(factor.f, factor.degrees, found.noise_degrees) : 1.0;
    factor.sd = std::sqrt(std::max(0.0, (mean_square - noise) / (n / levels)));
    return factor;
  };
  const Span no_unit = design.of(false, true, true);
  const Span no_carrier = design.of(true, false, true);
  const auto unit_levels = static_cast<double>(units.size());
  const auto carrier_levels = static_cast<double>(carriers.size());
  found.unit = evaluate(no_unit, unit_levels);
  found.carrier = evaluate(no_carrier, carrier_levels);
  found.run = evaluate(design.of(true, true, false), 1.0);
  // Levels that are partly determined by the other factors have fewer degrees of freedom than their number less one.
  found.confounded = found.unit.degrees < unit_levels - 1.5 || found.carrier.degrees < carrier_levels - 1.5;
  if (found.confounded) found.unit = found.carrier = evaluate(design.of(false, false, true), unit_levels);

  const Span no_run = design.of(true, true, false);
  const Column run = no_run.residual(design.column([](const Trial& t) { return t.run; }));
  const double run_norm = dot(run, run);
  found.slope = run_norm > 1e-9 ? dot(run, y) / run_norm : 0.0;
  const double run_variance = variance(design.column([](const Trial& t) { return t.run; }));
  found.run.sd = std::fabs(found.slope) * std::sqrt(run_variance);
  found.noise_sd = std::sqrt(noise);
  const double carrier_variance = found.confounded ? 0.0 : found.carrier.sd * found.carrier.sd;
  const double total = found.unit.sd * found.unit.sd + carrier_variance + found.run.sd * found.run.sd + noise;
  if (total > 0.0) {
    found.unit.ratio = found.unit.sd * found.unit.sd / total;
    found.carrier.ratio = carrier_variance / total;
    found.run.ratio = found.run.sd * found.run.sd / total;
    found.noise_ratio = noise / total;
  }
  if (!found.confounded) {
    found.unit_effects = effects(design, design.units, no_unit, y, [](const Trial& t) { return t.unit; });
    found.carrier_effects = effects(design, design.carriers, no_carrier, y, [](const Trial& t) { return t.carrier; });
  }
  return found;
}

}  // namespace cosiva::statistics
