#pragma once

#include <array>
#include <cstddef>
#include <vector>

namespace cosiva::experiments {

/// What one algorithm was worth in one run. NaN: there is none.
struct Vote {
  double mse_m2{};  ///< of the distance to the truth
  double mean_m{};  ///< of it
  double p95_m{};   ///< 95 % of iterations had no larger error: an order statistic
  double max_m{};
  double precision{};  ///< the article's: the share of iterations with an error under the threshold
  double covered{};    ///< the share of iterations whose stated 95 % region held the truth
  double nees{};       ///< mean; 2 where the stated covariance is honest
  double limit_m2{};   ///< mean squared error that nobody can beat with this run's readings
  double refused{};    ///< readings that the algorithm did not take
};
inline constexpr std::array vote_fields{&Vote::mse_m2,  &Vote::mean_m, &Vote::p95_m,    &Vote::max_m,  &Vote::precision,
                                        &Vote::covered, &Vote::nees,   &Vote::limit_m2, &Vote::refused};

/// Where marks lie in an environment, on average and at worst, along the way.
struct FiducialsFound {
  double spacing_m{};         ///< way per mark; NaN where there is none
  double longest_unread_m{};  ///< from one mark to the next, at most; NaN where there is none
};

/// What came of a unit of work.
struct UnitRecord {
  std::size_t unit{};
  FiducialsFound fiducials;
  std::vector<Vote> votes;  ///< run by run, and in each run by algorithm
};

}  // namespace cosiva::experiments
