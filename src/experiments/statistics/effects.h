#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cosiva/experiments/statistics/interval.h"

/// Causes of differences: groups, drift, and the assignment of units to carriers.
namespace cosiva::statistics {

/// One-way analysis of variance over groups of values.
struct OneFactor {
  double f;
  double p;
  double within_sd;
  double between_sd;  ///< of the groups' true means, by the method of moments; 0 where within explains it all
};
/// Nothing where there are fewer than two groups, no group with two values, or no spread within groups.
[[nodiscard]] std::optional<OneFactor> one_factor(const std::vector<std::vector<double>>& groups);

/// A straight line through values by their index in a series.
struct Trend {
  double slope;  ///< per step
  double slope_sd;
  double p;  ///< that the slope is zero, two-sided
  double r_squared;
  double at_first;  ///< the line's value at x = 1
  Interval at_first_interval;
};
/// Nothing for fewer than three points or equal x.
[[nodiscard]] std::optional<Trend> trend(std::span<const double> x, std::span<const double> y, double level = 0.95);

/// A plan of tests: in run r, unit u is tested on carrier square[r][u]. Every pair occurs once, and for even sizes
/// every carrier follows every other one once (Williams 1949), so that no unit is always tested after the same one.
[[nodiscard]] std::vector<std::vector<std::size_t>> latin_square(std::size_t size);

/// Welch's test of two means, with the size of the difference and the power of the test.
struct Comparison {
  double difference;  ///< second − first
  Interval interval;
  double t;
  double degrees;
  double p;
  double effect;  ///< Hedges's g: the difference in common standard deviations, corrected for the bias of small samples
  double power;   ///< the probability of detecting a true difference of this size at 5 %
  std::size_t needed;  ///< of each, to detect it with a probability of 80 %
};
/// Nothing where either has fewer than two values or both have no spread.
[[nodiscard]] std::optional<Comparison> compare(std::span<const double> first, std::span<const double> second,
                                                double level = 0.95);
/// The probability that a two-sided t test at 5 % detects a difference of this number of standard deviations between n1
/// and n2 values.
[[nodiscard]] double power_of(double effect, std::size_t n1, std::size_t n2, double alpha = 0.05);

}  // namespace cosiva::statistics
