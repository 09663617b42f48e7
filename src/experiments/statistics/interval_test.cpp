#include "cosiva/experiments/statistics/interval.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "cosiva/base/random.h"

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

}  // namespace
}  // namespace cosiva::statistics
