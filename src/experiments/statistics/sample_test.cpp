#include "cosiva/experiments/statistics/sample.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>
#include <vector>

#include "cosiva/base/random.h"

namespace cosiva::statistics {
namespace {

TEST(Sample, has_the_mean_variance_and_root_mean_square_computed_by_hand) {
  const std::vector<double> values{1.0, 2.0, 3.0, 6.0};
  EXPECT_DOUBLE_EQ(mean(values), 3.0);
  EXPECT_DOUBLE_EQ(variance(values), 3.5);
  EXPECT_DOUBLE_EQ(sample_variance(values), 14.0 / 3.0);
  EXPECT_DOUBLE_EQ(root_mean_square(values), std::sqrt(12.5));
  EXPECT_DOUBLE_EQ(ratio_below(values, 3.0), 0.5);  // below, not equal
}

TEST(Sample, without_values_has_no_metrics) {
  EXPECT_TRUE(std::isnan(mean({})));
  EXPECT_TRUE(std::isnan(variance({})));
  EXPECT_TRUE(std::isnan(ratio_below({}, 1.0)));
  EXPECT_TRUE(std::isnan(percentile({}, 0.5)));
  EXPECT_TRUE(std::isnan(sample_variance(std::vector<double>{1.0})));
}

TEST(Percentile, is_a_measured_value) {
  std::vector<double> values{9.0, 1.0, 7.0, 3.0, 5.0, 2.0, 8.0, 4.0, 10.0, 6.0};
  EXPECT_EQ(percentile(values, 0.5), 5.0);
  EXPECT_EQ(percentile(values, 0.9), 9.0);  // nine of ten, whatever 0.9 is in binary
  EXPECT_EQ(percentile(values, 0.91), 10.0);
  EXPECT_EQ(percentile(values, 1.0), 10.0);
  EXPECT_EQ(percentile(values, 0.01), 1.0);
}

TEST(Percentile, of_several_at_once_are_equal_to_single_ones) {
  EXPECT_TRUE(rc::check("any values", [](std::vector<double> values) {
    const std::vector<double> falling{1.0, 0.99, 0.9, 0.5, 0.5, 0.01};
    std::vector<double> one_by_one;
    for (const double p : falling) {
      std::vector<double> copy = values;
      one_by_one.push_back(percentile(copy, p));
    }
    std::vector<float> floats(values.begin(), values.end());
    const auto together = percentiles(values, falling);
    const auto of_floats = percentiles(std::span{floats}, falling);
    for (std::size_t i = 0; i < falling.size(); ++i) {
      RC_ASSERT(together[i] == one_by_one[i] || (values.empty() && std::isnan(together[i])));
      RC_ASSERT(values.empty() || of_floats[i] == double{static_cast<float>(one_by_one[i])});
    }
  }));
}

TEST(Percentile, of_a_heavy_tail_is_not_mean_plus_a_number_of_deviations) {
  // 98 values of 0 and two of 100: p99 is 100, where mean + 2.326 deviations would give 34.6.
  std::vector<double> values(98, 0.0);
  values.insert(values.end(), {100.0, 100.0});
  EXPECT_EQ(percentile(values, 0.99), 100.0);
  EXPECT_EQ(percentile(values, 0.98), 0.0);
}

TEST(Cdf, ends_at_the_largest_value_and_one) {
  const Cdf drawn = cdf({3.0, 1.0, 2.0}, 10);
  EXPECT_EQ(drawn.value, (std::vector{1.0, 2.0, 3.0}));
  EXPECT_DOUBLE_EQ(drawn.ratio.back(), 1.0);
  std::vector<double> many(1000);
  for (std::size_t i = 0; i < many.size(); ++i) many[i] = static_cast<double>(i);
  EXPECT_EQ(cdf(many, 50).value.size(), 50U);
  EXPECT_EQ(cdf(many, 50).value.back(), 999.0);
}

TEST(EffectiveSize, of_a_first_order_series_equals_the_closed_form) {
  Random random{3, "series"};
  for (const double phi : {0.0, 0.5, 0.9, 0.98}) {
    std::vector<double> series(40'000);
    double x = 0.0;
    for (double& v : series) v = x = phi * x + random.gaussian();
    const double wanted = 40'000 * (1.0 - phi) / (1.0 + phi);
    EXPECT_NEAR(effective_size(series) / wanted, 1.0, 0.25) << phi;
  }
}

TEST(EffectiveSize, of_a_constant_series_is_one) { EXPECT_EQ(effective_size(std::vector<double>(100, 2.0)), 1.0); }

TEST(Sample, without_values_has_no_root_mean_square_and_with_two_has_a_variance) {
  EXPECT_TRUE(std::isnan(root_mean_square({})));
  EXPECT_TRUE(std::isnan(sample_variance({})));
  EXPECT_EQ(sample_variance(std::vector{1.0, 3.0}), 2.0);
  EXPECT_EQ(variance(std::vector{5.0}), 0.0);
  EXPECT_EQ(mean(std::vector{5.0}), 5.0);
  EXPECT_EQ(root_mean_square(std::vector{-5.0}), 5.0);
}

// Of seven values at three points: ranks 7/3 → 2, 14/3 → 4, 7.
TEST(Cdf, has_evenly_spaced_points) {
  const Cdf drawn = cdf({70.0, 10.0, 60.0, 20.0, 50.0, 30.0, 40.0}, 3);
  EXPECT_EQ(drawn.value, (std::vector{20.0, 40.0, 70.0}));
  ASSERT_EQ(drawn.ratio.size(), 3U);
  EXPECT_DOUBLE_EQ(drawn.ratio[0], 2.0 / 7.0);
  EXPECT_DOUBLE_EQ(drawn.ratio[1], 4.0 / 7.0);
  EXPECT_DOUBLE_EQ(drawn.ratio[2], 1.0);
  EXPECT_TRUE(cdf({}, 3).value.empty());
  EXPECT_EQ(cdf(std::vector<double>(500, 1.0)).value.size(), 200U);
}

// Geyer's initial positive sequence in exact fractions.
TEST(EffectiveSize, of_short_series_equals_the_sum_by_hand) {
  // Deviations −1.5, −0.5, 0.5, 1.5: ρ₁ = 0.25, and the second pair is negative: τ = −1 + 2·1.25.
  EXPECT_NEAR(effective_size(std::vector{1.0, 2.0, 3.0, 4.0}), 8.0 / 3.0, 1e-12);
  EXPECT_NEAR(effective_size(std::vector{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0}), 2.9217391304348, 1e-11);
  EXPECT_NEAR(effective_size(std::vector{3.0, 1.0, 4.0, 1.0, 5.0, 9.0, 2.0, 6.0}), 7.7703788748565, 1e-11);
  // The third pair is larger than the second: it counts as much as the second.
  EXPECT_NEAR(effective_size(std::vector{1.0, 2.0, 0.0, 0.0, 0.0, 4.0, 5.0, 0.0, 4.0, 2.0, 5.0, 5.0}), 7.5164835164835,
              1e-11);
  // Never more than there are values.
  EXPECT_EQ(effective_size(std::vector{0.0, 9.0, 1.0, 8.0, 2.0, 7.0}), 6.0);
  // Of fewer than four, all.
  EXPECT_EQ(effective_size(std::vector{1.0, 1.0, 1.0}), 3.0);
  EXPECT_EQ(effective_size(std::vector{1.0, 1.0, 1.0, 1.0}), 1.0);
  EXPECT_EQ(effective_size({}), 0.0);
}

TEST(Percentile, of_a_ratio_out_of_range_or_of_rising_ratios_is_an_error_of_the_program) {
  std::vector<double> values{3.0, 1.0, 2.0};
  for (const double p : {0.0, -0.1, 1.1}) EXPECT_DEATH(static_cast<void>(percentile(values, p)), "p > 0.0 && p <= 1.0");
  EXPECT_DEATH(static_cast<void>(percentiles(values, std::vector{0.3, 0.9})), "rank <= among");
}

TEST(EffectiveSize, of_a_series_whose_squares_add_up_to_one_is_not_that_of_a_constant) {
  // Deviations -0.5, -0.5, 0.5, 0.5: ρ₁ = 0.25, and the second pair is negative: τ = −1 + 2·1.25.
  EXPECT_NEAR(effective_size(std::vector{0.0, 0.0, 1.0, 1.0}), 8.0 / 3.0, 1e-12);
}

TEST(Cdf, of_no_more_values_than_points_has_each_value_once) {
  const Cdf drawn = cdf({30.0, 10.0, 20.0, 40.0}, 4);
  EXPECT_EQ(drawn.value, (std::vector{10.0, 20.0, 30.0, 40.0}));
  EXPECT_EQ(drawn.ratio, (std::vector{0.25, 0.5, 0.75, 1.0}));
  EXPECT_EQ(cdf({30.0, 10.0, 20.0}, 1).value, std::vector{30.0});
}

}  // namespace
}  // namespace cosiva::statistics
