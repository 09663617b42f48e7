#include "cosiva/experiments/positioning/metrology/metrics.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/base/math.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

double mean_square(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += v * v;
  return sum / static_cast<double>(values.size());
}

/// In two dimensions: 1 − e^(−x/2) = p.
double region_limit(double ratio) { return -2.0 * det_log(1.0 - ratio); }

/// The number of edges below the value: without a search, whose branches are unpredictable.
std::size_t bin_of(double since_m) {
  std::size_t bin = 0;
  for (const double edge : since_fiducial_m) bin += edge < since_m ? 1 : 0;
  return bin;
}

}  // namespace

double Part::rmse_m() const {
  if (iterations == 0) return std::numeric_limits<double>::quiet_NaN();
  return std::sqrt(squares_m2 / static_cast<double>(iterations));
}

RunMetrics metrics_of(const Trial& trial, const Trace& trace, double threshold_m) {
  RunMetrics metrics;
  metrics.iterations = trace.error_m.size();
  if (trace.error_m.empty()) return metrics;
  metrics.mean_m = statistics::mean(trace.error_m);
  metrics.mse_m2 = mean_square(trace.error_m);
  metrics.variance_m2 = std::fmax(0.0, metrics.mse_m2 - metrics.mean_m * metrics.mean_m);
  metrics.precision = statistics::ratio_below(trace.error_m, threshold_m);
  metrics.max_m = *std::ranges::max_element(trace.error_m);
  metrics.along_mse_m2 = mean_square(trace.along_m);
  metrics.along_bias_m = statistics::mean(trace.along_m);
  metrics.across_mse_m2 = mean_square(trace.across_m);
  metrics.across_bias_m = statistics::mean(trace.across_m);
  metrics.heading_mse_rad2 =
      trial.heading_known ? mean_square(trace.heading_rad) : std::numeric_limits<double>::quiet_NaN();
  metrics.nees = statistics::mean(trace.nees);
  for (std::size_t i = 0; i < region_ratios.size(); ++i)
    metrics.covered[i] = std::isfinite(metrics.nees)
                             ? statistics::ratio_below(trace.nees, region_limit(region_ratios[i]))
                             : std::numeric_limits<double>::quiet_NaN();
  metrics.nis = statistics::mean(trace.nis);
  metrics.nis_dimensions = trace.nis_dimensions;
  metrics.refused = trace.refused;
  for (std::size_t i = 0; i < trial.moments.size(); ++i) {
    const Moment& moment = trial.moments[i];
    metrics.by_distance[bin_of(moment.since_fiducial_m)].add(trace.error_m[i]);
    if (moment.section) metrics.by_section[static_cast<std::size_t>(*moment.section)].add(trace.error_m[i]);
  }
  return metrics;
}

double worth_of(const std::vector<double>& series) {
  constexpr std::size_t most = 2000;
  if (series.size() <= most) return statistics::effective_size(series);
  const std::size_t stride = (series.size() + most - 1) / most;
  std::vector<double> thinned;
  for (std::size_t i = 0; i < series.size(); i += stride) thinned.push_back(series[i]);
  return statistics::effective_size(thinned);
}

}  // namespace cosiva::experiments
