#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

/// Comparisons on the same runs. A run is one vote, however many iterations it has.
namespace cosiva::statistics {

/// Wilcoxon's signed-rank test, two-sided and exact for every number of runs up to 200, ties included: the probability
/// of a sum of ranks at least as far from its centre for random signs. Equal runs (difference 0) do not count. 1 where
/// none is left. Beyond 200 the normal approximation.
[[nodiscard]] double wilcoxon(std::span<const double> differences);

/// Holm's step-down: p-values of several tests, each raised so that the probability of one false alarm among all stays
/// at the level. In the given order.
[[nodiscard]] std::vector<double> holm(std::span<const double> p_values);

/// Friedman's test over several algorithms on the same runs.
struct Friedman {
  std::vector<double> mean_ranks;  ///< 1 the smallest
  double chi_squared;
  double p;
};
/// @param metrics  metrics[run][algorithm], smaller is better
/// Nothing for fewer than two runs or two algorithms.
[[nodiscard]] std::optional<Friedman> friedman(const std::vector<std::vector<double>>& metrics);

/// The number of runs needed to show a difference like this one at a level (two-sided, Wilcoxon) with a probability of
/// 80 %; at 5 % at least 6, below which that test can show no difference. Nothing where the mean difference is 0, or
/// there are fewer than two.
/// @param level  5 % over the number of comparisons: Holm's level for the first
[[nodiscard]] std::optional<std::size_t> runs_to_decide(std::span<const double> differences, double level = 0.05,
                                                        double power = 0.8);

/// As in ASTM F45: the number of consecutive passes that show reliability R with confidence C, n = ln(1 − C)/ln R,
/// rounded up.
[[nodiscard]] std::size_t passes_needed(double reliability, double confidence);
/// The reliability that n consecutive passes show with confidence C: R = (1 − C)^(1/n).
[[nodiscard]] double reliability_shown(std::size_t passes, double confidence);

}  // namespace cosiva::statistics
