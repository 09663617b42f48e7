#pragma once

#include <cstddef>
#include <span>
#include <vector>

namespace cosiva::statistics {

/// NaN without values.
[[nodiscard]] double mean(std::span<const double> values);
/// About the mean, over n: the article's variance of a run's errors, which are a complete population. NaN without
/// values.
[[nodiscard]] double variance(std::span<const double> values);
/// Over n − 1: of runs, which are a sample. NaN for fewer than two.
[[nodiscard]] double sample_variance(std::span<const double> values);
[[nodiscard]] double root_mean_square(std::span<const double> values);
/// The article's precision: the ratio of values below a threshold.
[[nodiscard]] double ratio_below(std::span<const double> values, double threshold);

/// The smallest value that at least a ratio p of all values do not exceed: an order statistic, no interpolation and no
/// normal distribution. The values are reordered.
/// @param p  in (0, 1]
[[nodiscard]] double percentile(std::span<double> values, double p);
/// Several percentiles, the largest first (checked): each searches only among the values below the previous one.
[[nodiscard]] std::vector<double> percentiles(std::span<double> values, std::span<const double> falling);
[[nodiscard]] std::vector<double> percentiles(std::span<float> values, std::span<const double> falling);

/// Points of the empirical distribution, at most `points`, evenly spaced in ratio: for drawing.
struct Cdf {
  std::vector<double> value;
  std::vector<double> ratio;
};
[[nodiscard]] Cdf cdf(std::vector<double> values, std::size_t points = 200);

/// The number of independent values equivalent to a series with correlated neighbours: n/τ, τ = 1 + 2·Σρ by Geyer's
/// initial positive sequence (C. J. Geyer, Practical Markov Chain Monte Carlo, Statistical Science 7, 1992). In [1, n].
[[nodiscard]] double effective_size(std::span<const double> series);

}  // namespace cosiva::statistics
