#include "cosiva/virtual/simulator/statistics.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/base/random.h"

namespace cosiva::virtual_side {
namespace {

TEST(Statistics, of_no_samples_are_zero) {
  const Statistics none;
  EXPECT_EQ(none.count(), 0U);
  EXPECT_EQ(none.mean(), 0.0);
  EXPECT_EQ(none.percentile(0.99), 0.0);
  EXPECT_EQ(none.max(), 0.0);
}

TEST(Statistics, of_one_to_a_hundred_are_correct) {
  Statistics hundred;
  for (int i = 100; i >= 1; --i) hundred.add(i);
  EXPECT_EQ(hundred.count(), 100U);
  EXPECT_DOUBLE_EQ(hundred.mean(), 50.5);
  EXPECT_EQ(hundred.percentile(0.50), 50.0);
  EXPECT_EQ(hundred.percentile(0.99), 99.0);
  EXPECT_EQ(hundred.percentile(1.0), 100.0);
  EXPECT_EQ(hundred.max(), 100.0);
}

TEST(Statistics, ignore_values_that_are_not_numbers) {
  Statistics s;
  s.add(std::numeric_limits<double>::quiet_NaN());
  s.add(std::numeric_limits<double>::infinity());
  s.add(-1e-9);
  EXPECT_EQ(s.count(), 1U);
  EXPECT_EQ(s.max(), 0.0);
}

TEST(Statistics, stay_within_a_hundredth_of_the_exact_value_for_more_samples_than_are_stored) {
  EXPECT_TRUE(rc::check("percentiles of many samples", [] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "samples"};
    Statistics s;
    std::vector<double> all;
    for (int i = 0; i < 6000; ++i) {
      const double value = random.uniform() * random.uniform() * (random.chance(0.01) ? 1e4 : 1.0);
      all.push_back(value);
      s.add(value);
    }
    std::ranges::sort(all);
    for (const double ratio : {0.5, 0.9, 0.99}) {
      const double ground_truth = all[static_cast<std::size_t>(std::ceil(ratio * 6000.0)) - 1];
      RC_ASSERT(std::fabs(s.percentile(ratio) - ground_truth) <= 0.01 * ground_truth);
    }
    RC_ASSERT(s.max() == all.back());
    RC_ASSERT(s.count() == 6000U);
  }));
}

TEST(Statistics, count_huge_and_tiny_samples_in_the_outer_buckets) {
  Statistics s;
  for (int i = 0; i < 3000; ++i) s.add(0.0);
  EXPECT_EQ(s.percentile(0.99), 0.0);
  for (int i = 0; i < 3000; ++i) s.add(1e30);
  EXPECT_GT(s.percentile(0.99), 1e7);
  EXPECT_EQ(s.max(), 1e30);
}

TEST(RecentP99, is_violated_when_more_than_one_in_a_hundred_is_above) {
  RecentP99 recent{10.0, 200};
  EXPECT_TRUE(recent.held());
  for (int i = 0; i < 200; ++i) recent.add(5.0, {});
  recent.add(11.0, {});
  recent.add(11.0, {});
  EXPECT_TRUE(recent.held()) << "2 of 200 are one in a hundred";
  recent.add(11.0, {});
  EXPECT_FALSE(recent.held());
  for (int i = 0; i < 200; ++i) recent.add(10.0, {});
  EXPECT_TRUE(recent.held()) << "old samples no longer count";
}

TEST(RecentP99, is_displayed_as_violated_for_four_seconds_after_the_last_value_above_the_limit) {
  using namespace std::chrono_literals;
  RecentP99 recent{10.0, 200};
  SimTime now = virtual_epoch;
  const auto pass = [&](int seconds, double value) {
    for (int i = 0; i < 10 * seconds; ++i) recent.add(value, now += 100ms);
  };
  pass(20, 5.0);
  pass(2, 11.0);
  EXPECT_TRUE(recent.violated(now));
  pass(3, 5.0);
  EXPECT_TRUE(recent.violated(now + 999ms));
  EXPECT_FALSE(recent.violated(now + 1s)) << "without further values, too";
  pass(1, 5.0);
  EXPECT_FALSE(recent.held()) << "20 values of the last 200 are above";
  recent.add(11.0, now);
  EXPECT_TRUE(recent.violated(now));
}

TEST(RecentP99, is_not_displayed_as_violated_by_one_value_in_a_hundred) {
  RecentP99 recent{10.0, 200};
  for (int i = 0; i < 200; ++i) recent.add(5.0, {});
  recent.add(11.0, {});
  EXPECT_FALSE(recent.violated({}));
}

}  // namespace
}  // namespace cosiva::virtual_side
