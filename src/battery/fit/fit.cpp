#include "cosiva/battery/fit/fit.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>

#include "cosiva/base/least_squares.h"
#include "cosiva/base/math.h"
#include "cosiva/battery/fit/discharge.h"
#include "cosiva/battery/fit/predict.h"

namespace cosiva::battery {
namespace {

constexpr double sample_worth_s = 2.0;     // a sample's weight is the time since the last one, up to this
constexpr double sample_least_s = 0.5;     // samples at shorter intervals are thinned out at steady current
constexpr double ocv_growth_min_v = 1e-4;  // from row to row
constexpr double range_min = 0.5;
constexpr std::size_t cycles_few = 6;

/// One sample in the form needed for least squares.
struct Point {
  double charge;
  double current_a;
  double voltage_v;
  double weight;
  double dt_s;
  bool first;  ///< of its discharge: rested before
};

struct Problem {
  std::vector<double> charge;  ///< knots
  std::vector<Point> points;
  double capacity_ah{0.0};
  double weight{0.0};
  double current_sq{0.0};   ///< mean
  bool one_current{false};  ///< under load: resistance and voltage are then distinguished only at steps
  std::size_t loads{0};     ///< number of starts of a load …
  std::size_t brief{0};     ///< … and of those that ended by the next sample
};

/// Position of a charge between the knots: (1 − t) of knot i and t of knot i + 1.
struct Hat {
  std::size_t i;
  double t;
};
Hat hat_of(const std::vector<double>& knots, double charge) {
  const auto above = std::ranges::upper_bound(knots, charge);
  const auto i =
      std::min(static_cast<std::size_t>(std::max<std::ptrdiff_t>(0, above - knots.begin() - 1)), knots.size() - 2);
  return {i, std::clamp((charge - knots[i]) / (knots[i + 1] - knots[i]), 0.0, 1.0)};
}

/// The unknowns, n of each: OCV at the first knot and its growth to each next, R0, R1, R2. One row of the design matrix
/// for each sample: the pairs' rows are the hats' own currents, filtered.
Matrix design_matrix(const Problem& problem, double fast_s, double slow_s) {
  const std::size_t n = problem.charge.size();
  Matrix matrix{problem.points.size(), 4 * n};
  std::vector<double> fast(n, 0.0);
  std::vector<double> slow(n, 0.0);
  for (std::size_t row = 0; row < problem.points.size(); ++row) {
    const Point& point = problem.points[row];
    const Hat hat = hat_of(problem.charge, point.charge);
    if (point.first) {
      std::ranges::fill(fast, 0.0);
      std::ranges::fill(slow, 0.0);
    }
    const double fast_keeps = det_exp(-std::min(600.0, point.dt_s / fast_s));
    const double slow_keeps = det_exp(-std::min(600.0, point.dt_s / slow_s));
    for (double& current : fast) current *= fast_keeps;
    for (double& current : slow) current *= slow_keeps;
    for (const auto& [knot, ratio] : {std::pair{hat.i, 1.0 - hat.t}, std::pair{hat.i + 1, hat.t}}) {
      fast[knot] += (1.0 - fast_keeps) * ratio * point.current_a;
      slow[knot] += (1.0 - slow_keeps) * ratio * point.current_a;
      matrix(row, n + knot) = -ratio * point.current_a;
    }
    for (std::size_t j = 0; j <= hat.i; ++j) matrix(row, j) = 1.0;
    matrix(row, hat.i + 1) = hat.t;
    for (std::size_t j = 0; j < n; ++j) {
      matrix(row, 2 * n + j) = -fast[j];
      matrix(row, 3 * n + j) = -slow[j];
    }
  }
  return matrix;
}

/// Resistances tend towards those of their neighbours, which determine a resistance that a log does not.
void add_smoothness(const Problem& problem, Matrix& normal) {
  const std::size_t n = problem.charge.size();
  constexpr std::array strength{1e-4, 1e-3, 1e-3};
  for (std::size_t kind = 0; kind < 3; ++kind) {
    const double lambda = strength[kind] * problem.weight * problem.current_sq / static_cast<double>(n);
    for (std::size_t j = 0; j + 1 < n; ++j) {
      const std::size_t a = (kind + 1) * n + j;
      normal(a, a) += lambda;
      normal(a + 1, a + 1) += lambda;
      normal(a, a + 1) -= lambda;
      normal(a + 1, a) -= lambda;
    }
    // And towards zero, a thousandth as strongly: two that cannot be distinguished divide their sum.
    for (std::size_t j = 0; j < n; ++j) normal((kind + 1) * n + j, (kind + 1) * n + j) += 1e-3 * lambda;
  }
  for (std::size_t j = 0; j < n; ++j) normal(j, j) += 1e-9 * problem.weight;
}

/// Under constant current a fall of the voltage may also be a resistance: then resistances tend towards those of a
/// usual lithium cell, which at 1C cause 0.13 V in all.
void add_usual_resistances(const Problem& problem, NormalEquations& equations) {
  if (!problem.one_current) return;
  const std::size_t n = problem.charge.size();
  constexpr std::array usual_v_per_c{0.05, 0.04, 0.04};
  const double lambda = 0.1 * problem.weight * problem.current_sq / static_cast<double>(n);
  for (std::size_t kind = 0; kind < 3; ++kind) {
    for (std::size_t j = 0; j < n; ++j) {
      const std::size_t a = (kind + 1) * n + j;
      equations.normal(a, a) += lambda;
      equations.right[a] += lambda * usual_v_per_c[kind] / problem.capacity_ah;
    }
  }
}

struct Solution {
  double fast_s{};
  double slow_s{};
  double sum_sq{std::numeric_limits<double>::infinity()};  ///< weighted, of all fitted samples
  std::vector<double> x;
};

Solution solve(const Problem& problem, double fast_s, double slow_s) {
  const std::size_t n = problem.charge.size();
  const Matrix matrix = design_matrix(problem, fast_s, slow_s);
  std::vector<double> y;
  std::vector<double> weights;
  for (const Point& point : problem.points) {
    y.push_back(point.voltage_v);
    weights.push_back(point.weight);
  }
  // The unknowns are what is above the least growth.
  std::vector<double> least_growth(4 * n, 0.0);
  for (std::size_t j = 1; j < n; ++j) least_growth[j] = ocv_growth_min_v;
  y = residuals(matrix, least_growth, y);
  for (double& volt : y) volt = -volt;
  NormalEquations equations = normal_equations(matrix, weights, y);
  add_smoothness(problem, equations.normal);
  add_usual_resistances(problem, equations);
  Solution solution{fast_s, slow_s, 0.0, nonnegative_least_squares(equations)};
  solution.sum_sq = weighted_squares(weights, residuals(matrix, solution.x, y));
  for (std::size_t j = 0; j < solution.x.size(); ++j) solution.x[j] += least_growth[j];
  return solution;
}

Solution search(const Problem& problem) {
  Solution best;
  const auto consider = [&](double fast_s, double slow_s) {
    if (slow_s < 3.0 * fast_s) return;
    Solution one = solve(problem, fast_s, slow_s);
    if (one.sum_sq < best.sum_sq) best = std::move(one);
  };
  for (const double fast_s : {5.0, 10.0, 20.0, 40.0, 80.0})
    for (const double slow_s : {200.0, 400.0, 800.0, 1600.0}) consider(fast_s, slow_s);
  const double fast_s = best.fast_s;
  const double slow_s = best.slow_s;
  for (const double a : {0.7, 1.0, 1.4})
    for (const double b : {0.7, 1.0, 1.4})
      if (a != 1.0 || b != 1.0) consider(a * fast_s, b * slow_s);
  return best;
}

double lowest_of(const std::vector<Discharge>& discharges) {
  double volt = std::numeric_limits<double>::infinity();
  for (const Discharge& one : discharges) volt = std::min(volt, lowest_under_load_v(one));
  return volt;
}

void record_loads(Problem& problem) {
  double load = 0.0;
  double load_a = 0.0;
  double load_sq = 0.0;
  const std::vector<Point>& points = problem.points;
  double least_a = 0.0;  // smaller currents are the tester's zero error
  for (const Point& point : points) least_a = std::max(least_a, 0.02 * point.current_a);
  for (std::size_t k = 0; k < points.size(); ++k) {
    const Point& point = points[k];
    if (point.current_a <= least_a) continue;
    load += point.weight;
    load_a += point.weight * point.current_a;
    load_sq += point.weight * point.current_a * point.current_a;
    const auto is_other = [&](std::size_t other) {
      return std::fabs(points[other].current_a - point.current_a) > 0.05 * point.current_a;
    };
    if (!point.first && k > 0 && !is_other(k - 1)) continue;
    ++problem.loads;
    if (k + 1 < points.size() && !points[k + 1].first && is_other(k + 1)) ++problem.brief;
  }
  problem.one_current = load > 0.0 && load_sq * load < 1.001 * load_a * load_a;
}

Problem make_problem(const std::vector<Discharge>& discharges, const std::vector<double>& knots, double capacity_ah) {
  Problem problem;
  problem.charge = knots;
  problem.capacity_ah = capacity_ah;
  for (const Discharge& one : discharges) {
    const Log& log = *one.log;
    double before_s = load_on_s(one);
    for (std::size_t i = one.first; i < one.last; ++i) {
      // Between two steps of the current, samples at shorter intervals than half a second carry no further information.
      const bool is_steady = i > one.first && i + 1 < one.last && log.current_a[i] == log.current_a[i - 1] &&
                             log.current_a[i] == log.current_a[i + 1];
      const double dt_s = log.time_s[i] - before_s;
      if (is_steady && log.time_s[i + 1] - before_s <= sample_least_s) continue;
      before_s = log.time_s[i];
      const double weight = std::min(dt_s, sample_worth_s);
      problem.points.push_back({1.0 - one.used_ah[i - one.first] / capacity_ah, log.current_a[i], log.voltage_v[i],
                                weight, dt_s, i == one.first});
      problem.weight += weight;
      problem.current_sq += weight * log.current_a[i] * log.current_a[i];
    }
  }
  problem.current_sq /= problem.weight;
  record_loads(problem);
  return problem;
}

/// The logs' temperatures under load.
struct Warmth {
  double mean_c{25.0};
  double low_c{25.0};  ///< of the logs' own means
  double high_c{25.0};
  bool is_known{false};
};
Warmth warmth_of(const std::vector<Discharge>& discharges) {
  Warmth warmth{0.0, 1e9, -1e9, false};
  double weight = 0.0;
  for (const Discharge& one : discharges) {
    const Log& log = *one.log;
    if (log.temperature_c.empty()) continue;
    double own = 0.0;
    double own_weight = 0.0;
    for (std::size_t i = one.first + 1; i < one.last; ++i) {
      if (log.current_a[i] <= 0.0) continue;
      const double dt_s = log.time_s[i] - log.time_s[i - 1];
      own += dt_s * log.temperature_c[i];
      own_weight += dt_s;
    }
    if (own_weight <= 0.0) continue;
    warmth.mean_c += own;
    weight += own_weight;
    warmth.low_c = std::min(warmth.low_c, own / own_weight);
    warmth.high_c = std::max(warmth.high_c, own / own_weight);
  }
  if (weight <= 0.0) return {};
  warmth.mean_c = 0.1 * std::nearbyint(10.0 * warmth.mean_c / weight);
  warmth.is_known = true;
  return warmth;
}

std::string few_digits(double value) {
  std::array<char, 32> buffer{};
  const auto [end, error] =
      std::to_chars(buffer.data(), buffer.data() + buffer.size(), value, std::chars_format::general, 3);
  return {buffer.data(), error == std::errc{} ? end : buffer.data()};
}

/// A battery delivers slightly less to a larger load. A large difference has another cause: another battery or
/// temperature, or a tester with a wrong current in one of its ranges.
void record_capacities(const std::vector<Discharge>& discharges, double floor_v,
                       std::vector<std::string>& diagnostics) {
  double least_ah = std::numeric_limits<double>::infinity();
  double most_ah = 0.0;
  for (const Discharge& one : discharges) {
    if (lowest_under_load_v(one) > floor_v + 0.05) continue;  // not discharged to the end
    const double own_ah = *std::ranges::max_element(one.used_ah);
    least_ah = std::min(least_ah, own_ah);
    most_ah = std::max(most_ah, own_ah);
  }
  constexpr double usual_ratio = 0.95;
  if (least_ah < usual_ratio * most_ah)
    diagnostics.push_back(
        "down to the same voltage the discharges take out between " + few_digits(least_ah) + " and " +
        few_digits(most_ah) +
        " Ah: unless this is one battery at very different rates, fit each battery separately (--only)");
}

/// Reports how accurately the logs determine the charge taken out.
void record_charge(const std::vector<Discharge>& discharges, const Problem& problem, Fit& fit) {
  std::size_t counted = 0;
  for (const Discharge& one : discharges) {
    fit.charge_uncertain = std::max(fit.charge_uncertain, one.uncertain);
    if (one.is_counted) ++counted;
    if (one.scale != 1.0)
      fit.diagnostics.push_back("the samples are too infrequent to determine the charge taken out: their count was " +
                                few_digits(100.0 * (1.0 / one.scale - 1.0)) +
                                " % off the given capacity, and is scaled to it");
  }
  if (counted > 0)
    fit.diagnostics.push_back("in " + std::to_string(counted) + " of " + std::to_string(discharges.size()) +
                              " discharges the charge was counted by the tester itself");
  constexpr double is_significant = 0.01;
  if (fit.charge_uncertain <= is_significant) return;
  fit.diagnostics.push_back(
      "the charge taken out, and so the capacity and every predicted time, may be off by " +
      few_digits(100.0 * fit.charge_uncertain) + " %: the current changed at unknown times between samples (" +
      std::to_string(problem.brief) + " of " + std::to_string(problem.loads) +
      " loads have one sample only, and shorter ones have none). Sample more often, let the tester write " +
      "'discharging_capacity_ah' and 'charging_capacity_ah', or give the capacity if it is known (--capacity)");
}

void record_warmth(const Warmth& warmth, std::vector<std::string>& diagnostics) {
  if (!warmth.is_known) {
    diagnostics.emplace_back("the logs contain no temperature: 25 °C is assumed");
    return;
  }
  diagnostics.push_back("measured at " + few_digits(warmth.mean_c) +
                        " °C: the type's resistances apply to that temperature");
  if (warmth.high_c - warmth.low_c > 8.0)
    diagnostics.push_back("the discharges' own temperatures range from " + few_digits(warmth.low_c) + " to " +
                          few_digits(warmth.high_c) +
                          " °C and are fitted together: fit each temperature separately (--only)");
}

BatteryType make_type(const Solution& solution, const FitOptions& options, double capacity_ah, double floor_v,
                      double full_v, double reference_c) {
  const std::size_t n = options.charge.size();
  BatteryType type;
  type.name = options.name;
  type.source = options.source;
  type.licence = options.licence;
  type.capacity_ah = capacity_ah;
  type.coulombic_efficiency = 0.999;
  type.voltage_floor_v = floor_v;
  type.voltage_full_v = full_v;
  // A lithium cell of 1 Ah weighs about 25 g, and a gram takes about 1 J/K.
  type.heat_capacity_j_per_k = 25.0 * capacity_ah;
  type.heat_loss_w_per_k = 0.03 * capacity_ah;
  type.activation_j_per_mol = 20000.0;
  type.reference_temperature_c = std::clamp(reference_c, -40.0, 85.0);
  type.temperature_min_c = std::min(0.0, type.reference_temperature_c - 5.0);
  type.temperature_max_c = std::max(60.0, type.reference_temperature_c + 5.0);
  type.capacity_fade_per_cycle = 0.0004;
  type.resistance_growth_per_cycle = 0.0008;
  type.capacity_spread = 0.01;
  type.resistance_spread = 0.03;
  type.charge = options.charge;
  double volt = 0.0;
  double mean_ohm = 0.0;
  const auto at = [&](std::size_t kind, std::size_t j) { return solution.x[kind * n + j]; };
  for (std::size_t j = 0; j < n; ++j) mean_ohm += at(1, j) / static_cast<double>(n);
  for (std::size_t j = 0; j < n; ++j) {
    type.open_circuit_v.push_back(volt += at(0, j));
    // R0 must be above zero in a file: a hundredth of the others' mean is negligible.
    type.series_ohm.push_back(std::max({at(1, j), 0.01 * mean_ohm, 1e-8}));
    type.fast_ohm.push_back(std::max(0.0, at(2, j)));
    type.slow_ohm.push_back(std::max(0.0, at(3, j)));
  }
  type.fast_s.assign(n, solution.fast_s);
  type.slow_s.assign(n, solution.slow_s);
  return type;
}

double most_taken_ah(const std::vector<Discharge>& discharges) {
  double taken_ah = 0.0;
  for (const Discharge& one : discharges) taken_ah = std::max(taken_ah, *std::ranges::max_element(one.used_ah));
  return taken_ah;
}

/// Reports what readers of the metrics should know in addition.
void record_all(const std::vector<Log>& logs, const std::vector<Discharge>& discharges, const Problem& problem,
                const FitOptions& options, const Warmth& warmth, Fit& fit) {
  for (const Log& log : logs)
    for (const std::string& diagnostic : log.diagnostics)
      if (std::ranges::find(fit.diagnostics, diagnostic) == fit.diagnostics.end())
        fit.diagnostics.push_back(diagnostic);
  double& largest_a = fit.largest_a;
  for (const Point& point : problem.points) largest_a = std::max(largest_a, point.current_a);
  fit.diagnostics.push_back("fitted up to " + few_digits(largest_a) +
                            " A: above this current the type is an extrapolation");
  constexpr double rate_suspicious = 50.0;
  if (largest_a > rate_suspicious * fit.type.capacity_ah)
    fit.diagnostics.push_back("this is " + few_digits(largest_a / fit.type.capacity_ah) +
                              "C: if the battery never delivered so much, the times are not in seconds");
  record_charge(discharges, problem, fit);
  if (problem.one_current)
    fit.diagnostics.emplace_back(
        "one current only: only the steps at its start and end distinguish resistance from voltage; the usual is "
        "assumed");
  constexpr double rms_suspicious_v = 0.03;
  if (fit.rms_v > rms_suspicious_v)
    fit.diagnostics.push_back("off by " + few_digits(1e3 * fit.rms_v) +
                              " mV: no single battery behaves like these logs; fit each battery separately (--only)");
  record_warmth(warmth, fit.diagnostics);
  if (options.capacity_ah <= 0.0)
    fit.diagnostics.emplace_back("the capacity is the charge that the slowest discharge took out");
  record_capacities(discharges, fit.type.voltage_floor_v, fit.diagnostics);
  fit.diagnostics.emplace_back(
      "assumed, as no log determines these: heat capacity and loss, activation energy, fade, growth, spread");
}

}  // namespace

Result<Fit> fit_type(const std::vector<Log>& logs, const FitOptions& options) {
  const double full_v = options.full_v > 0.0 ? options.full_v : highest_voltage_v(logs);
  std::vector<Discharge> discharges;
  for (const Log& log : logs) {
    for (Discharge& one : discharges_from_full(log, full_v)) discharges.push_back(std::move(one));
  }
  if (discharges.empty())
    return fail("fit.full", "no discharge begins full, at " + std::to_string(full_v) + " V or a little below",
                logs.empty() ? std::string{} : logs.front().name);
  if (options.capacity_ah > 0.0)
    scale_to_capacity(discharges, options.capacity_ah, options.floor_v > 0.0 ? options.floor_v : lowest_of(discharges));
  const double taken_ah = most_taken_ah(discharges);
  const double capacity_ah = options.capacity_ah > 0.0 ? options.capacity_ah : taken_ah;
  if (!(capacity_ah > 0.0) || taken_ah > 1.02 * capacity_ah)
    return fail("fit.capacity", "the logs take out " + std::to_string(taken_ah) + " Ah, more than the capacity given",
                "--capacity");
  if (taken_ah < range_min * capacity_ah)
    return fail("fit.range",
                "the logs take out " + std::to_string(taken_ah) + " Ah only, less than half of the capacity",
                "--capacity");
  double moved_ah = 0.0;
  for (const Log& log : logs) moved_ah = std::max(moved_ah, charge_moved_ah(log));
  // Over many cycles a tester's error accumulates; over few it does not double a battery's capacity.
  if (options.capacity_ah <= 0.0 && discharges.size() < cycles_few && taken_ah < range_min * moved_ah)
    return fail("fit.range",
                "the discharges that begin full take out " + few_digits(taken_ah) + " Ah, but the log moves " +
                    few_digits(moved_ah) + " Ah: give a discharge from full to empty, or --capacity",
                discharges.front().log->name);
  const double floor_v = options.floor_v > 0.0 ? options.floor_v : 0.01 * std::nearbyint(100.0 * lowest_of(discharges));
  if (!(floor_v < full_v)) return fail("fit.range", "the voltage never falls under load", discharges.front().log->name);

  const Problem problem = make_problem(discharges, options.charge, capacity_ah);
  const Solution solution = search(problem);
  if (!std::ranges::all_of(solution.x, [](double x) { return std::isfinite(x); }))
    return fail("fit.spread", "these logs do not determine the tables; a pulse test does",
                discharges.front().log->name);
  Fit fit;
  const Warmth warmth = warmth_of(discharges);
  fit.type = make_type(solution, options, capacity_ah, floor_v, full_v, warmth.mean_c);
  fit.fast_s = solution.fast_s;
  fit.slow_s = solution.slow_s;
  fit.rms_v = std::sqrt(solution.sum_sq / problem.weight);
  fit.residuals = predict(fit.type, logs, 0.0, options.capacity_ah);
  record_all(logs, discharges, problem, options, warmth, fit);
  return fit;
}

}  // namespace cosiva::battery
