#include "cosiva/experiments/statistics/tolerance.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/experiments/statistics/special.h"

namespace cosiva::statistics {
namespace {

// Nine cells of one type from full to 2.5 V: Battery Testing Consortium, Oxford Brookes, 2021.
constexpr std::array nine{3490.71, 3652.06, 3602.42, 3619.98, 3598.24, 3646.51, 3595.89, 3591.32, 3651.98};

TEST(Fisher, quantiles_equal_the_tables) {
  EXPECT_NEAR(fisher_cdf(4.9646, 1.0, 10.0), 0.95, 1e-5);
  EXPECT_NEAR(fisher_cdf(3.4780, 4.0, 10.0), 0.95, 1e-4);
  EXPECT_NEAR(fisher_cdf(3.3541, 2.0, 27.0), 0.95, 1e-4);
  EXPECT_EQ(fisher_cdf(0.0, 3.0, 3.0), 0.0);
  // F with 1 and d degrees is the square of Student's t with d: 2.2281² at d 10.
  EXPECT_NEAR(fisher_cdf(2.228138852 * 2.228138852, 1.0, 10.0), 0.95, 1e-9);
}

TEST(ShiftedStudent, without_a_shift_is_student_s) {
  EXPECT_NEAR(shifted_student_quantile(0.975, 9.0, 0.0), 2.2621571628, 1e-8);
  EXPECT_NEAR(shifted_student_cdf(0.0, 5.0, 1.0), 0.15865525393, 1e-9);  // Φ(−1)
  EXPECT_NEAR(shifted_student_cdf(-3.0, 2.0, 0.0) + shifted_student_cdf(3.0, 2.0, 0.0), 1.0, 1e-9);
}

struct FactorRow {
  std::size_t n;
  double covers_95;
  double covers_90;
};

// ISO 16269-6, table C.
TEST(ToleranceFactor, equals_the_standard_s_table) {
  for (const FactorRow& row : {FactorRow{5, 4.203, 3.407},
                               {9, 3.031, 2.454},
                               {10, 2.911, 2.355},
                               {12, 2.736, 2.210},
                               {20, 2.396, 1.926},
                               {30, 2.220, 1.777}}) {
    EXPECT_NEAR(tolerance_factor(row.n, 0.95), row.covers_95, 6e-4) << row.n;
    EXPECT_NEAR(tolerance_factor(row.n, 0.90), row.covers_90, 6e-4) << row.n;
  }
  EXPECT_NEAR(ratio_above_smallest(9), 0.72, 0.005);
  EXPECT_NEAR(ratio_above_smallest(12), 0.78, 0.005);
  EXPECT_NEAR(ratio_above_smallest(30), 0.90, 0.006);
}

TEST(MeanInterval, of_nine_cells_equals_the_published_one) {
  const auto interval = mean_interval(nine);
  EXPECT_NEAR(interval->low, 3567.3, 0.05);
  EXPECT_NEAR(interval->high, 3643.7, 0.05);
  EXPECT_NEAR(deviation_interval(nine)->high, 1.916 * 49.69, 0.05);
  const auto next = prediction_interval(nine);
  EXPECT_NEAR(0.5 * (next->high - next->low), 2.306 * 49.69 * std::sqrt(1.0 + 1.0 / 9.0), 0.1);
  EXPECT_FALSE(mean_interval(std::array{1.0}));
  EXPECT_FALSE(deviation_interval(std::array{1.0}));
  EXPECT_FALSE(prediction_interval({}));
}

struct SizeRow {
  double cv;
  double half_width;
  std::size_t n;
};

TEST(SampleSize, is_the_smallest_sufficient_size) {
  for (const SizeRow& row : {SizeRow{0.003, 0.01, 3},
                             {0.01, 0.01, 7},
                             {0.01, 0.005, 18},
                             {0.014, 0.01, 11},
                             {0.014, 0.02, 5},
                             {0.03, 0.01, 38},
                             {0.03, 0.02, 12},
                             {0.05, 0.02, 27},
                             {0.05, 0.05, 7}})
    EXPECT_EQ(sample_size(row.cv, row.half_width), row.n) << row.cv << " " << row.half_width;
  EXPECT_EQ(sample_size(0.0, 0.01), 2U);
}

TEST(SequentialStop, comes_when_the_half_width_is_reached_and_still_covers) {
  Random random{1, "stop"};
  constexpr int sequences = 1000;
  int covered = 0;
  double looked = 0.0;
  for (int i = 0; i < sequences; ++i) {
    std::vector<double> values;
    for (int k = 0; k < 120; ++k) values.push_back(random.gaussian(100.0, 2.0));
    const auto n = stops_at(values, 0.01);
    ASSERT_TRUE(n);
    ASSERT_FALSE(stops_at(std::span{values}.first(*n - 1), 0.01));
    const auto interval = mean_interval(std::span{values}.first(*n));
    ASSERT_LE(interval->high - interval->low, 2.02);
    covered += interval->low <= 100.0 && 100.0 <= interval->high ? 1 : 0;
    looked += static_cast<double>(*n) / sequences;
  }
  EXPECT_GT(static_cast<double>(covered) / sequences, 0.90);
  EXPECT_NEAR(looked, static_cast<double>(sample_size(0.02, 0.01)), 4.0);
}

TEST(SequentialStop, waits_for_the_least_number_of_values) {
  const std::vector<double> values{100.0, 100.1, 99.9, 100.05, 100.0};
  EXPECT_EQ(stops_at(values, 0.5), 5U);
  EXPECT_EQ(stops_at(values, 0.5, 2), 4U);  // Chow and Robbins's 1/n
  EXPECT_FALSE(stops_at(std::span{values}.first(4), 0.5));
}

TEST(Grubbs, flags_only_the_one_outlier) {
  const auto worst = grubbs(nine);
  ASSERT_TRUE(worst);
  EXPECT_EQ(worst->index, 0U);
  EXPECT_NEAR(worst->statistic, 2.309, 0.001);
  EXPECT_NEAR(worst->critical, 2.215, 0.001);
  EXPECT_TRUE(worst->is_outlier);
  EXPECT_FALSE(grubbs(std::span{nine}.subspan(1))->is_outlier);
  EXPECT_FALSE(grubbs(std::array{1.0, 1.0, 1.0}));
  EXPECT_FALSE(grubbs(std::array{1.0, 2.0}));
  EXPECT_NEAR(robust_scores(nine)[0], -4.3, 0.2);
  EXPECT_EQ(median(nine), 3602.42);
  EXPECT_EQ(median(std::array{4.0, 1.0}), 2.5);
}

TEST(Normality, rejects_non_normal_samples_and_rarely_normal_ones) {
  Random random{2, "normality"};
  int doubted = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> values;
    for (int k = 0; k < 12; ++k) values.push_back(random.gaussian(5.0, 3.0));
    doubted += *normality_p(values) < 0.05 ? 1 : 0;
  }
  EXPECT_NEAR(doubted / 2000.0, 0.05, 0.015);
  std::vector<double> lopsided;
  for (int k = 1; k <= 40; ++k) lopsided.push_back(1.0 / k);
  EXPECT_LT(*normality_p(lopsided), 0.001);
  EXPECT_FALSE(normality_p(std::array{1.0, 2.0, 3.0}));
}

// Reference values from mpmath with 30 digits.
TEST(Fisher, with_two_degrees_in_the_numerator_equals_its_closed_form) {
  for (const double f : {0.1, 1.0, 1.7, 5.0})
    for (const double d : {1.0, 7.0, 30.0})
      EXPECT_NEAR(fisher_cdf(f, 2.0, d), 1.0 - std::pow(1.0 + 2.0 * f / d, -0.5 * d), 1e-12) << f << " " << d;
  EXPECT_EQ(fisher_cdf(-1.0, 3.0, 3.0), 0.0);
}

TEST(ShiftedStudent, equals_the_reference) {
  EXPECT_NEAR(shifted_student_cdf(2.0, 5.0, 1.0), 0.77807466261621, 1e-9);
  EXPECT_NEAR(shifted_student_cdf(1.0, 3.0, -0.5), 0.90787879018564, 1e-9);
  EXPECT_NEAR(shifted_student_cdf(3.5, 20.0, 2.5), 0.79877802875593, 1e-9);
  EXPECT_NEAR(shifted_student_cdf(0.5, 2.0, 2.0), 0.064863036788169, 1e-9);
  for (const double p : {0.001, 0.2, 0.5, 0.95, 0.9999})
    for (const double shift : {-3.0, 0.0, 12.0})
      EXPECT_NEAR(shifted_student_cdf(shifted_student_quantile(p, 3.0, shift), 3.0, shift), p, 1e-9)
          << p << " " << shift;
}

TEST(ToleranceFactor, equals_the_reference_at_other_levels) {
  EXPECT_NEAR(tolerance_factor(9), 3.0312375134713, 1e-7);
  EXPECT_NEAR(tolerance_factor(4, 0.9, 0.8), 2.37247449243, 1e-7);
  EXPECT_NEAR(ratio_above_smallest(1, 0.75), 0.25, 1e-12);
  EXPECT_NEAR(ratio_above_smallest(2, 0.75), 0.5, 1e-12);
}

TEST(MeanInterval, and_the_others_equal_the_reference_at_two_levels) {
  struct Row {
    double level;
    Interval mean;
    Interval next;
    Interval deviation;
  };
  for (const Row& row : {Row{0.95,
                             {3567.2622366087, 3643.6510967246},
                             {3484.6752737515, 3726.2380595819},
                             {33.562858015413, 95.192947677674}},
                         Row{0.8,
                             {3582.3211640726, 3628.5921692607},
                             {3532.2957836567, 3678.6175496766},
                             {38.448333226413, 75.235387859425}}}) {
    EXPECT_NEAR(mean_interval(nine, row.level)->low, row.mean.low, 1e-7);
    EXPECT_NEAR(mean_interval(nine, row.level)->high, row.mean.high, 1e-7);
    EXPECT_NEAR(prediction_interval(nine, row.level)->low, row.next.low, 1e-7);
    EXPECT_NEAR(prediction_interval(nine, row.level)->high, row.next.high, 1e-7);
    EXPECT_NEAR(deviation_interval(nine, row.level)->low, row.deviation.low, 1e-7);
    EXPECT_NEAR(deviation_interval(nine, row.level)->high, row.deviation.high, 1e-7);
  }
  EXPECT_TRUE(mean_interval(std::array{1.0, 2.0}));
  EXPECT_TRUE(deviation_interval(std::array{1.0, 2.0}));
  EXPECT_TRUE(prediction_interval(std::array{1.0, 2.0}));
}

TEST(SampleSize, is_limited_to_a_million) {
  EXPECT_EQ(sample_size(1000.0, 1e-3), 1'000'000U);
  // z² · (0.5/0.001)² with z = 1.96 is 960 365; Student's t adds hardly anything.
  EXPECT_NEAR(static_cast<double>(sample_size(0.5, 0.001)), 960'365.0, 10.0);
}

TEST(Grubbs, equals_the_reference_and_takes_three_values) {
  const auto worst = grubbs(nine);
  EXPECT_NEAR(worst->statistic, 2.3092921091075, 1e-9);
  EXPECT_NEAR(worst->critical, 2.2150042233255, 1e-8);
  EXPECT_NEAR(grubbs(nine, 0.2)->critical, 1.9772649152218, 1e-8);
  // Of 0, 0, 3: mean 1, deviation √3.
  const auto three = grubbs(std::array{0.0, 0.0, 3.0});
  ASSERT_TRUE(three);
  EXPECT_EQ(three->index, 2U);
  EXPECT_NEAR(three->statistic, 2.0 / std::sqrt(3.0), 1e-12);
}

// Of 1, 2, 3, 4, 10 the median is 3 and the median distance 1.
TEST(RobustScores, are_distances_in_median_distances) {
  const auto scores = robust_scores(std::array{1.0, 2.0, 3.0, 4.0, 10.0});
  EXPECT_NEAR(scores[0], -2.0 / 1.4826, 1e-12);
  EXPECT_EQ(scores[2], 0.0);
  EXPECT_NEAR(scores[4], 7.0 / 1.4826, 1e-12);
  EXPECT_THAT(robust_scores(std::array{1.0, 1.0, 1.0, 9.0}), ::testing::ElementsAre(0.0, 0.0, 0.0, 0.0));
  EXPECT_EQ(median(std::array{5.0}), 5.0);
  EXPECT_EQ(median(std::array{4.0, 1.0, 7.0, 2.0}), 3.0);
  EXPECT_TRUE(std::isnan(median({})));
}

// A² and Stephens's four formulas, from mpmath: A* 0.151, 0.325, 0.514 and 1.815.
TEST(Normality, equals_the_reference_in_each_range_of_the_table) {
  EXPECT_NEAR(*normality_p(std::array{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0}), 0.96145569293858, 1e-9);
  EXPECT_NEAR(*normality_p(std::array{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 12.0}), 0.52271083912723, 1e-9);
  EXPECT_NEAR(*normality_p(std::array{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 14.0}), 0.19239209891315, 1e-9);
  EXPECT_NEAR(*normality_p(std::array{40.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 1.0}), 0.0001229070821035, 1e-11);
  EXPECT_FALSE(normality_p(std::array{1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0}));
  EXPECT_FALSE(normality_p(std::vector<double>(8, 3.0)));
  std::vector<double> far(400, 0.0);
  for (std::size_t i = 0; i < far.size(); ++i) far[i] = i % 2 == 0 ? 1.0 : 1000.0;
  EXPECT_EQ(*normality_p(far), 0.0);  // A* beyond 13, where the formula rises again
}

// One degree of freedom: Cauchy's distribution, whose scale has its greatest density at zero.
TEST(ShiftedStudent, of_one_degree_of_freedom_is_cauchy_s) {
  for (const double t : {-2.0, -1.0, 0.0, 0.5, 1.0, 2.0})
    EXPECT_NEAR(shifted_student_cdf(t, 1.0, 0.0), 0.5 + std::atan(t) / 3.14159265358979323846, 5e-9) << t;
  EXPECT_NEAR(shifted_student_quantile(0.75, 1.0, 0.0), 1.0, 1e-7);
}

TEST(Tolerances, of_impossible_arguments_are_errors_of_the_program) {
  for (const double degrees : {0.0, -1.0}) {
    EXPECT_DEATH(static_cast<void>(fisher_cdf(1.0, degrees, 3.0)), "numerator_degrees > 0.0 && denom") << degrees;
    EXPECT_DEATH(static_cast<void>(fisher_cdf(1.0, 3.0, degrees)), "denominator_degrees > 0.0") << degrees;
    EXPECT_DEATH(static_cast<void>(shifted_student_cdf(1.0, degrees, 0.0)), "degrees > 0.0") << degrees;
  }
  for (const double p : {0.0, 1.0, -0.5, 1.5})
    EXPECT_DEATH(static_cast<void>(shifted_student_quantile(p, 3.0, 0.0)), "p > 0.0 && p < 1.0") << p;
  EXPECT_DEATH(static_cast<void>(tolerance_factor(1)), "n >= 2");
  EXPECT_GT(tolerance_factor(2), tolerance_factor(3));
  EXPECT_DEATH(static_cast<void>(ratio_above_smallest(0)), "n > 0");
  EXPECT_DEATH(static_cast<void>(sample_size(-0.01, 0.1)), "relative_sd >= 0.0 && relative_half_width > 0.0");
  EXPECT_DEATH(static_cast<void>(sample_size(0.01, 0.0)), "relative_half_width > 0.0");
}

TEST(Grubbs, is_the_same_in_any_unit_and_takes_the_first_of_two_equal_distances) {
  // Of 0, 0, 1: mean 1/3, deviation 1/√3.
  const auto small = grubbs(std::array{0.0, 0.0, 1.0});
  ASSERT_TRUE(small);
  EXPECT_EQ(small->index, 2U);
  EXPECT_NEAR(small->statistic, 2.0 / std::sqrt(3.0), 1e-12);
  const auto three = grubbs(std::array{-1.0, 0.0, 1.0});
  ASSERT_TRUE(three);
  EXPECT_EQ(three->index, 0U);
  EXPECT_EQ(three->statistic, 1.0);
  EXPECT_FALSE(three->is_outlier);
  // Of four values a deviation of √(4/3): no value is farther than its deviation.
  const auto four = grubbs(std::array{-1.0, -1.0, 1.0, 1.0});
  ASSERT_TRUE(four);
  EXPECT_EQ(four->index, 0U);
  EXPECT_NEAR(four->statistic, 0.5 * std::sqrt(3.0), 1e-12);
  EXPECT_FALSE(four->is_outlier);
}

TEST(RobustScores, are_the_same_in_any_unit) {
  const auto scores = robust_scores(std::array{0.1, 0.2, 0.3, 0.4, 1.0});
  EXPECT_NEAR(scores[0], -2.0 / 1.4826, 1e-9);
  EXPECT_NEAR(scores[1], -1.0 / 1.4826, 1e-9);
  EXPECT_NEAR(scores[4], 7.0 / 1.4826, 1e-9);
}

TEST(Normality, is_the_same_in_any_unit) {
  EXPECT_NEAR(normality_p(std::array{0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8}).value(), 0.96145569293858, 1e-9);
}

// Half of n values at −1, half at 1 deviation: A² is 0.18·n, 10.8 of 60 values and 18 of 100.
TEST(Normality, of_two_values_in_equal_numbers_is_zero_from_a_statistic_of_13_on) {
  const auto p_of = [](std::size_t n) {
    std::vector<double> values;
    for (std::size_t i = 0; i < n; ++i) values.push_back(i % 2 == 0 ? 1.0 : 1000.0);
    return normality_p(values).value();
  };
  EXPECT_EQ(p_of(100), 0.0);
  EXPECT_GT(p_of(60), 0.0);
  EXPECT_LT(p_of(60), 1e-20);
}

TEST(SequentialStop, may_come_at_the_second_value) {
  // At 50 %, t of one degree of freedom is 1: √(w²/2/2) is half of the requested w.
  for (const std::size_t least : {0U, 1U, 2U}) EXPECT_EQ(stops_at(std::array{100.0, 100.1}, 0.5, least, 0.5), 2U);
  EXPECT_FALSE(stops_at(std::array{100.0, 100.1}, 0.5, 3, 0.5));
  EXPECT_FALSE(stops_at(std::array{100.0}, 0.5, 1, 0.5));
}

}  // namespace
}  // namespace cosiva::statistics
