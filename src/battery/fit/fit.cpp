#include "battery/fit/fit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "base/math.h"
#include "battery/fit/least_squares.h"
#include "battery/pack.h"

namespace cosiva::battery {
namespace {

constexpr double sample_worth_s = 2.0;     // a sample counts for the time since the last one, at most so much
constexpr double ocv_growth_min_v = 1e-4;  // from row to row
constexpr double range_min = 0.5;

/// One sample as the least squares want it.
struct Point {
  double charge;
  double current_a;
  double voltage_v;
  double weight;
  double dt_s;
  bool first;  ///< of its discharge: rested until then
};

struct Problem {
  std::vector<double> charge;  ///< knots
  std::vector<Point> points;
  double weight{0.0};
  double current_sq{0.0};  ///< mean
};

/// Where a charge lies between the knots: it is (1 − t) of knot i and t of knot i + 1.
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
Eigen::MatrixXd design_matrix(const Problem& problem, double fast_s, double slow_s) {
  const auto n = static_cast<Eigen::Index>(problem.charge.size());
  Eigen::MatrixXd matrix = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(problem.points.size()), 4 * n);
  Eigen::VectorXd fast = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd slow = Eigen::VectorXd::Zero(n);
  for (std::size_t k = 0; k < problem.points.size(); ++k) {
    const Point& point = problem.points[k];
    const auto row = static_cast<Eigen::Index>(k);
    const Hat hat = hat_of(problem.charge, point.charge);
    const auto i = static_cast<Eigen::Index>(hat.i);
    if (point.first) {
      fast.setZero();
      slow.setZero();
    }
    const double fast_keeps = det_exp(-std::min(600.0, point.dt_s / fast_s));
    const double slow_keeps = det_exp(-std::min(600.0, point.dt_s / slow_s));
    fast *= fast_keeps;
    slow *= slow_keeps;
    for (const auto& [knot, share] : {std::pair{i, 1.0 - hat.t}, std::pair{i + 1, hat.t}}) {
      fast(knot) += (1.0 - fast_keeps) * share * point.current_a;
      slow(knot) += (1.0 - slow_keeps) * share * point.current_a;
      matrix(row, n + knot) = -share * point.current_a;
    }
    matrix(row, 0) = 1.0;
    for (Eigen::Index j = 1; j <= i; ++j) matrix(row, j) = 1.0;
    matrix(row, i + 1) = hat.t;
    matrix.row(row).segment(2 * n, n) = -fast.transpose();
    matrix.row(row).segment(3 * n, n) = -slow.transpose();
  }
  return matrix;
}

/// Resistances prefer to be like their neighbours': where a log does not tell one, its neighbours do.
void add_smoothness(const Problem& problem, Eigen::MatrixXd& normal) {
  const auto n = static_cast<Eigen::Index>(problem.charge.size());
  constexpr std::array strength{1e-4, 1e-3, 1e-3};
  for (Eigen::Index kind = 0; kind < 3; ++kind) {
    const double lambda =
        strength[static_cast<std::size_t>(kind)] * problem.weight * problem.current_sq / static_cast<double>(n);
    for (Eigen::Index j = 0; j + 1 < n; ++j) {
      const Eigen::Index a = (kind + 1) * n + j;
      normal(a, a) += lambda;
      normal(a + 1, a + 1) += lambda;
      normal(a, a + 1) -= lambda;
      normal(a + 1, a) -= lambda;
    }
    // And to be nothing at all, a thousandth as strongly: two that cannot be told apart share what they are.
    for (Eigen::Index j = 0; j < n; ++j) normal((kind + 1) * n + j, (kind + 1) * n + j) += 1e-3 * lambda;
  }
  for (Eigen::Index j = 0; j < n; ++j) normal(j, j) += 1e-9 * problem.weight;
}

struct Solution {
  double fast_s{};
  double slow_s{};
  double sum_sq{std::numeric_limits<double>::infinity()};  ///< weighted, of what was fitted
  Eigen::VectorXd x;
};

Solution solve(const Problem& problem, double fast_s, double slow_s) {
  const auto n = static_cast<Eigen::Index>(problem.charge.size());
  const auto rows = static_cast<Eigen::Index>(problem.points.size());
  const Eigen::MatrixXd matrix = design_matrix(problem, fast_s, slow_s);
  Eigen::VectorXd least_growth = Eigen::VectorXd::Zero(4 * n);
  least_growth.segment(1, n - 1).setConstant(ocv_growth_min_v);
  Eigen::VectorXd y(rows);
  Eigen::VectorXd w(rows);
  for (Eigen::Index k = 0; k < rows; ++k) {
    y(k) = problem.points[static_cast<std::size_t>(k)].voltage_v;
    w(k) = problem.points[static_cast<std::size_t>(k)].weight;
  }
  y -= matrix * least_growth;
  const Eigen::MatrixXd weighted = w.asDiagonal() * matrix;
  Eigen::MatrixXd normal = matrix.transpose() * weighted;
  const Eigen::VectorXd right = weighted.transpose() * y;
  add_smoothness(problem, normal);
  Solution solution{fast_s, slow_s, 0.0, nonnegative_least_squares(normal, right)};
  const Eigen::VectorXd off = matrix * solution.x - y;
  solution.sum_sq = off.dot(w.asDiagonal() * off);
  solution.x += least_growth;
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

double highest_v(const std::vector<Log>& logs) {
  double volt = 0.0;
  for (const Log& log : logs) volt = std::max(volt, *std::ranges::max_element(log.voltage_v));
  return volt;
}

double lowest_under_load_v(const std::vector<Discharge>& discharges) {
  double volt = std::numeric_limits<double>::infinity();
  for (const Discharge& one : discharges) {
    for (std::size_t i = one.first; i < one.last; ++i)
      if (one.log->current_a[i] > 0.0) volt = std::min(volt, one.log->voltage_v[i]);
  }
  return volt;
}

Problem make_problem(const std::vector<Discharge>& discharges, const std::vector<double>& knots, double capacity_ah) {
  Problem problem;
  problem.charge = knots;
  for (const Discharge& one : discharges) {
    const Log& log = *one.log;
    for (std::size_t i = one.first; i < one.last; ++i) {
      const double dt_s = log.time_s[i] - (i == one.first ? load_on_s(one) : log.time_s[i - 1]);
      const double weight = std::min(dt_s, sample_worth_s);
      problem.points.push_back({1.0 - one.used_ah[i - one.first] / capacity_ah, log.current_a[i], log.voltage_v[i],
                                weight, dt_s, i == one.first});
      problem.weight += weight;
      problem.current_sq += weight * log.current_a[i] * log.current_a[i];
    }
  }
  problem.current_sq /= problem.weight;
  return problem;
}

BatteryType make_type(const Solution& solution, const FitOptions& options, double capacity_ah, double floor_v,
                      double full_v) {
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
  type.temperature_max_c = 60.0;
  type.capacity_fade_per_cycle = 0.0004;
  type.resistance_growth_per_cycle = 0.0008;
  type.capacity_spread = 0.01;
  type.resistance_spread = 0.03;
  type.charge = options.charge;
  double volt = 0.0;
  double mean_ohm = 0.0;
  const auto at = [&](std::size_t kind, std::size_t j) { return solution.x(static_cast<Eigen::Index>(kind * n + j)); };
  for (std::size_t j = 0; j < n; ++j) mean_ohm += at(1, j) / static_cast<double>(n);
  for (std::size_t j = 0; j < n; ++j) {
    type.open_circuit_v.push_back(volt += at(0, j));
    // A file's R0 is above zero: a hundredth of the others' mean is as good as none.
    type.series_ohm.push_back(std::max({at(1, j), 0.01 * mean_ohm, 1e-8}));
    type.fast_ohm.push_back(std::max(0.0, at(2, j)));
    type.slow_ohm.push_back(std::max(0.0, at(3, j)));
  }
  type.fast_s.assign(n, solution.fast_s);
  type.slow_s.assign(n, solution.slow_s);
  return type;
}

}  // namespace

Result<Fit> fit_type(const std::vector<Log>& logs, const FitOptions& options) {
  const double full_v = options.full_v > 0.0 ? options.full_v : highest_v(logs);
  std::vector<Discharge> discharges;
  for (const Log& log : logs) {
    for (Discharge& one : discharges_from_full(log, full_v)) discharges.push_back(std::move(one));
  }
  if (discharges.empty())
    return fail("fit.full", "no discharge begins full, at " + std::to_string(full_v) + " V or a little below",
                logs.empty() ? std::string{} : logs.front().name);
  double taken_ah = 0.0;
  for (const Discharge& one : discharges) taken_ah = std::max(taken_ah, *std::ranges::max_element(one.used_ah));
  const double capacity_ah = options.capacity_ah > 0.0 ? options.capacity_ah : taken_ah;
  if (!(capacity_ah > 0.0) || taken_ah > 1.02 * capacity_ah)
    return fail("fit.capacity", "the logs take out " + std::to_string(taken_ah) + " Ah, more than the capacity given",
                "--capacity");
  if (taken_ah < range_min * capacity_ah)
    return fail("fit.range",
                "the logs take out " + std::to_string(taken_ah) + " Ah only, less than half of the capacity",
                "--capacity");
  const double floor_v =
      options.floor_v > 0.0 ? options.floor_v : 0.01 * std::nearbyint(100.0 * lowest_under_load_v(discharges));
  if (!(floor_v < full_v)) return fail("fit.range", "the voltage never falls under load", discharges.front().log->name);

  const Problem problem = make_problem(discharges, options.charge, capacity_ah);
  const Solution solution = search(problem);
  if (!solution.x.allFinite())
    return fail("fit.spread", "these logs do not determine the tables; a pulse test does",
                discharges.front().log->name);
  Fit fit;
  fit.type = make_type(solution, options, capacity_ah, floor_v, full_v);
  fit.fast_s = solution.fast_s;
  fit.slow_s = solution.slow_s;
  fit.rms_v = std::sqrt(solution.sum_sq / problem.weight);
  fit.residuals = predict(fit.type, logs);
  double largest_a = 0.0;
  double load = 0.0;
  double load_a = 0.0;
  double load_sq = 0.0;
  for (const Point& point : problem.points) {
    if (point.current_a <= 0.0) continue;
    largest_a = std::max(largest_a, point.current_a);
    load += point.weight;
    load_a += point.weight * point.current_a;
    load_sq += point.weight * point.current_a * point.current_a;
  }
  fit.notes.push_back("fitted up to " + std::to_string(static_cast<int>(std::ceil(largest_a))) +
                      " A: at more the type is a guess");
  if (load > 0.0 && load_sq * load < 1.001 * load_a * load_a)
    fit.notes.emplace_back("one current only: steps at its begin and end are all that tells resistance from voltage");
  if (options.capacity_ah <= 0.0) fit.notes.emplace_back("the capacity is what the slowest discharge took out");
  fit.notes.emplace_back(
      "assumed, as no log tells it: heat capacity and loss, activation energy, fade, growth, spread");
  return fit;
}

std::vector<Residual> predict(const BatteryType& type, const std::vector<Log>& logs, double floor_v) {
  constexpr double step_max_s = 1.0;
  const double floor = floor_v > 0.0 ? floor_v : type.voltage_floor_v;
  const auto table = std::make_shared<CellTable>(type);
  std::vector<Residual> residuals;
  for (const Log& log : logs) {
    for (const Discharge& one : discharges_from_full(log, highest_v(logs))) {
      residuals.push_back({log.name, one.last - one.first, 0.0, 0.0, 0.0, 1.0, seconds_to_voltage(one, floor),
                           std::numeric_limits<double>::quiet_NaN()});
      Residual& residual = residuals.back();
      Pack pack{table, {}, {"fit", 1, false, 0.0}, type.reference_temperature_c};
      const double start_s = load_on_s(one);
      double before_v = pack.voltage_v();
      double now_s = start_s;
      double sum_sq = 0.0;
      double load_s = 0.0;
      double load_as = 0.0;
      // Under the measured current sample by sample, up to where the floor was measured, or to the log's end; past that
      // under the last current.
      std::size_t end = one.last;
      for (std::size_t i = one.first; i < one.last && !std::isnan(residual.measured_s); ++i) {
        if (log.voltage_v[i] > floor) continue;
        end = i + 1;
        break;
      }
      residual.samples = end - one.first;
      for (std::size_t i = one.first; std::isnan(residual.predicted_s); ++i) {
        const bool is_past = i >= end;
        if (is_past && (std::isnan(residual.measured_s) || now_s - start_s > 1.5 * residual.measured_s)) break;
        const double current_a = log.current_a[is_past ? end - 1 : i];
        if (is_past && current_a <= 0.0) break;
        const double until_s = is_past ? now_s + 10.0 : log.time_s[i];
        while (now_s < until_s - 1e-9 && std::isnan(residual.predicted_s)) {
          const double dt_s = std::min(step_max_s, until_s - now_s);
          const PackStep step = pack.draw_current(current_a, type.reference_temperature_c, dt_s);
          now_s += dt_s;
          const bool is_out = step.event == PackEvent::empty || step.event == PackEvent::brown_out;
          if (step.voltage_v <= floor && current_a > 0.0) {
            const double share = before_v > step.voltage_v
                                     ? std::clamp((before_v - floor) / (before_v - step.voltage_v), 0.0, 1.0)
                                     : 1.0;
            residual.predicted_s = now_s - start_s - (1.0 - share) * dt_s;
          } else if (is_out && current_a > 0.0) {
            residual.predicted_s = now_s - start_s;
          }
          before_v = step.voltage_v;
        }
        if (is_past) continue;
        if (current_a > 0.0) {
          const double dt_s = log.time_s[i] - (i == one.first ? start_s : log.time_s[i - 1]);
          load_s += dt_s;
          load_as += current_a * dt_s;
        }
        if (!std::isnan(residual.predicted_s)) break;
        const double off_v = pack.voltage_v() - log.voltage_v[i];
        sum_sq += off_v * off_v;
        if (std::fabs(off_v) > residual.worst_v) {
          residual.worst_v = std::fabs(off_v);
          residual.worst_at_charge = pack.charge();
        }
      }
      residual.rms_v = std::sqrt(sum_sq / static_cast<double>(std::max<std::size_t>(1, residual.samples)));
      residual.current_a = load_s > 0.0 ? load_as / load_s : 0.0;
    }
  }
  return residuals;
}

}  // namespace cosiva::battery
