#include "cosiva/experiments/positioning/campaign/summary.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/statistics/distributions.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double root(double v) { return std::sqrt(std::fmax(v, 0.0)); }

/// The votes of a pool of environments, run by run: a run is one vote, however many environments it was in.
struct Pool {
  std::vector<double> mse_m2;
  std::vector<double> p95_m;
  std::vector<double> limit_m2;
};

Pool pool_of(const Votes& votes, const std::vector<std::size_t>& environments, std::size_t runs,
             std::size_t algorithm) {
  Pool pool;
  const auto n = static_cast<double>(environments.size());
  for (std::size_t run = 0; run < runs; ++run) {
    double mse = 0.0;
    double p95 = 0.0;
    double limit = 0.0;
    for (const std::size_t environment : environments) {
      const Vote& vote = votes.of(environment, run, algorithm);
      mse += vote.mse_m2 / n;
      p95 += vote.p95_m / n;
      limit += vote.limit_m2 / n;
    }
    pool.mse_m2.push_back(mse);
    pool.p95_m.push_back(p95);
    pool.limit_m2.push_back(limit);
  }
  return pool;
}

Figure evaluated_of(const Pool& pool, EvaluatedQuantity evaluated, const statistics::BootstrapOptions& bootstrap) {
  if (evaluated == EvaluatedQuantity::p95)
    return {statistics::mean(pool.p95_m), statistics::bca(pool.p95_m, bootstrap)};
  return {root(statistics::mean(pool.mse_m2)), statistics::bca(pool.mse_m2, bootstrap, root)};
}

/// Whether a cell is below the limit by more than chance would cause in one of a hundred campaigns of this number of
/// cells.
bool leaks(const Pool& pool, std::size_t cells) {
  const std::size_t n = pool.mse_m2.size();
  if (n < 3) return false;
  std::vector<double> below;
  for (std::size_t i = 0; i < n; ++i) below.push_back(pool.limit_m2[i] - pool.mse_m2[i]);
  const double error = std::sqrt(statistics::sample_variance(below) / static_cast<double>(n));
  const double t = statistics::student_quantile(1.0 - 0.01 / static_cast<double>(cells), static_cast<double>(n - 1));
  return statistics::mean(below) > t * error;
}

CellMetrics cell_of(const CampaignWork& work, const Votes& votes, std::size_t environment, std::size_t algorithm) {
  const CampaignPlan& plan = work.plan();
  CellMetrics cell;
  cell.environment = environment;
  cell.algorithm = algorithm;
  cell.fiducials = votes.fiducials(environment);
  const Pool pool = pool_of(votes, {environment}, plan.runs, algorithm);
  const statistics::BootstrapOptions bootstrap{0.95, 2000, plan.seed};
  cell.rmse_m = evaluated_of(pool, EvaluatedQuantity::rmse, bootstrap);
  cell.p95_m = evaluated_of(pool, EvaluatedQuantity::p95, bootstrap);
  cell.limit_m = root(statistics::mean(pool.limit_m2));
  cell.gap_percent = 100.0 * (cell.rmse_m.value / cell.limit_m - 1.0);
  cell.leak = leaks(pool, plan.cells());
  const double n = plan.runs;
  for (std::size_t run = 0; run < plan.runs; ++run) {
    const Vote& vote = votes.of(environment, run, algorithm);
    cell.mean_m += vote.mean_m / n;
    cell.max_m = std::fmax(cell.max_m, vote.max_m);
    cell.precision += vote.precision / n;
    cell.covered += vote.covered / n;
    cell.nees += vote.nees / n;
    cell.refused += vote.refused;
  }
  return cell;
}

/// The environments of a selection, in order.
std::vector<std::size_t> environments_of(const CampaignPlan& plan, const Selection& selection) {
  std::vector<std::size_t> all{0};
  for (std::size_t i = 0; i < swept_count; ++i) {
    const std::size_t values = plan.values[i].size();
    std::vector<std::size_t> more;
    for (const std::size_t one : all)
      for (std::size_t k = selection[i].value_or(0); k < (selection[i] ? *selection[i] + 1 : values); ++k)
        more.push_back(one * values + k);
    all = std::move(more);
  }
  return all;
}

constexpr bool is_placement(Swept swept) {
  return swept == Swept::pitch || swept == Swept::rotation || swept == Swept::origin_x || swept == Swept::origin_y;
}

/// All combinations of the factors that do not define the positions of beacons.
std::vector<Selection> surroundings(const CampaignPlan& plan) {
  std::vector<Selection> all{Selection{}};
  for (std::size_t i = 0; i < swept_count; ++i) {
    if (is_placement(static_cast<Swept>(i))) continue;
    std::vector<Selection> more;
    for (const Selection& one : all) {
      for (std::size_t k = 0; k < plan.values[i].size(); ++k) {
        more.push_back(one);
        more.back()[i] = k;
      }
    }
    all = std::move(more);
  }
  return all;
}

std::vector<double> column(const Curve& curve, double (*get)(const Figure&)) {
  std::vector<double> values;
  for (const Figure& y : curve.y) values.push_back(get(y));
  return values;
}

PitchMet pitch_met(const CampaignWork& work, const std::vector<UnitRecord>& records, const Selection& at,
                   std::size_t algorithm) {
  const CampaignPlan& plan = work.plan();
  const Curve curve = curve_of(work, records, Swept::pitch, algorithm, at);
  const auto crossing = [&](const std::vector<double>& y) { return crossing_of(curve.x, y, plan.tolerance_m); };
  PitchMet met{at, algorithm, {}, {}, {}, {}, {}};
  met.pitch = crossing(column(curve, [](const Figure& y) { return y.value; }));
  if (curve.y.front().interval) {
    met.low = crossing(column(curve, [](const Figure& y) { return y.interval ? y.interval->high : y.value; }));
    met.high = crossing(column(curve, [](const Figure& y) { return y.interval ? y.interval->low : y.value; }));
  }
  met.worst = crossing(curve.worst);
  if (plan.evaluated == EvaluatedQuantity::rmse) met.limit = crossing(curve.limit);
  return met;
}

std::string digest_of(const CampaignWork& work, const std::vector<UnitRecord>& records) {
  Digest digest;
  digest.add(work.identity());
  for (const UnitRecord& record : records) {
    digest.add(std::uint64_t{record.unit});
    for (const Vote& vote : record.votes)
      for (const auto field : vote_fields) {
        // One bit pattern for every kind of NaN.
        const double value = vote.*field;
        digest.add(std::isnan(value) ? nan : value);
      }
  }
  return digest.hex();
}

}  // namespace

const Vote& Votes::of(std::size_t environment, std::size_t run, std::size_t algorithm) const {
  const UnitRecord& record = records_[work_.unit_of(environment, run)];
  const std::size_t first = work_.unit(record.unit).first_run;
  return record.votes[(run - first) * work_.plan().algorithms.size() + algorithm];
}

const FiducialsFound& Votes::fiducials(std::size_t environment) const {
  return records_[work_.unit_of(environment, 0)].fiducials;
}

Crossing crossing_of(const std::vector<double>& x, const std::vector<double>& y, double tolerance) {
  COSIVA_EXPECT(!x.empty() && x.size() == y.size());
  // Written such that a NaN does not meet the condition.
  const auto meets = [&](double value) { return value <= tolerance; };
  if (!meets(y.front())) return {Crossing::Where::under, x.front()};
  for (std::size_t i = 1; i < x.size(); ++i) {
    if (meets(y[i])) continue;
    const bool powers = x[i - 1] > 0.0 && y[i - 1] > 0.0 && std::isfinite(y[i]);
    if (!powers) return {Crossing::Where::at, x[i - 1]};
    const double ratio = det_log(tolerance / y[i - 1]) / det_log(y[i] / y[i - 1]);
    return {Crossing::Where::at, x[i - 1] * det_exp(ratio * det_log(x[i] / x[i - 1]))};
  }
  return {Crossing::Where::over, x.back()};
}

Curve curve_of(const CampaignWork& work, const std::vector<UnitRecord>& records, Swept factor, std::size_t algorithm,
               const Selection& selection) {
  const CampaignPlan& plan = work.plan();
  const Votes votes{work, records};
  std::vector<std::vector<std::size_t>> pools(plan.of(factor).size());
  for (const std::size_t environment : environments_of(plan, selection))
    pools[plan.indices(environment)[static_cast<std::size_t>(factor)]].push_back(environment);
  const statistics::BootstrapOptions bootstrap{0.95, 2000, plan.seed};
  Curve curve;
  curve.algorithm = algorithm;
  for (std::size_t k = 0; k < pools.size(); ++k) {
    if (pools[k].empty()) continue;
    const Pool pool = pool_of(votes, pools[k], plan.runs, algorithm);
    curve.x.push_back(plan.of(factor)[k]);
    curve.y.push_back(evaluated_of(pool, plan.evaluated, bootstrap));
    curve.limit.push_back(plan.evaluated == EvaluatedQuantity::rmse ? root(statistics::mean(pool.limit_m2)) : nan);
    double worst = 0.0;
    double spacing_m = 0.0;
    for (const std::size_t environment : pools[k]) {
      const Pool cell = pool_of(votes, {environment}, plan.runs, algorithm);
      worst = std::fmax(worst, plan.evaluated == EvaluatedQuantity::p95 ? statistics::mean(cell.p95_m)
                                                                        : root(statistics::mean(cell.mse_m2)));
      spacing_m += votes.fiducials(environment).spacing_m / static_cast<double>(pools[k].size());
    }
    curve.worst.push_back(worst);
    curve.spacing_m.push_back(spacing_m);
  }
  return curve;
}

CampaignSummary sum_up(const CampaignWork& work, const std::vector<UnitRecord>& records, Workers& workers) {
  COSIVA_EXPECT(records.size() == work.units());
  const CampaignPlan& plan = work.plan();
  const std::size_t algorithms = plan.algorithms.size();
  const Votes votes{work, records};
  CampaignSummary summary;
  summary.digest = digest_of(work, records);
  summary.cells.resize(plan.cells());
  workers.for_each(plan.cells(),
                   [&](std::size_t i) { summary.cells[i] = cell_of(work, votes, i / algorithms, i % algorithms); });
  for (const CellMetrics& cell : summary.cells) summary.leaks += cell.leak ? 1 : 0;
  if (plan.of(Swept::pitch).size() < 2) return summary;
  const std::vector<Selection> around = surroundings(plan);
  summary.pitches_met.resize(around.size() * algorithms);
  workers.for_each(summary.pitches_met.size(), [&](std::size_t i) {
    summary.pitches_met[i] = pitch_met(work, records, around[i / algorithms], i % algorithms);
  });
  return summary;
}

}  // namespace cosiva::experiments
