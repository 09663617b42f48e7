#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace cosiva::experiments {

/// The metrics of one algorithm in one run. NaN: the metric does not exist.
struct Vote {
  double mse_m2{};  ///< of the distance to the ground truth
  double mean_m{};  ///< of that distance
  double p95_m{};   ///< 95 % of iterations had no larger error: an order statistic
  double max_m{};
  double precision{};  ///< the article's: the ratio of iterations with an error below the threshold
  double covered{};    ///< the ratio of iterations whose stated 95 % region contained the ground truth
  double nees{};       ///< mean; 2 where the stated covariance is realistic
  double limit_m2{};   ///< mean squared error that no algorithm can surpass with this run's readings
  double refused{};    ///< readings that the algorithm rejected
};
inline constexpr std::array vote_fields{&Vote::mse_m2,  &Vote::mean_m, &Vote::p95_m,    &Vote::max_m,  &Vote::precision,
                                        &Vote::covered, &Vote::nees,   &Vote::limit_m2, &Vote::refused};

/// Spacing of the fiducials in an environment, on average and at worst, along the path.
struct FiducialsFound {
  double spacing_m{};         ///< distance per fiducial; NaN without fiducials
  double longest_unread_m{};  ///< longest distance from one fiducial to the next; NaN without fiducials
};

/// The result of a unit of work.
struct UnitRecord {
  std::size_t unit{};
  FiducialsFound fiducials;
  std::vector<Vote> votes;  ///< run by run, and in each run by algorithm
};

}  // namespace cosiva::experiments
