#include "cosiva/experiments/statistics/interval.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/experiments/statistics/distributions.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::statistics {
namespace {

std::vector<double> drawn(std::uint64_t seed, std::size_t n) {
  Random random{seed, "runs"};
  std::vector<double> runs(n);
  for (double& v : runs) v = random.gaussian(5.0, 2.0);
  return runs;
}

double root(double v) { return std::sqrt(v); }

TEST(Bca, contains_the_true_value_about_as_often_as_stated) {
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    const auto interval = bca(drawn(seed, 20), {0.95, 1000, seed});
    held += interval->low <= 5.0 && 5.0 <= interval->high ? 1 : 0;
  }
  // 95 % ± three standard errors of 400 campaigns.
  EXPECT_GE(held, 367);
  EXPECT_LE(held, 393);
}

TEST(Bca, contains_the_mean_of_a_skewed_sample) {
  int held = 0;
  for (std::uint64_t seed = 1; seed <= 400; ++seed) {
    Random random{seed, "skew"};
    std::vector<double> runs(30);
    for (double& v : runs) {
      const double g = random.gaussian();
      v = g * g;  // mean 1, skewness 2.8
    }
    const auto interval = bca(runs, {0.95, 1000, seed});
    held += interval->low <= 1.0 && 1.0 <= interval->high ? 1 : 0;
  }
  EXPECT_GE(held, 360);  // skewness costs a few percent, for all kinds of intervals
  EXPECT_LE(held, 395);
}

TEST(Bca, is_narrower_with_more_runs_and_wider_at_a_higher_level) {
  const auto few = *bca(drawn(1, 10));
  const auto many = *bca(drawn(1, 1000));
  EXPECT_LT(many.high - many.low, 0.3 * (few.high - few.low));
  const auto sure = *bca(drawn(1, 10), {0.99, 2000, 1});
  EXPECT_GT(sure.high - sure.low, few.high - few.low);
}

TEST(Bca, of_a_root_has_the_roots_of_its_ends) {
  const auto runs = drawn(4, 25);
  const auto plain = *bca(runs);
  const auto rooted = *bca(runs, {}, root);
  EXPECT_DOUBLE_EQ(rooted.low, std::sqrt(plain.low));
  EXPECT_DOUBLE_EQ(rooted.high, std::sqrt(plain.high));
}

TEST(Bca, is_equal_for_equal_seeds_and_nothing_for_one_run) {
  EXPECT_EQ(bca(drawn(1, 12)), bca(drawn(1, 12)));
  EXPECT_FALSE(bca(drawn(1, 1)));
}

TEST(BlockBootstrap, contains_the_mean_of_a_series_with_correlated_neighbours) {
  int held = 0;
  int naive = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random{seed, "series"};
    std::vector<double> series(4000);
    double x = 0.0;
    double sum = 0.0;
    double squares = 0.0;
    for (double& v : series) {
      v = x = 0.95 * x + random.gaussian();
      sum += v;
      squares += v * v;
    }
    const auto block = block_bootstrap(series, {0.95, 1000, seed});
    ASSERT_TRUE(block);
    held += block->interval.low <= 0.0 && 0.0 <= block->interval.high ? 1 : 0;
    const double mean = sum / 4000;
    naive += std::fabs(mean) <= 1.96 * std::sqrt(squares / 4000 / 4000) ? 1 : 0;
  }
  EXPECT_GE(held, 180);
  EXPECT_LE(naive, 80);  // the claim if every iteration counted as a vote
}

TEST(BlockBootstrap, is_nothing_for_a_series_equivalent_to_three_values) {
  std::vector<double> ramp(1000);
  for (std::size_t i = 0; i < ramp.size(); ++i) ramp[i] = static_cast<double>(i);
  EXPECT_FALSE(block_bootstrap(ramp));
  EXPECT_FALSE(block_bootstrap(std::vector<double>{1.0, 2.0, 3.0}));
}

// All 6⁶ resamples have been enumerated: with Efron's bias and acceleration and Student's width, the ends are these
// quantiles of the resampled means. The values are quarters, so that sums are exact and resamples whose mean is the
// sample's count as ties.
TEST(Bca, of_a_skewed_sample_equals_the_enumeration_of_all_resamples) {
  const std::vector<double> runs{1.0, 2.25, 3.0, 4.25, 7.75, 16.5};
  const auto wide = *bca(runs, {0.8, 100'000, 3});
  EXPECT_NEAR(wide.low, 3.1667, 0.045);  // the 10.69 % quantile
  EXPECT_NEAR(wide.high, 10.75, 0.25);   // the 98.25 % quantile
  const auto narrow = *bca(runs, {0.5, 100'000, 3});
  EXPECT_NEAR(narrow.low, 4.4583, 0.045);  // 28.94 %
  EXPECT_NEAR(narrow.high, 8.1667, 0.13);  // 85.81 %
}

TEST(Bca, of_two_runs_reaches_from_one_to_the_other) {
  EXPECT_EQ(bca(std::vector{1.0, 2.0}), (Interval{1.0, 2.0}));
  EXPECT_EQ(bca(std::vector{3.0, 3.0, 3.0}), (Interval{3.0, 3.0}));
}

TEST(Bca, takes_no_more_than_a_thousand_resamples_of_more_than_two_hundred_runs) {
  const auto runs = drawn(2, 201);
  EXPECT_EQ(bca(runs, {0.95, 5000, 9}), bca(runs, {0.95, 1000, 9}));
  EXPECT_NE(bca(runs, {0.95, 500, 9}), bca(runs, {0.95, 1000, 9}));
  const auto few = drawn(2, 50);
  EXPECT_NE(bca(few, {0.95, 5000, 9}), bca(few, {0.95, 1000, 9}));
}

// The series has 6.867 independent values by Geyer's sequence: blocks of 3·16/6.867 = 6.99, rounded down, three of
// which make one resample. All 16³ resamples have been enumerated.
TEST(BlockBootstrap, of_a_short_series_equals_the_enumeration_of_all_resamples) {
  const std::vector<double> series{5, 5, 4, 4, 1, 0, 0, 1, 2, 3, 5, 6, 4, 4, 1, 1};
  const auto half = block_bootstrap(series, {0.5, 100'000, 5});
  ASSERT_TRUE(half);
  EXPECT_NEAR(half->effective_size, 6.8668911335578, 1e-9);
  EXPECT_EQ(half->block, 6U);
  EXPECT_NEAR(half->interval.low, 2.5, 0.06);
  EXPECT_NEAR(half->interval.high, 3.3889, 0.03);
  const auto most = block_bootstrap(series, {0.8, 100'000, 5});
  EXPECT_NEAR(most->interval.low, 1.8889, 0.06);
  EXPECT_NEAR(most->interval.high, 3.6667, 0.06);
  const auto rooted = block_bootstrap(series, {0.5, 100'000, 5}, root);
  EXPECT_DOUBLE_EQ(rooted->interval.low, std::sqrt(half->interval.low));
  EXPECT_DOUBLE_EQ(rooted->interval.high, std::sqrt(half->interval.high));
}

// Neighbours of opposite sign: every value counts as one, and blocks are of 3 values.
TEST(BlockBootstrap, needs_eight_values) {
  const std::vector<double> series{1, -1, 1, -1, 1, -1, 1, -1};
  ASSERT_TRUE(block_bootstrap(series));
  EXPECT_EQ(block_bootstrap(series)->block, 3U);
  EXPECT_DOUBLE_EQ(block_bootstrap(series)->effective_size, 8.0);
  EXPECT_FALSE(block_bootstrap(std::span{series}.first(7)));
}

/// The value at a rank from 1 on, between two values where it is no integer.
double at_rank(std::vector<double> values, double rank) {
  std::ranges::sort(values);
  const double bounded = std::clamp(rank, 1.0, static_cast<double>(values.size()));
  const auto lower = static_cast<std::size_t>(bounded) - 1;
  const double part = bounded - std::floor(bounded);
  return part == 0.0 ? values[lower] : (1.0 - part) * values[lower] + part * values[lower + 1];
}

/// Efron's BCa with Hesterberg's width, written down once more for few resamples: the ends are the quantiles
/// Φ(b + (b + z)/(1 − a(b + z))) of the resampled means, the quantile of ratio p being the value at rank p·(N + 1).
Interval bca_by_its_formula(const std::vector<double>& runs, const BootstrapOptions& options) {
  const auto n = static_cast<double>(runs.size());
  const auto resamples = static_cast<double>(options.resamples);
  const double centre = mean(runs);
  Random random{options.seed, "statistics/bca"};
  std::vector<double> means(options.resamples);
  double below = 0.0;
  for (double& m : means) {
    for (std::size_t i = 0; i < runs.size(); ++i) m += runs[random.below(runs.size())];
    m /= n;
    below += m < centre ? 1.0 : m == centre ? 0.5 : 0.0;
  }
  double squares = 0.0;
  double cubes = 0.0;
  for (const double v : runs) {
    squares += std::pow(v - centre, 2);
    cubes += std::pow(v - centre, 3);
  }
  const double a = cubes / (6.0 * std::pow(squares, 1.5));
  const double b = normal_quantile(std::clamp(below / resamples, 0.5 / resamples, 1.0 - 0.5 / resamples));
  const double wide = std::sqrt(n / (n - 1.0)) * student_quantile(0.5 + 0.5 * options.level, n - 1.0);
  const auto end = [&](double z) {
    return at_rank(means, (resamples + 1.0) * normal_cdf(b + (b + z) / (1.0 - a * (b + z))));
  };
  return {end(-wide), end(wide)};
}

TEST(Bca, of_few_resamples_equals_its_formula) {
  const std::vector<double> skewed{1.0, 2.25, 3.0, 4.25, 7.75, 16.5};
  const std::vector<double> even{0.0, 1.0, 2.0, 3.0};  // every sixth mean is the sample's
  for (const std::vector<double>& runs : {skewed, even}) {
    for (const std::size_t resamples : {1U, 2U, 3U, 9U, 50U}) {
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        for (const double level : {0.3, 0.5, 0.8}) {
          const BootstrapOptions options{level, resamples, seed};
          const auto interval = bca(runs, options);
          const Interval expected = bca_by_its_formula(runs, options);
          ASSERT_NEAR(interval->low, expected.low, 1e-9) << resamples << " " << seed << " " << level;
          ASSERT_NEAR(interval->high, expected.high, 1e-9) << resamples << " " << seed << " " << level;
        }
      }
    }
  }
}

TEST(Bca, takes_as_many_resamples_as_requested_of_two_hundred_runs) {
  const auto runs = drawn(2, 200);
  EXPECT_NE(bca(runs, {0.95, 5000, 9}), bca(runs, {0.95, 1000, 9}));
}

/// Means of circular blocks, drawn once more, and their quantiles by Student's t of the number of blocks.
Interval blocks_by_their_formula(const std::vector<double>& series, std::size_t block,
                                 const BootstrapOptions& options) {
  const auto resamples = static_cast<double>(options.resamples);
  std::size_t blocks = 0;
  while (blocks * block < series.size()) ++blocks;
  Random random{options.seed, "statistics/blocks"};
  std::vector<double> means(options.resamples);
  for (double& m : means) {
    for (std::size_t b = 0; b < blocks; ++b) {
      const std::size_t first = random.below(series.size());
      for (std::size_t i = 0; i < block; ++i) m += series[(first + i) % series.size()];
    }
    m /= static_cast<double>(blocks * block);
  }
  const double ratio = normal_cdf(-student_quantile(0.5 + 0.5 * options.level, static_cast<double>(blocks) - 1.0));
  return {at_rank(means, (resamples + 1.0) * ratio), at_rank(means, (resamples + 1.0) * (1.0 - ratio))};
}

TEST(BlockBootstrap, of_few_resamples_equals_its_formula) {
  const std::vector<double> long_one{5, 5, 4, 4, 1, 0, 0, 1, 2, 3, 5, 6, 4, 4, 1, 1};  // three blocks of 6
  const std::vector<double> short_one{1, 1, 0, 0, 0, 0, -1, -1};                       // two blocks of 4
  for (const std::size_t resamples : {1U, 9U, 50U}) {
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      for (const double level : {0.3, 0.5, 0.8}) {
        const BootstrapOptions options{level, resamples, seed};
        const Interval of_three = block_bootstrap(long_one, options).value().interval;
        const Interval of_two = block_bootstrap(short_one, options).value().interval;
        ASSERT_NEAR(of_three.low, blocks_by_their_formula(long_one, 6, options).low, 1e-9);
        ASSERT_NEAR(of_three.high, blocks_by_their_formula(long_one, 6, options).high, 1e-9);
        ASSERT_NEAR(of_two.low, blocks_by_their_formula(short_one, 4, options).low, 1e-9);
        ASSERT_NEAR(of_two.high, blocks_by_their_formula(short_one, 4, options).high, 1e-9);
      }
    }
  }
}

// ρ₁ is 2/4, the next pair is 0: τ = −1 + 2·1.5, so that eight values count as four. Three times 8/4 is more than half
// of them, the longest block.
TEST(BlockBootstrap, takes_a_series_equivalent_to_four_values_in_two_blocks) {
  const auto found = block_bootstrap(std::vector<double>{1, 1, 0, 0, 0, 0, -1, -1});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->effective_size, 4.0);
  EXPECT_EQ(found->block, 4U);
}

}  // namespace
}  // namespace cosiva::statistics
