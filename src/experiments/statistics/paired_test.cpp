#include "cosiva/experiments/statistics/paired.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "cosiva/base/random.h"

namespace cosiva::statistics {
namespace {

TEST(Wilcoxon, is_exact_for_few_runs) {
  EXPECT_DOUBLE_EQ(wilcoxon(std::vector{1.0, 2.0, 3.0, 4.0, 5.0, 6.0}), 2.0 / 64.0);
  EXPECT_DOUBLE_EQ(wilcoxon(std::vector{-1.0, -2.0, -3.0, -4.0, -5.0}), 2.0 / 32.0);
  // Ranks 3 and 5 of ten against the others: W = 8, the tables' last value at 5 %: 25 of 1024 sums on each side.
  EXPECT_DOUBLE_EQ(wilcoxon(std::vector{1.0, 2.0, -3.0, 4.0, -5.0, 6.0, 7.0, 8.0, 9.0, 10.0}), 50.0 / 1024.0);
  EXPECT_DOUBLE_EQ(wilcoxon(std::vector{1.0, -1.0}), 1.0);
}

TEST(Wilcoxon, assigns_mean_ranks_to_equal_differences_and_ignores_equal_runs) {
  // |d| = 1, 1, 2 with ranks 1.5, 1.5, 3: all eight sums by hand, W⁻ = 1.5: {0, 1.5, 1.5} of 8.
  EXPECT_DOUBLE_EQ(wilcoxon(std::vector{1.0, -1.0, 2.0}), 2.0 * 3.0 / 8.0);
  EXPECT_DOUBLE_EQ(wilcoxon(std::vector{0.0, 1.0, 2.0, 0.0, 3.0, 4.0, 5.0, 6.0}), 2.0 / 64.0);
  EXPECT_EQ(wilcoxon(std::vector{0.0, 0.0}), 1.0);
  EXPECT_EQ(wilcoxon({}), 1.0);
}

TEST(Wilcoxon, passes_smoothly_from_exact_to_approximate) {
  Random random{1, "wilcoxon"};
  std::vector<double> differences;
  for (int i = 0; i < 200; ++i) differences.push_back(random.gaussian(0.15, 1.0));
  const double exact = wilcoxon(differences);
  differences.push_back(1e-9);  // hardly a difference, but one run more than are computed exactly
  EXPECT_NEAR(wilcoxon(differences) / exact, 1.0, 0.05);
}

TEST(Wilcoxon, has_no_more_false_alarms_than_stated) {
  int alarms = 0;
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Random random{seed, "null"};
    std::vector<double> differences(12);
    for (double& d : differences) d = random.gaussian();
    alarms += wilcoxon(differences) < 0.05 ? 1 : 0;
  }
  EXPECT_LE(alarms, 2000 * 0.05 + 3 * std::sqrt(2000 * 0.05 * 0.95));
  EXPECT_GE(alarms, 50);  // and not because the test never rejects
}

TEST(Holm, raises_the_smallest_most_and_preserves_the_order) {
  const auto raised = holm(std::vector{0.04, 0.01, 0.03});
  EXPECT_DOUBLE_EQ(raised[1], 0.03);
  EXPECT_DOUBLE_EQ(raised[2], 0.06);
  EXPECT_DOUBLE_EQ(raised[0], 0.06);
  EXPECT_EQ(holm(std::vector{0.7, 0.9}), (std::vector{1.0, 1.0}));
  EXPECT_TRUE(holm({}).empty());
}

TEST(Friedman, of_unanimous_runs_is_maximal) {
  const auto result = friedman({{1, 2, 3}, {10, 20, 30}, {0.1, 0.2, 0.9}, {5, 6, 7}});
  ASSERT_TRUE(result);
  EXPECT_EQ(result->mean_ranks, (std::vector{1.0, 2.0, 3.0}));
  EXPECT_NEAR(result->chi_squared, 8.0, 1e-12);
  EXPECT_NEAR(result->p, std::exp(-4.0), 1e-12);
}

TEST(Friedman, of_equal_metrics_shows_nothing) {
  const auto result = friedman({{1, 1}, {2, 2}});
  EXPECT_EQ(result->p, 1.0);
  EXPECT_EQ(result->mean_ranks, (std::vector{1.5, 1.5}));
  EXPECT_FALSE(friedman({{1, 2}}));
  EXPECT_FALSE(friedman({{1}, {2}}));
}

TEST(RunsToDecide, are_as_many_as_the_test_then_needs) {
  Random random{1, "pilot"};
  std::vector<double> pilot(10000);
  for (double& d : pilot) d = random.gaussian(0.5, 1.0);
  const auto needed = runs_to_decide(pilot);
  ASSERT_TRUE(needed);
  EXPECT_NEAR(static_cast<double>(*needed), 33.0, 3.0);  // (1.96 + 0.84)²·π/3 / 0.5²
  int decided = 0;
  for (int campaign = 0; campaign < 1000; ++campaign) {
    std::vector<double> runs(*needed);
    for (double& d : runs) d = random.gaussian(0.5, 1.0);
    decided += wilcoxon(runs) < 0.05 ? 1 : 0;
  }
  EXPECT_NEAR(decided / 1000.0, 0.8, 0.08);  // the stated power
}

TEST(RunsToDecide, are_at_least_six_and_none_without_a_difference) {
  EXPECT_EQ(runs_to_decide(std::vector{1.0, 1.001, 0.999}), 6U);
  // Among 28 comparisons a p of 2/2ⁿ must be below 0.05/28.
  EXPECT_EQ(runs_to_decide(std::vector{1.0, 1.001, 0.999}, 0.05 / 28.0), 11U);
  EXPECT_FALSE(runs_to_decide(std::vector{1.0, -1.0}));
  EXPECT_FALSE(runs_to_decide(std::vector{1.0}));
}

TEST(Astm, consecutive_passes_are_those_of_the_standard) {
  EXPECT_EQ(passes_needed(0.95, 0.95), 59U);
  EXPECT_EQ(passes_needed(0.90, 0.95), 29U);
  EXPECT_EQ(passes_needed(0.99, 0.95), 299U);
  EXPECT_GE(reliability_shown(59, 0.95), 0.95);
  EXPECT_LT(reliability_shown(58, 0.95), 0.95);
  EXPECT_EQ(reliability_shown(0, 0.95), 0.0);
}

// 250 differences of the sizes 1 to 250, every third negative: W = 10 458, of mean n(n + 1)/4 and variance
// n(n + 1)(2n + 1)/24, with half a rank for continuity.
TEST(Wilcoxon, of_more_than_two_hundred_runs_is_the_normal_approximation) {
  std::vector<double> differences;
  for (int i = 1; i <= 250; ++i) differences.push_back(i % 3 == 0 ? -i : i);
  EXPECT_NEAR(wilcoxon(differences) / 4.9061351369717e-6, 1.0, 1e-8);
  for (double& d : differences) d = -d;
  EXPECT_NEAR(wilcoxon(differences) / 4.9061351369717e-6, 1.0, 1e-8);
  // As even as possible: no probability above 1.
  for (std::size_t i = 0; i < differences.size(); ++i)
    differences[i] = (i / 2) % 2 == i % 2 ? static_cast<double>(i + 1) : -static_cast<double>(i + 1);
  EXPECT_LE(wilcoxon(differences), 1.0);
  EXPECT_GT(wilcoxon(differences), 0.9);
}

TEST(Holm, multiplies_each_by_the_number_of_those_not_smaller) {
  EXPECT_EQ(holm(std::vector{0.25}), (std::vector{0.25}));
  const auto raised = holm(std::vector{0.001, 0.01, 0.02, 0.04});
  EXPECT_DOUBLE_EQ(raised[0], 0.004);
  EXPECT_DOUBLE_EQ(raised[1], 0.03);
  EXPECT_DOUBLE_EQ(raised[2], 0.04);
  EXPECT_DOUBLE_EQ(raised[3], 0.04);
}

// Ranks 1½ 1½ 3, 2 1 3, 1 2½ 2½, 1 3 2, 1 2 3: Σr² 69, centre 60; chi² = 2·25·(0.49 + 0 + 0.49)/9.
TEST(Friedman, with_ties_is_conover_s_form) {
  const auto result = friedman({{1, 1, 3}, {2, 1, 3}, {1, 2, 2}, {1, 3, 2}, {1, 2, 3}});
  ASSERT_TRUE(result);
  EXPECT_NEAR(result->mean_ranks[0], 1.3, 1e-12);
  EXPECT_NEAR(result->mean_ranks[1], 2.0, 1e-12);
  EXPECT_NEAR(result->mean_ranks[2], 2.7, 1e-12);
  EXPECT_NEAR(result->chi_squared, 49.0 / 9.0, 1e-10);
  EXPECT_NEAR(result->p, std::exp(-49.0 / 18.0), 1e-10);
  EXPECT_FALSE(friedman({}));
  EXPECT_EQ(friedman({{1, 1}, {2, 2}})->chi_squared, 0.0);
}

// z² · s²/d² · π/3 with z² = 7.849 for 5 % and 80 %, 14.879 for 1 % and 90 %; s² = 200/199, d = 0.1.
TEST(RunsToDecide, of_many_runs_are_the_formula_s) {
  std::vector<double> differences;
  for (int i = 0; i < 100; ++i) {
    differences.push_back(1.1);
    differences.push_back(-0.9);
  }
  EXPECT_EQ(runs_to_decide(differences), 827U);
  EXPECT_EQ(runs_to_decide(differences, 0.01, 0.9), 1566U);
  for (double& d : differences) d = -d;
  EXPECT_EQ(runs_to_decide(differences), 827U);
  // More than a thousand million runs decide nothing.
  for (double& d : differences) d = (d > 0.0 ? 1.0 : -1.0) + 1e-6;
  EXPECT_FALSE(runs_to_decide(differences));
}

TEST(Astm, reliability_of_passes_is_the_root_of_the_doubt) {
  EXPECT_NEAR(reliability_shown(1, 0.95), 0.05, 1e-12);
  EXPECT_NEAR(reliability_shown(2, 0.75), 0.5, 1e-12);
  EXPECT_EQ(passes_needed(0.5, 0.75), 2U);  // exactly two, whatever the logarithms round to
  EXPECT_EQ(passes_needed(0.5, 0.76), 3U);
  EXPECT_EQ(passes_needed(0.5, 0.5), 1U);
}

TEST(Paired, of_impossible_arguments_are_errors_of_the_program) {
  EXPECT_DEATH(static_cast<void>(friedman({{1, 2, 3}, {1, 2}})), "run.size.. == k");
  constexpr const char* broken = "reliability > 0.0 && reliability < 1.0 && confidence > 0.0 && confidence < 1.0";
  for (const double outside : {0.0, 1.0, -0.5, 1.5}) {
    EXPECT_DEATH(static_cast<void>(passes_needed(outside, 0.95)), broken) << outside;
    EXPECT_DEATH(static_cast<void>(passes_needed(0.95, outside)), broken) << outside;
  }
}

// Every third of the differences 1 to 200 is negative: W = 6633, and the exact ratio of such sums. One more is computed
// by the normal approximation, W = 6834, which is 20 % larger there.
TEST(Wilcoxon, is_exact_up_to_two_hundred_runs_and_approximate_beyond) {
  std::vector<double> differences;
  for (int i = 1; i <= 200; ++i) differences.push_back(i % 3 == 0 ? -i : i);
  EXPECT_NEAR(wilcoxon(differences) / 2.4879064246942968e-5, 1.0, 1e-8);
  differences.push_back(-201.0);
  EXPECT_NEAR(wilcoxon(differences) / 5.9193786248209043e-5, 1.0, 1e-8);
}

TEST(Wilcoxon, of_many_balanced_runs_is_one) {
  std::vector<double> differences;
  for (int i = 1; i <= 252; ++i) differences.push_back(i % 4 < 2 ? i : -i);  // each four ranks are balanced
  EXPECT_NEAR(wilcoxon(differences), 1.0, 1e-9);
}

// Simulated independently with 20 000 tries, the power of n runs with a ratio of mean to deviation of
// 1.1: 64 % of 7, 69 % of 8, 77 % of 9, 86 % of 10; of 1.5: 67 % of 6, 88 % of 7.
TEST(RunsToDecide, of_few_runs_are_those_that_have_the_power) {
  EXPECT_EQ(runs_to_decide(std::vector{0.2, 2.2, 4.2}), 10U);
  EXPECT_EQ(runs_to_decide(std::vector{-0.2, -2.2, -4.2}), 10U);
  EXPECT_EQ(runs_to_decide(std::vector{1.0, 3.0, 5.0}), 7U);
  EXPECT_EQ(runs_to_decide(std::vector{2.0, 2.0, 2.0}), 6U);
}

// Thirty unanimous runs have 2/2³⁰ = 1.9e-9, so that none of the numbers that are simulated shows a level of 1e-9.
TEST(RunsToDecide, are_not_raised_beyond_thirty) {
  EXPECT_EQ(runs_to_decide(std::vector{1.0, 1.001, 0.999}, 1e-9), 30U);
}

TEST(RunsToDecide, must_have_a_p_below_the_level_and_not_equal_to_it) {
  // Six unanimous runs have 2/2⁶ = 0.03125.
  EXPECT_EQ(runs_to_decide(std::vector{1.0, 1.001, 0.999}, 0.03125), 7U);
  EXPECT_EQ(runs_to_decide(std::vector{1.0, 1.001, 0.999}, 0.0313), 6U);
}

}  // namespace
}  // namespace cosiva::statistics
