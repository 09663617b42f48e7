#include "cosiva/experiments/statistics/sample.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/base/expect.h"

namespace cosiva::statistics {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

double squares_about(std::span<const double> values, double centre) {
  double sum = 0.0;
  for (const double v : values) sum += (v - centre) * (v - centre);
  return sum;
}

template <typename Number>
std::vector<double> order_statistics(std::span<Number> values, std::span<const double> falling) {
  std::vector<double> found;
  std::size_t among = values.size();
  for (const double p : falling) {
    COSIVA_EXPECT(p > 0.0 && p <= 1.0);
    if (values.empty()) {
      found.push_back(nan);
      continue;
    }
    // A ratio such as 0.9 of 10 must be 9 values, not 10 because 0.9 is slightly larger in binary.
    const double wanted = p * static_cast<double>(values.size());
    const auto rank = std::max<std::size_t>(static_cast<std::size_t>(std::ceil(wanted - 1e-9)), 1);
    COSIVA_EXPECT(rank <= among);
    const auto at = values.begin() + static_cast<std::ptrdiff_t>(rank - 1);
    std::nth_element(values.begin(), at, values.begin() + static_cast<std::ptrdiff_t>(among));
    found.push_back(double{*at});
    among = rank;
  }
  return found;
}

}  // namespace

double mean(std::span<const double> values) {
  if (values.empty()) return nan;
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

double variance(std::span<const double> values) {
  if (values.empty()) return nan;
  return squares_about(values, mean(values)) / static_cast<double>(values.size());
}

double sample_variance(std::span<const double> values) {
  if (values.size() < 2) return nan;
  return squares_about(values, mean(values)) / static_cast<double>(values.size() - 1);
}

double root_mean_square(std::span<const double> values) {
  if (values.empty()) return nan;
  return std::sqrt(squares_about(values, 0.0) / static_cast<double>(values.size()));
}

double ratio_below(std::span<const double> values, double threshold) {
  if (values.empty()) return nan;
  const auto below = std::ranges::count_if(values, [&](double v) { return v < threshold; });
  return static_cast<double>(below) / static_cast<double>(values.size());
}

double percentile(std::span<double> values, double p) { return percentiles(values, {&p, 1}).front(); }

std::vector<double> percentiles(std::span<double> values, std::span<const double> falling) {
  return order_statistics(values, falling);
}

std::vector<double> percentiles(std::span<float> values, std::span<const double> falling) {
  return order_statistics(values, falling);
}

Cdf cdf(std::vector<double> values, std::size_t points) {
  std::ranges::sort(values);
  Cdf result;
  const std::size_t n = values.size();
  const std::size_t count = std::min(points, n);
  for (std::size_t i = 1; i <= count; ++i) {
    const std::size_t rank = i * n / count;
    result.value.push_back(values[rank - 1]);
    result.ratio.push_back(static_cast<double>(rank) / static_cast<double>(n));
  }
  return result;
}

double effective_size(std::span<const double> series) {
  const std::size_t n = series.size();
  if (n < 4) return static_cast<double>(n);
  const double centre = mean(series);
  const double all = squares_about(series, centre);
  if (all == 0.0) return 1.0;
  const auto correlation = [&](std::size_t lag) {
    double sum = 0.0;
    for (std::size_t i = 0; i + lag < n; ++i) sum += (series[i] - centre) * (series[i + lag] - centre);
    return sum / all;
  };
  // The true sums of neighbouring pairs decrease and stay positive; from where the estimates do not, they are noise.
  double tau = -1.0;
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t lag = 0; lag + 1 < n; lag += 2) {
    const double pair = std::fmin(correlation(lag) + correlation(lag + 1), least);
    if (pair <= 0.0) break;
    least = pair;
    tau += 2.0 * pair;
  }
  return std::clamp(static_cast<double>(n) / std::fmax(tau, 1.0), 1.0, static_cast<double>(n));
}

}  // namespace cosiva::statistics
