#include "cosiva/experiments/positioning/metrology/qualification.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/base/expect.h"
#include "cosiva/experiments/positioning/metrology/comparing.h"
#include "cosiva/experiments/positioning/metrology/evaluation.h"
#include "cosiva/experiments/statistics/distributions.h"

namespace cosiva::experiments {
namespace {

double root(double v) { return std::sqrt(std::fmax(v, 0.0)); }

/// Values that are collected during the runs.
struct Gathered {
  std::vector<float> errors_m;  ///< all of them
  std::vector<double> below_limit_m2;
  double filter_limit_m2{};
  double smoother_limit_m2{};
  double worth_sum{};
  double nees_worth_sum{};
  std::size_t worth_runs{};
  std::vector<double> first_squares_m2;
};

template <typename Get>
std::vector<double> column(const std::vector<RunMetrics>& runs, const Get& get) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const RunMetrics& run : runs) values.push_back(get(run));
  return values;
}

/// Gathers the metrics of all candidates, run by run.
///
/// Invariant: the runs are taken in their order, so that the digest covers it.
class Qualifying {
 public:
  Qualifying(const std::vector<Candidate>& candidates, std::size_t runs, const QualificationOptions& options)
      : candidates_{candidates}, gathered_(candidates.size()) {
    result_.options = options;
    result_.runs = runs;
    for (const Candidate& candidate : candidates) {
      Qualified one;
      one.name = candidate.name;
      one.what = candidate.what;
      one.backtracks = candidate.backtracks;
      result_.algorithms.push_back(std::move(one));
    }
  }

  /// In the order of runs, and of candidates in each run: so the digest covers both.
  void take(std::size_t index, EvaluatedRun run) {
    COSIVA_EXPECT(index == taken_);
    ++taken_;
    if (index == 0) {
      result_.times_s = std::move(run.times_s);
      result_.ground_truth = std::move(run.ground_truth);
    }
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      result_.algorithms[i].limit_assumed = result_.algorithms[i].limit_assumed || run.sensors_assumed;
      if (!result_.algorithms[i].failed) take(i, index, run.algorithms[i], run.limit);
    }
  }

  Qualification done() {
    for (std::size_t i = 0; i < candidates_.size(); ++i) {
      if (!result_.algorithms[i].failed) sum_up(result_.algorithms[i], gathered_[i]);
    }
    compare_all(result_);
    return std::move(result_);
  }

 private:
  void take(std::size_t i, std::size_t index, Evaluated& evaluated, const std::optional<RunLimit>& limit) {
    Qualified& one = result_.algorithms[i];
    if (evaluated.failed) {
      one.failed = std::move(evaluated.failed);
      return;
    }
    one.runs.push_back(evaluated.metrics);
    if (evaluated.alignment) one.alignments.push_back(*evaluated.alignment);
    Gathered& all = gathered_[i];
    all.errors_m.insert(all.errors_m.end(), evaluated.errors_m.begin(), evaluated.errors_m.end());
    if (limit) {
      all.filter_limit_m2 += limit->filter_m2;
      all.smoother_limit_m2 += limit->smoother_m2;
      const double bound = one.backtracks ? limit->smoother_m2 : limit->filter_m2;
      all.below_limit_m2.push_back(one.runs.back().mse_m2 - bound);
    }
    if (index < worth_runs_most) {
      all.worth_sum += evaluated.worth;
      all.nees_worth_sum += evaluated.nees_worth;
      ++all.worth_runs;
    }
    if (index == 0) {
      one.path = std::move(evaluated.path);
      one.over_distance = std::move(evaluated.over_distance);
      all.first_squares_m2 = std::move(evaluated.squares_m2);
    }
    result_.digest.add(one.name);
    for (const double v : {one.runs.back().mse_m2, one.runs.back().mean_m, one.runs.back().nees}) result_.digest.add(v);
  }

  void sum_up(Qualified& one, Gathered& all) const {
    const auto mse = column(one.runs, [](const RunMetrics& r) { return r.mse_m2; });
    const auto means = column(one.runs, [](const RunMetrics& r) { return r.mean_m; });
    const auto precisions = column(one.runs, [](const RunMetrics& r) { return r.precision; });
    const auto& bootstrap = result_.options.bootstrap;
    one.rmse_m = {root(statistics::mean(mse)), statistics::bca(mse, bootstrap, root)};
    one.mean_m = {statistics::mean(means), statistics::bca(means, bootstrap)};
    one.precision = {statistics::mean(precisions), statistics::bca(precisions, bootstrap)};
    if (one.runs.size() == 1) {
      if (const auto block = statistics::block_bootstrap(all.first_squares_m2, bootstrap, root))
        one.rmse_m.interval = block->interval;
    }
    one.variance_m2 = std::fmax(0.0, statistics::mean(mse) - one.mean_m.value * one.mean_m.value);
    sum_up_parts(one);
    sum_up_errors(one, all);
    const auto n = static_cast<double>(one.runs.size());
    const auto looked_at = static_cast<double>(all.worth_runs);
    one.worth = all.worth_sum / looked_at * n;
    const double nees_worth = all.nees_worth_sum / looked_at * n;
    one.nees_band = {statistics::chi_squared_quantile(0.025, 2.0 * nees_worth) / nees_worth,
                     statistics::chi_squared_quantile(0.975, 2.0 * nees_worth) / nees_worth};
    set_limit(one, all);
    set_passes(one);
  }

  void sum_up_parts(Qualified& one) const {
    const auto n = static_cast<double>(one.runs.size());
    double along = 0.0;
    double across = 0.0;
    double heading = 0.0;
    double nis_runs = 0.0;
    for (const RunMetrics& run : one.runs) {
      one.iterations += run.iterations;
      one.max_m = std::fmax(one.max_m, run.max_m);
      along += run.along_mse_m2 / n;
      across += run.across_mse_m2 / n;
      heading += run.heading_mse_rad2 / n;
      one.along_bias_m += run.along_bias_m / n;
      one.across_bias_m += run.across_bias_m / n;
      one.nees += run.nees / n;
      one.refused += run.refused;
      for (std::size_t k = 0; k < region_ratios.size(); ++k) one.covered[k] += run.covered[k] / n;
      if (std::isfinite(run.nis)) {
        one.nis += run.nis;
        one.nis_dimensions += run.nis_dimensions;
        nis_runs += 1.0;
      }
      for (std::size_t k = 0; k < one.by_section.size(); ++k) one.by_section[k].add(run.by_section[k]);
      for (std::size_t k = 0; k < one.by_distance.size(); ++k) one.by_distance[k].add(run.by_distance[k]);
    }
    one.nis = nis_runs > 0.0 ? one.nis / nis_runs : std::numeric_limits<double>::quiet_NaN();
    if (one.nis_dimensions > 0) {
      const auto freedom = static_cast<double>(one.nis_dimensions);
      one.nis_band = statistics::Interval{statistics::chi_squared_quantile(0.025, freedom) / freedom,
                                          statistics::chi_squared_quantile(0.975, freedom) / freedom};
    }
    one.along_rmse_m = root(along);
    one.across_rmse_m = root(across);
    one.heading_rmse_rad = std::sqrt(heading);
  }

  static void sum_up_errors(Qualified& one, Gathered& all) {
    // A subset suffices for drawing; it is taken before the errors are reordered.
    constexpr std::size_t drawn = 50'000;
    const std::size_t stride = all.errors_m.size() / drawn + 1;
    std::vector<double> some;
    for (std::size_t i = 0; i < all.errors_m.size(); i += stride) some.push_back(double{all.errors_m[i]});
    one.cdf = statistics::cdf(std::move(some));
    const auto high = statistics::percentiles(std::span{all.errors_m}, std::array{0.99, 0.95, 0.90, 0.50});
    all.errors_m = {};
    one.p99_m = high[0];
    one.p95_m = high[1];
    one.p90_m = high[2];
    one.p50_m = high[3];
  }

  static void set_limit(Qualified& one, const Gathered& all) {
    if (all.below_limit_m2.empty()) return;
    const auto n = static_cast<double>(all.below_limit_m2.size());
    one.limit_m = root((one.backtracks ? all.smoother_limit_m2 : all.filter_limit_m2) / n);
    one.gap_percent = 100.0 * (one.rmse_m.value / *one.limit_m - 1.0);
    if (one.limit_assumed) return;
    if (n < 2.0) {
      // The interval of one run comes from its blocks.
      one.leak = one.rmse_m.interval && one.rmse_m.interval->high < *one.limit_m;
      return;
    }
    const double error = std::sqrt(statistics::sample_variance(all.below_limit_m2) / n);
    one.leak = statistics::mean(all.below_limit_m2) + 2.0 * error < 0.0;
  }

  void set_passes(Qualified& one) const {
    const QualificationOptions& options = result_.options;
    one.passes.runs = one.runs.size();
    one.passes.needed = statistics::passes_needed(options.reliability, options.confidence);
    std::size_t row = 0;
    for (const RunMetrics& run : one.runs) {
      const bool passed = run.max_m <= options.tolerance_m;
      row = passed ? row + 1 : 0;
      one.passes.passed += passed ? 1 : 0;
      one.passes.in_a_row = std::max(one.passes.in_a_row, row);
    }
    one.passes.reliability_shown = statistics::reliability_shown(one.passes.in_a_row, options.confidence);
    one.passes.tolerance_passed_m = one.max_m;
  }

  const std::vector<Candidate>& candidates_;
  std::vector<Gathered> gathered_;
  Qualification result_;
  std::size_t taken_{0};  ///< runs
};

}  // namespace

Result<Qualification> qualify(const std::vector<Candidate>& candidates, std::size_t runs, const TrialSource& source,
                              const QualificationOptions& options, Workers& workers, const TimeIsUp& time_is_up,
                              const Progress& progress) {
  auto evaluated = evaluate_all(candidates, runs, source, options, workers, time_is_up, progress);
  if (!evaluated) return tl::unexpected(evaluated.error());
  Qualifying qualifying{candidates, runs, options};
  for (std::size_t index = 0; index < runs; ++index) qualifying.take(index, std::move((*evaluated)[index]));
  return qualifying.done();
}

Result<Qualification> qualify(const std::vector<Candidate>& candidates, std::size_t runs, const TrialSource& source,
                              const QualificationOptions& options) {
  AloneWorker alone;
  return qualify(candidates, runs, source, options, alone);
}

}  // namespace cosiva::experiments
