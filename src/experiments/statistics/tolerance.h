#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/experiments/statistics/interval.h"

/// Statements about a normal quantity from a sample: bounds, outliers, sizes.
namespace cosiva::statistics {

/// Interval of the mean, by Student's t. Nothing for fewer than two values.
[[nodiscard]] std::optional<Interval> mean_interval(std::span<const double> values, double level = 0.95);
/// Interval of the standard deviation, by χ², both ends at half the error. Nothing for fewer than two values.
[[nodiscard]] std::optional<Interval> deviation_interval(std::span<const double> values, double level = 0.95);
/// Prediction interval of the next single value, by Student's t. Nothing for fewer than two values.
[[nodiscard]] std::optional<Interval> prediction_interval(std::span<const double> values, double level = 0.95);

/// The factor k for which mean − k·SD of n values is, with this confidence, below this ratio of the population. Exact,
/// by the shifted t distribution: ISO 16269-6, table C. @param n  at least 2
[[nodiscard]] double tolerance_factor(std::size_t n, double covered = 0.95, double confidence = 0.95);
/// The ratio of the population that is, with this confidence, above the smallest of n values, whatever the
/// distribution.
[[nodiscard]] double ratio_above_smallest(std::size_t n, double confidence = 0.95);

/// The number of values for which the mean's interval is no wider than ± a ratio of the mean.
/// @param relative_sd  expected value; the result is from 2 to 1 000 000
[[nodiscard]] std::size_t sample_size(double relative_sd, double relative_half_width, double level = 0.95);
/// After how many of these values, in order, the interval's half width was at most the requested ratio of the mean;
/// nothing while it was not. Sequential stopping makes an interval slightly too short: with at least `least` values and
/// 1/n added to the variance (Chow and Robbins 1965) the mean is within the requested ratio in no less than 93 % of all
/// tests, and its own 95 % interval, which may be narrower, contains the mean in 92 to 93 % (bench/autonomy).
[[nodiscard]] std::optional<std::size_t> stops_at(std::span<const double> values, double relative_half_width,
                                                  std::size_t least = 5, double level = 0.95);

/// Grubbs's test, two-sided: whether the value farthest from the mean is an outlier. The value is flagged, never
/// dropped.
struct Outlier {
  std::size_t index;
  double statistic;
  double critical;
  bool is_outlier;
};
/// Nothing for fewer than three values, or where all are equal.
[[nodiscard]] std::optional<Outlier> grubbs(std::span<const double> values, double level = 0.05);
/// Each value's distance from the median over 1.4826 times the median distance (Iglewicz and Hoaglin): beyond 3.5 is
/// suspicious. Zeros where more than half are equal.
[[nodiscard]] std::vector<double> robust_scores(std::span<const double> values);
[[nodiscard]] double median(std::span<const double> values);  ///< NaN without values

/// Anderson and Darling's test of normality, Stephens's p-value for unknown mean and variance. Nothing for fewer than
/// eight values or equal ones. Source: D'Agostino and Stephens, Goodness-of-fit techniques, 1986, table 4.9.
[[nodiscard]] std::optional<double> normality_p(std::span<const double> values);

}  // namespace cosiva::statistics
