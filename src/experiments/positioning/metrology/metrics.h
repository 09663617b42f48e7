#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "cosiva/experiments/positioning/metrology/trial.h"

namespace cosiva::experiments {

/// How sums of squares are kept where they are split: by section kind, by distance.
struct Part {
  double squares_m2{};
  std::size_t iterations{};
  [[nodiscard]] double rmse_m() const;  ///< NaN of nothing
  void add(double error_m) {
    squares_m2 += error_m * error_m;
    ++iterations;
  }
  void add(const Part& other) {
    squares_m2 += other.squares_m2;
    iterations += other.iterations;
  }
};

/// Stated regions: within which of these shares the truth should lie.
inline constexpr std::array region_ratios{0.50, 0.90, 0.95};
/// Splits by the distance since the last mark: up to each of these, and beyond the last [m].
inline constexpr std::array since_fiducial_m{0.1, 0.25, 0.5, 1.0, 2.0, 4.0};

/// What one algorithm is worth in one run: the run's vote.
struct RunMetrics {
  std::size_t iterations{};
  double mean_m{};       ///< of the distance to the truth
  double variance_m2{};  ///< about that mean, over all iterations: the article's
  double mse_m2{};
  double precision{};  ///< the article's: the share of iterations with an error under the threshold
  double max_m{};
  double along_mse_m2{}, along_bias_m{};
  double across_mse_m2{}, across_bias_m{};
  double heading_mse_rad2{};
  double nees{};  ///< mean; 2 where the stated covariance is honest
  std::array<double, region_ratios.size()> covered{};
  double nis{};                  ///< mean per dimension; 1 where innovations are as large as expected. NaN of none
  std::size_t nis_dimensions{};  ///< that this is the mean of
  std::size_t refused{};
  std::array<Part, 3> by_section{};  ///< straight, arc, clothoid
  std::array<Part, since_fiducial_m.size() + 1> by_distance{};
};
[[nodiscard]] RunMetrics metrics_of(const Trial& trial, const Trace& trace, double threshold_m);

/// How many independent values a run's errors are worth; long series are thinned for it.
[[nodiscard]] double worth_of(const std::vector<double>& series);

}  // namespace cosiva::experiments
