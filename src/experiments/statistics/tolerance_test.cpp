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

}  // namespace
}  // namespace cosiva::statistics
