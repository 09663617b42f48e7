#include "cosiva/experiments/statistics/tolerance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/statistics/distributions.h"
#include "cosiva/experiments/statistics/sample.h"
#include "cosiva/experiments/statistics/special.h"

namespace cosiva::statistics {
namespace {

double count_of(std::span<const double> values) { return static_cast<double>(values.size()); }
double both_sided_t(double level, double degrees) { return student_quantile(0.5 + 0.5 * level, degrees); }

}  // namespace

std::optional<Interval> mean_interval(std::span<const double> values, double level) {
  if (values.size() < 2) return std::nullopt;
  const double n = count_of(values);
  const double half = both_sided_t(level, n - 1.0) * std::sqrt(sample_variance(values) / n);
  return Interval{mean(values) - half, mean(values) + half};
}

std::optional<Interval> deviation_interval(std::span<const double> values, double level) {
  if (values.size() < 2) return std::nullopt;
  const double degrees = count_of(values) - 1.0;
  const double squares = sample_variance(values) * degrees;
  return Interval{std::sqrt(squares / chi_squared_quantile(0.5 + 0.5 * level, degrees)),
                  std::sqrt(squares / chi_squared_quantile(0.5 - 0.5 * level, degrees))};
}

std::optional<Interval> prediction_interval(std::span<const double> values, double level) {
  if (values.size() < 2) return std::nullopt;
  const double n = count_of(values);
  const double half = both_sided_t(level, n - 1.0) * std::sqrt(sample_variance(values) * (1.0 + 1.0 / n));
  return Interval{mean(values) - half, mean(values) + half};
}

double tolerance_factor(std::size_t n, double covered, double confidence) {
  COSIVA_EXPECT(n >= 2);
  const double root = std::sqrt(static_cast<double>(n));
  return shifted_student_quantile(confidence, static_cast<double>(n - 1), normal_quantile(covered) * root) / root;
}

double ratio_above_smallest(std::size_t n, double confidence) {
  COSIVA_EXPECT(n > 0);
  return det_exp(det_log(1.0 - confidence) / static_cast<double>(n));
}

std::size_t sample_size(double relative_sd, double relative_half_width, double level) {
  COSIVA_EXPECT(relative_sd >= 0.0 && relative_half_width > 0.0);
  constexpr std::size_t most = 1'000'000;
  const auto is_enough = [&](std::size_t n) {
    const auto count = static_cast<double>(n);
    return both_sided_t(level, count - 1.0) * relative_sd / std::sqrt(count) <= relative_half_width;
  };
  std::size_t high = 2;
  while (high < most && !is_enough(high)) high *= 2;
  std::size_t low = 1;
  high = std::min(high, most);
  while (high - low > 1) {
    const std::size_t centre = low + (high - low) / 2;
    (centre >= 2 && is_enough(centre) ? high : low) = centre;
  }
  return high;
}

std::optional<std::size_t> stops_at(std::span<const double> values, double relative_half_width, std::size_t least,
                                    double level) {
  for (std::size_t n = std::max<std::size_t>(2, least); n <= values.size(); ++n) {
    const auto some = values.first(n);
    const auto count = static_cast<double>(n);
    const double centre = mean(some);
    // 1/n in units of the squared requested width: prevents stopping at the first values, which may be narrow by
    // chance.
    const double wanted = relative_half_width * std::fabs(centre);
    const double variance = sample_variance(some) + wanted * wanted / count;
    if (both_sided_t(level, count - 1.0) * std::sqrt(variance / count) <= wanted) return n;
  }
  return std::nullopt;
}

std::optional<Outlier> grubbs(std::span<const double> values, double level) {
  const double n = count_of(values);
  if (values.size() < 3) return std::nullopt;
  const double sd = std::sqrt(sample_variance(values));
  if (!(sd > 0.0)) return std::nullopt;
  const double centre = mean(values);
  Outlier found{0, 0.0, 0.0, false};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double distance = std::fabs(values[i] - centre) / sd;
    if (distance > found.statistic) found = {i, distance, 0.0, false};
  }
  const double t = student_quantile(1.0 - level / (2.0 * n), n - 2.0);
  found.critical = (n - 1.0) / std::sqrt(n) * std::sqrt(t * t / (n - 2.0 + t * t));
  found.is_outlier = found.statistic > found.critical;
  return found;
}

double median(std::span<const double> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::vector<double> sorted{values.begin(), values.end()};
  std::ranges::sort(sorted);
  const std::size_t half = sorted.size() / 2;
  return sorted.size() % 2 == 1 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

std::vector<double> robust_scores(std::span<const double> values) {
  const double centre = median(values);
  std::vector<double> distances;
  for (const double value : values) distances.push_back(std::fabs(value - centre));
  const double scale = 1.4826 * median(distances);
  std::vector<double> scores;
  for (const double value : values) scores.push_back(scale > 0.0 ? (value - centre) / scale : 0.0);
  return scores;
}

std::optional<double> normality_p(std::span<const double> values) {
  if (values.size() < 8) return std::nullopt;
  const double sd = std::sqrt(sample_variance(values));
  if (!(sd > 0.0)) return std::nullopt;
  const double n = count_of(values);
  const double centre = mean(values);
  std::vector<double> sorted{values.begin(), values.end()};
  std::ranges::sort(sorted);
  double sum = 0.0;
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    const double low = std::max(normal_cdf((sorted[i] - centre) / sd), 1e-300);
    const double high = std::max(normal_cdf(-(sorted[sorted.size() - 1 - i] - centre) / sd), 1e-300);
    sum += (2.0 * static_cast<double>(i) + 1.0) * (det_log(low) + det_log(high));
  }
  const double a = (-n - sum / n) * (1.0 + 0.75 / n + 2.25 / (n * n));
  if (a < 0.2) return 1.0 - det_exp(-13.436 + 101.14 * a - 223.73 * a * a);
  if (a < 0.34) return 1.0 - det_exp(-8.318 + 42.796 * a - 59.938 * a * a);
  if (a < 0.6) return det_exp(0.9177 - 4.279 * a - 1.38 * a * a);
  return a > 13.0 ? 0.0 : det_exp(1.2937 - 5.709 * a + 0.0186 * a * a);
}

}  // namespace cosiva::statistics
