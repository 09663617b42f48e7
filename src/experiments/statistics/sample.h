#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cosiva::statistics {

/// NaN of nothing.
[[nodiscard]] double mean(std::span<const double> values);
/// About the mean, over n: the article's variance of a run's errors, which are all there are. NaN of nothing.
[[nodiscard]] double variance(std::span<const double> values);
/// Over n − 1: of runs, which stand for others. NaN of fewer than two.
[[nodiscard]] double sample_variance(std::span<const double> values);
[[nodiscard]] double root_mean_square(std::span<const double> values);
/// The article's precision: the share of values under a threshold.
[[nodiscard]] double ratio_below(std::span<const double> values, double threshold);

/// The smallest value that at least a share p of all do not exceed: an order statistic, no interpolation and no normal
/// distribution. The values are put in another order.
/// @param p  in (0, 1]
[[nodiscard]] double percentile(std::span<double> values, double p);
/// Several of them, the largest first (checked): each looks only among those that the one before it left below.
[[nodiscard]] std::vector<double> percentiles(std::span<double> values, std::span<const double> falling);
[[nodiscard]] std::vector<double> percentiles(std::span<float> values, std::span<const double> falling);

/// Points of the empirical distribution, at most `points`, evenly spaced in share: for drawing.
struct Cdf {
  std::vector<double> value;
  std::vector<double> ratio;
};
[[nodiscard]] Cdf cdf(std::vector<double> values, std::size_t points = 200);

/// How many independent values a series is worth whose neighbours are alike: n/τ, τ = 1 + 2·Σρ by Geyer's initial
/// positive sequence (C. J. Geyer, Practical Markov Chain Monte Carlo, Statistical Science 7, 1992). In [1, n].
[[nodiscard]] double effective_size(std::span<const double> series);

}  // namespace cosiva::statistics
