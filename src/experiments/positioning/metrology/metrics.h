#pragma once

#include <array>
#include <cstddef>
#include <vector>

#include "cosiva/experiments/positioning/metrology/trial.h"

namespace cosiva::experiments {

/// Sums of squares for a split: by section kind, by distance.
struct Part {
  double squares_m2{};
  std::size_t iterations{};
  [[nodiscard]] double rmse_m() const;  ///< NaN without values
  void add(double error_m) {
    squares_m2 += error_m * error_m;
    ++iterations;
  }
  void add(const Part& other) {
    squares_m2 += other.squares_m2;
    iterations += other.iterations;
  }
};

/// Stated regions: the ratios within which the ground truth should lie.
inline constexpr std::array region_ratios{0.50, 0.90, 0.95};
/// Splits by the distance since the last fiducial: up to each of these, and beyond the last [m].
inline constexpr std::array since_fiducial_m{0.1, 0.25, 0.5, 1.0, 2.0, 4.0};

/// The metrics of one algorithm in one run: the run's vote.
struct RunMetrics {
  std::size_t iterations{};
  double mean_m{};       ///< of the distance to the ground truth
  double variance_m2{};  ///< about that mean, over all iterations: the article's variance
  double mse_m2{};
  double precision{};  ///< the article's: the ratio of iterations with an error below the threshold
  double max_m{};
  double along_mse_m2{}, along_bias_m{};
  double across_mse_m2{}, across_bias_m{};
  double heading_mse_rad2{};
  double nees{};  ///< mean; 2 where the stated covariance is realistic
  std::array<double, region_ratios.size()> covered{};
  double nis{};  ///< mean per dimension; 1 where innovations are as large as expected. NaN without innovations
  std::size_t nis_dimensions{};  ///< number of dimensions in the mean
  std::size_t refused{};
  std::array<Part, 4> by_section{};  ///< by zone::SectionKind
  std::array<Part, since_fiducial_m.size() + 1> by_distance{};
};
[[nodiscard]] RunMetrics metrics_of(const Trial& trial, const Trace& trace, double threshold_m);

/// The number of independent values equivalent to a run's errors; long series are thinned for it.
[[nodiscard]] double worth_of(const std::vector<double>& series);

}  // namespace cosiva::experiments
