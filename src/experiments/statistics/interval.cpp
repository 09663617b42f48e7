#include "cosiva/experiments/statistics/interval.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/random.h"
#include "cosiva/experiments/statistics/distributions.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::statistics {
namespace {

/// Skewness over six of the runs' contributions, by the jackknife: how the spread changes with the metric.
double acceleration(std::span<const double> runs) {
  const double centre = mean(runs);
  double squares = 0.0;
  double cubes = 0.0;
  for (const double v : runs) {
    squares += (v - centre) * (v - centre);
    cubes += (v - centre) * (v - centre) * (v - centre);
  }
  return squares == 0.0 ? 0.0 : cubes / (6.0 * squares * std::sqrt(squares));
}

/// The quantile of sorted values, interpolated between ranks.
double at_ratio(const std::vector<double>& sorted, double ratio) {
  const double location =
      std::clamp(ratio * (static_cast<double>(sorted.size()) + 1.0) - 1.0, 0.0, static_cast<double>(sorted.size() - 1));
  const auto low = static_cast<std::size_t>(location);
  const std::size_t high = std::min(low + 1, sorted.size() - 1);
  return sorted[low] + (location - std::floor(location)) * (sorted[high] - sorted[low]);
}

double ratio_of(const std::vector<double>& sorted, double value) {
  const auto below = std::ranges::lower_bound(sorted, value) - sorted.begin();
  const auto equal = std::ranges::upper_bound(sorted, value) - sorted.begin() - below;
  const auto n = static_cast<double>(sorted.size());
  return std::clamp((static_cast<double>(below) + 0.5 * static_cast<double>(equal)) / n, 0.5 / n, 1.0 - 0.5 / n);
}

Interval mapped(double low, double high, Of of) {
  if (of == nullptr) return {low, high};
  return {of(low), of(high)};
}

}  // namespace

std::optional<Interval> bca(std::span<const double> runs, const BootstrapOptions& options, Of of) {
  const std::size_t n = runs.size();
  if (n < 2) return std::nullopt;
  Random random{options.seed, "statistics/bca"};
  // Many runs are nearly Gaussian, and need no more than a thousand resamples.
  std::vector<double> means(n > 200 ? std::min<std::size_t>(options.resamples, 1000) : options.resamples);
  for (double& m : means) {
    double sum = 0.0;
    for (std::size_t i = 0; i < n; ++i) sum += runs[random.below(n)];
    m = sum / static_cast<double>(n);
  }
  std::ranges::sort(means);
  const auto count = static_cast<double>(n);
  // A sample's own spread is too small by √((n−1)/n), and its tails are Student's.
  const double wide = std::sqrt(count / (count - 1.0)) * student_quantile(0.5 + 0.5 * options.level, count - 1.0);
  const double bias = normal_quantile(ratio_of(means, mean(runs)));
  const double a = acceleration(runs);
  const auto end = [&](double z) {
    const double shifted = bias + z;
    return at_ratio(means, normal_cdf(bias + shifted / (1.0 - a * shifted)));
  };
  return mapped(end(-wide), end(wide), of);
}

std::optional<BlockInterval> block_bootstrap(std::span<const double> series, const BootstrapOptions& options, Of of) {
  const std::size_t n = series.size();
  const double worth = effective_size(series);
  if (n < 8 || worth < 4.0) return std::nullopt;
  const auto block = std::clamp<std::size_t>(static_cast<std::size_t>(3.0 * static_cast<double>(n) / worth), 1, n / 2);
  // Sums of all circular blocks, computed once.
  std::vector<double> sums(n);
  double sum = 0.0;
  for (std::size_t i = 0; i < block; ++i) sum += series[i];
  for (std::size_t i = 0; i < n; ++i) {
    sums[i] = sum;
    sum += series[(i + block) % n] - series[i];
  }
  const std::size_t blocks = (n + block - 1) / block;
  Random random{options.seed, "statistics/blocks"};
  std::vector<double> means(options.resamples);
  for (double& m : means) {
    double total = 0.0;
    for (std::size_t b = 0; b < blocks; ++b) total += sums[random.below(n)];
    m = total / static_cast<double>(blocks * block);
  }
  std::ranges::sort(means);
  const double degrees = std::fmax(static_cast<double>(blocks) - 1.0, 1.0);
  const double ratio = normal_cdf(-student_quantile(0.5 + 0.5 * options.level, degrees));
  return BlockInterval{mapped(at_ratio(means, ratio), at_ratio(means, 1.0 - ratio), of), worth, block};
}

}  // namespace cosiva::statistics
