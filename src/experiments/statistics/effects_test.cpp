#include "cosiva/experiments/statistics/effects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <utility>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/experiments/statistics/crossed.h"

namespace cosiva::statistics {
namespace {

// Nine cells on four tester channels; channels 8 and 7 had three each.
TEST(OneFactor, detects_the_tester_s_channel_behind_the_cells) {
  const auto found = one_factor({{3652.06, 3646.51, 3651.98}, {3598.24, 3595.89, 3591.32}});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->f, 404.0, 2.0);
  EXPECT_NEAR(found->p, 4e-5, 1e-5);
  EXPECT_NEAR(found->within_sd, 3.3, 0.2);
  EXPECT_NEAR(found->between_sd, 55.0 / std::sqrt(2.0), 1.0);
  EXPECT_FALSE(one_factor({{1.0, 2.0}}));
  EXPECT_FALSE(one_factor({{1.0}, {2.0}}));
  EXPECT_FALSE(one_factor({{1.0, 1.0}, {2.0, 2.0}}));
}

TEST(Trend, of_repeated_runs_is_the_loss_per_run) {
  // Cell 1, four runs in a row.
  const std::vector<double> run{1, 2, 3, 4};
  const std::vector<double> seconds{3602.1, 3593.27, 3582.87, 3572.76};
  const auto found = trend(run, seconds);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->slope, -9.84, 0.02);
  EXPECT_GT(found->r_squared, 0.996);
  EXPECT_LT(found->p, 0.01);
  EXPECT_NEAR(found->at_first, 3602.5, 0.5);
  EXPECT_LT(found->at_first_interval.low, 3602.1);
  EXPECT_FALSE(trend(std::vector<double>{1, 2}, std::vector<double>{1, 2}));
  EXPECT_FALSE(trend(std::vector<double>{1, 1, 1}, std::vector<double>{1, 2, 3}));
}

TEST(Trend, has_one_false_alarm_in_twenty) {
  Random random{4, "trend"};
  int cries = 0;
  for (int i = 0; i < 2000; ++i) {
    std::vector<double> x, y;
    for (int k = 1; k <= 6; ++k) {
      x.push_back(k);
      y.push_back(random.gaussian());
    }
    cries += trend(x, y)->p < 0.05 ? 1 : 0;
  }
  EXPECT_NEAR(cries / 2000.0, 0.05, 0.015);
}

TEST(LatinSquare, puts_every_unit_on_every_carrier_once_and_for_even_sizes_after_every_other_once) {
  for (const std::size_t size : {1U, 2U, 3U, 4U, 7U, 12U}) {
    const auto square = latin_square(size);
    std::set<std::pair<std::size_t, std::size_t>> met;
    std::set<std::pair<std::size_t, std::size_t>> follows;
    for (std::size_t run = 0; run < size; ++run) {
      std::set<std::size_t> used{square[run].begin(), square[run].end()};
      EXPECT_EQ(used.size(), size);
      for (std::size_t unit = 0; unit < size; ++unit) {
        met.insert({unit, square[run][unit]});
        if (run > 0) follows.insert({square[run - 1][unit], square[run][unit]});
      }
    }
    EXPECT_EQ(met.size(), size * size);
    if (size % 2 == 0) {
      EXPECT_EQ(follows.size(), size * (size - 1));
    }
  }
}

std::vector<Trial> square_of(std::size_t size, double unit_sd, double carrier_sd, double slope, double noise_sd,
                             std::uint64_t seed) {
  Random random{seed, "square"};
  std::vector<double> unit, carrier;
  for (std::size_t i = 0; i < size; ++i) {
    unit.push_back(random.gaussian(0.0, unit_sd));
    carrier.push_back(random.gaussian(0.0, carrier_sd));
  }
  std::vector<Trial> trials;
  const auto square = latin_square(size);
  for (std::size_t run = 0; run < size; ++run)
    for (std::size_t u = 0; u < size; ++u) {
      const std::size_t c = square[run][u];
      const double nth = static_cast<double>(run) + 1.0;
      trials.push_back({u, c, nth, 3600.0 + unit[u] + carrier[c] + slope * nth + random.gaussian(0.0, noise_sd)});
    }
  return trials;
}

TEST(Crossed, separates_battery_vehicle_and_drift) {
  double unit = 0.0, carrier = 0.0, noise = 0.0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    const auto found = crossed(square_of(6, 10.0, 30.0, -10.0, 2.0, seed));
    ASSERT_TRUE(found);
    EXPECT_FALSE(found->confounded);
    EXPECT_NEAR(found->slope, -10.0, 1.0);
    EXPECT_LT(found->carrier.p, 1e-4);
    unit += found->unit.sd * found->unit.sd / 60.0;
    carrier += found->carrier.sd * found->carrier.sd / 60.0;
    noise += found->noise_sd * found->noise_sd / 60.0;
    EXPECT_NEAR(found->unit.ratio + found->carrier.ratio + found->run.ratio + found->noise_ratio, 1.0, 1e-9);
  }
  EXPECT_NEAR(std::sqrt(unit), 10.0, 1.5);
  EXPECT_NEAR(std::sqrt(carrier), 30.0, 4.0);
  EXPECT_NEAR(std::sqrt(noise), 2.0, 0.1);
}

TEST(Crossed, effects_equal_those_of_the_input) {
  std::vector<Trial> trials;
  const auto square = latin_square(4);
  const std::vector<double> unit{-3.0, -1.0, 1.0, 3.0};
  const std::vector<double> carrier{5.0, -5.0, 2.0, -2.0};
  for (std::size_t run = 0; run < 4; ++run)
    for (std::size_t u = 0; u < 4; ++u) {
      const double nth = static_cast<double>(run) + 1.0;
      trials.push_back({u, square[run][u], nth, 100.0 + unit[u] + carrier[square[run][u]] + 0.5 * nth});
    }
  const auto found = crossed(trials);
  ASSERT_TRUE(found);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_NEAR(found->unit_effects[i], unit[i], 1e-9);
    EXPECT_NEAR(found->carrier_effects[i], carrier[i], 1e-9);
  }
  EXPECT_NEAR(found->slope, 0.5, 1e-9);
}

TEST(Crossed, reports_when_each_battery_stayed_on_its_vehicle) {
  std::vector<Trial> trials;
  Random random{1, "confounded"};
  for (std::size_t run = 1; run <= 3; ++run)
    for (std::size_t u = 0; u < 4; ++u)
      trials.push_back({u, u, static_cast<double>(run), 100.0 + 5.0 * static_cast<double>(u) + random.gaussian()});
  const auto found = crossed(trials);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->confounded);
  EXPECT_LT(found->unit.p, 0.01);
  EXPECT_TRUE(found->unit_effects.empty());
  EXPECT_FALSE(crossed(std::span{trials}.first(4)));
  EXPECT_FALSE(crossed({}));
}

TEST(Comparison, of_two_types_equals_the_textbook_s_t) {
  // Welch's example with unequal spreads, as R's t.test gives it.
  const std::vector<double> a{27.5, 21.0, 19.0, 23.6, 17.0, 17.9, 16.9, 20.1, 21.9, 22.6, 23.1, 19.6, 19.0, 21.7, 21.4};
  const std::vector<double> b{27.1, 22.0, 20.8, 23.4, 23.4, 23.5, 25.8, 22.0, 24.8,
                              20.2, 21.9, 22.1, 22.9, 30.5, 27.5, 24.5, 22.9};
  const auto found = compare(a, b);
  ASSERT_TRUE(found);
  EXPECT_GT(found->difference, 2.0);
  EXPECT_NEAR(found->difference / found->t, (found->interval.high - found->difference) / 2.05, 0.02);
  EXPECT_LT(found->p, 0.01);
  EXPECT_GT(found->power, 0.7);
  EXPECT_FALSE(compare(std::vector<double>{1}, b));
  EXPECT_FALSE(compare(std::vector<double>{1, 1}, std::vector<double>{2, 2}));
}

TEST(Power, equals_the_tables) {
  // Cohen: 64 of each detect d = 0.5 with 80 %, 26 of each d = 0.8; and d = 0 is detected with the probability of the
  // level.
  EXPECT_NEAR(power_of(0.5, 64, 64), 0.80, 0.003);
  EXPECT_NEAR(power_of(0.8, 26, 26), 0.81, 0.005);
  EXPECT_NEAR(power_of(0.0, 10, 10), 0.05, 1e-6);
  EXPECT_EQ(power_of(1.0, 1, 10), 0.0);
}

// Two groups of two and three, and an empty one: means 2 and 4 about 3.2, squares 10 within and 4.8 between.
TEST(OneFactor, of_groups_of_different_sizes_equals_the_analysis_by_hand) {
  const auto found = one_factor({{1.0, 3.0}, {}, {2.0, 4.0, 6.0}});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->f, 4.8 / (10.0 / 3.0), 1e-12);
  EXPECT_NEAR(found->p, 0.31626211469811, 1e-10);  // the F distribution's tail with 1 and 3 degrees, from mpmath
  EXPECT_NEAR(found->within_sd, std::sqrt(10.0 / 3.0), 1e-12);
  EXPECT_NEAR(found->between_sd, std::sqrt((4.8 - 10.0 / 3.0) / 2.4), 1e-12);  // (5 − 13/5)/1 = 2.4 in each group
  EXPECT_FALSE(one_factor({{}, {1.0, 2.0}, {}}));
  EXPECT_FALSE(one_factor({}));
  // One more value than groups is enough.
  EXPECT_TRUE(one_factor({{1.0}, {2.0, 3.0}}));
  // Equal means: nothing between the groups, and the noise explains more than that.
  const auto equal = one_factor({{1.0, 3.0}, {0.0, 4.0}});
  ASSERT_TRUE(equal);
  EXPECT_EQ(equal->f, 0.0);
  EXPECT_EQ(equal->p, 1.0);
  EXPECT_EQ(equal->between_sd, 0.0);
}

// x 2 to 6 about 4, y 2, 3, 5, 4, 6 about 4: Σxx 10, Σxy 9, Σyy 10; 1.9 is left on three degrees of freedom.
TEST(Trend, of_five_points_equals_the_regression_by_hand) {
  const std::vector<double> x{2, 3, 4, 5, 6};
  const std::vector<double> y{2, 3, 5, 4, 6};
  const auto found = trend(x, y);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->slope, 0.9, 1e-12);
  EXPECT_NEAR(found->slope_sd, 0.25166114784236, 1e-11);
  EXPECT_NEAR(found->p, 0.037386073468499, 1e-11);
  EXPECT_NEAR(found->r_squared, 0.81, 1e-12);
  EXPECT_NEAR(found->at_first, 1.3, 1e-12);
  EXPECT_NEAR(found->at_first_interval.low, 1.3 - 2.6562784602879, 1e-9);
  EXPECT_NEAR(found->at_first_interval.high, 1.3 + 2.6562784602879, 1e-9);
  EXPECT_NEAR(trend(x, y, 0.8)->at_first_interval.high, 1.3 + 1.366968876414, 1e-9);
}

TEST(Trend, of_an_exact_line_is_certain_and_of_a_constant_is_none) {
  const std::vector<double> x{1, 2, 3};
  const auto line = trend(x, std::vector<double>{1, 3, 5});
  ASSERT_TRUE(line);
  EXPECT_DOUBLE_EQ(line->slope, 2.0);
  EXPECT_EQ(line->slope_sd, 0.0);
  EXPECT_EQ(line->p, 0.0);
  EXPECT_EQ(line->r_squared, 1.0);
  EXPECT_DOUBLE_EQ(line->at_first, 1.0);
  const auto constant = trend(x, std::vector<double>{7, 7, 7});
  ASSERT_TRUE(constant);
  EXPECT_EQ(constant->slope, 0.0);
  EXPECT_EQ(constant->p, 1.0);
  EXPECT_EQ(constant->r_squared, 1.0);
  EXPECT_EQ(constant->at_first, 7.0);
}

// Williams's square: 0, 1, n − 1, 2 … in the first column, each row counted on from there.
TEST(LatinSquare, begins_each_run_at_the_next_step_of_the_zigzag) {
  using Square = std::vector<std::vector<std::size_t>>;
  EXPECT_EQ(latin_square(4), (Square{{0, 1, 2, 3}, {1, 2, 3, 0}, {3, 0, 1, 2}, {2, 3, 0, 1}}));
  EXPECT_EQ(latin_square(5),
            (Square{{0, 1, 2, 3, 4}, {1, 2, 3, 4, 0}, {4, 0, 1, 2, 3}, {2, 3, 4, 0, 1}, {3, 4, 0, 1, 2}}));
}

// Welch's test of the textbook's two samples, its interval, Hedges's g and the power from Student's shifted
// distribution: reference values from mpmath with 30 digits.
TEST(Comparison, equals_the_reference_in_every_figure) {
  const std::vector<double> a{27.5, 21.0, 19.0, 23.6, 17.0, 17.9, 16.9, 20.1, 21.9, 22.6, 23.1, 19.6, 19.0, 21.7, 21.4};
  const std::vector<double> b{27.1, 22.0, 20.8, 23.4, 23.4, 23.5, 25.8, 22.0, 24.8,
                              20.2, 21.9, 22.1, 22.9, 30.5, 27.5, 24.5, 22.9};
  const auto found = compare(a, b);
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->difference, 3.0211764705882, 1e-11);
  EXPECT_NEAR(found->t, 3.1229293102023, 1e-11);
  EXPECT_NEAR(found->degrees, 28.976667221414, 1e-9);
  EXPECT_NEAR(found->p, 0.0040393277834365, 1e-11);
  EXPECT_NEAR(found->interval.low, 1.0425163137935, 1e-9);
  EXPECT_NEAR(found->interval.high, 4.999836627383, 1e-9);
  EXPECT_NEAR(found->effect, 1.0824979366103, 1e-11);
  EXPECT_NEAR(found->power, 0.84054034395091, 1e-7);
  EXPECT_EQ(found->needed, 15U);  // 78.7 % with 14 of each, 81.6 % with 15

  const auto few = compare(std::vector{1.0, 2.0, 4.0}, std::vector{3.0, 3.5, 6.0, 9.0}, 0.9);
  ASSERT_TRUE(few);
  EXPECT_NEAR(few->difference, 3.0416666666667, 1e-11);
  EXPECT_NEAR(few->t, 1.8620267953489, 1e-11);
  EXPECT_NEAR(few->degrees, 4.7661174315406, 1e-10);
  EXPECT_NEAR(few->p, 0.12450460928131, 1e-10);
  EXPECT_NEAR(few->interval.low, -0.28598346850009, 1e-8);
  EXPECT_NEAR(few->interval.high, 6.3693168018334, 1e-8);
  EXPECT_NEAR(few->effect, 1.0950936430657, 1e-11);
  EXPECT_NEAR(few->power, 0.21594178946772, 1e-7);
  EXPECT_EQ(few->needed, 15U);  // 79.6 % with 14 of each, 82.5 % with 15
}

TEST(Comparison, of_equal_means_detects_nothing_however_many_there_are) {
  const auto found = compare(std::vector{1.0, 3.0}, std::vector{0.0, 4.0});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->difference, 0.0);
  EXPECT_NEAR(found->p, 1.0, 1e-12);
  EXPECT_NEAR(found->power, 0.05, 1e-6);
  EXPECT_GE(found->needed, 100'000U);
  // One sample without spread is no obstacle.
  EXPECT_TRUE(compare(std::vector{1.0, 1.0}, std::vector{0.0, 4.0}));
  EXPECT_FALSE(compare(std::vector{1.0, 2.0}, std::vector{1.0}));
}

TEST(Power, is_zero_for_a_single_value_on_either_side_and_equal_for_either_sign) {
  EXPECT_EQ(power_of(1.0, 10, 1), 0.0);
  EXPECT_GT(power_of(1.0, 2, 2), 0.0);
  EXPECT_DOUBLE_EQ(power_of(-0.8, 26, 26), power_of(0.8, 26, 26));
}

// Least squares of value = mean + unit + carrier + slope · run in exact fractions; tails of F from mpmath.
TEST(Crossed, of_a_latin_square_equals_the_exact_least_squares) {
  const std::vector<Trial> trials{{0, 0, 1, 101.2}, {1, 1, 1, 95.5}, {2, 2, 1, 99.0}, {0, 1, 2, 103.1}, {1, 2, 2, 98.7},
                                  {2, 0, 2, 93.0},  {0, 2, 3, 97.4}, {1, 0, 3, 97.9}, {2, 1, 3, 95.8}};
  const auto found = crossed(trials);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->confounded);
  EXPECT_DOUBLE_EQ(found->noise_degrees, 3.0);
  EXPECT_NEAR(found->noise_sd, 3.4278813238457, 1e-10);
  EXPECT_DOUBLE_EQ(found->unit.degrees, 2.0);
  EXPECT_NEAR(found->unit.f, 1.4366450230095, 1e-9);
  EXPECT_NEAR(found->unit.p, 0.36505618362685, 1e-9);
  EXPECT_NEAR(found->unit.sd, 1.3077640894214, 1e-9);
  EXPECT_DOUBLE_EQ(found->carrier.degrees, 2.0);
  EXPECT_NEAR(found->carrier.f, 0.069879594023829, 1e-9);
  EXPECT_NEAR(found->carrier.p, 0.93397956042149, 1e-9);
  EXPECT_EQ(found->carrier.sd, 0.0);  // explains less than the noise does
  EXPECT_NEAR(found->run.f, 0.30013238353401, 1e-9);
  EXPECT_NEAR(found->run.p, 0.62192904642522, 1e-9);
  EXPECT_NEAR(found->slope, -0.76666666666667, 1e-10);
  EXPECT_NEAR(found->run.sd, 0.62598071204459, 1e-10);
  EXPECT_NEAR(found->unit.ratio, 0.12346152132258, 1e-9);
  EXPECT_EQ(found->carrier.ratio, 0.0);
  EXPECT_NEAR(found->run.ratio, 0.028287509469275, 1e-9);
  EXPECT_NEAR(found->noise_ratio, 0.84825096920815, 1e-9);
  EXPECT_EQ(found->unit_effects.size(), 3U);
  EXPECT_EQ(found->carrier_effects.size(), 3U);
}

TEST(Crossed, of_an_incomplete_design_equals_the_exact_least_squares) {
  const std::vector<Trial> trials{{0, 0, 1, 10.0}, {1, 1, 1, 14.5}, {0, 1, 2, 13.0}, {1, 2, 2, 19.0},
                                  {0, 2, 3, 17.5}, {1, 0, 3, 11.0}, {0, 0, 4, 9.5},  {1, 1, 4, 12.0}};
  const auto found = crossed(trials);
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->confounded);
  EXPECT_DOUBLE_EQ(found->noise_degrees, 3.0);
  EXPECT_NEAR(found->noise_sd, 2.0 / 3.0, 1e-10);
  EXPECT_DOUBLE_EQ(found->unit.degrees, 1.0);
  EXPECT_NEAR(found->unit.f, 4.1186440677966, 1e-9);
  EXPECT_NEAR(found->unit.p, 0.13541652150795, 1e-9);
  EXPECT_NEAR(found->unit.sd, 0.58865610294378, 1e-9);
  EXPECT_NEAR(found->carrier.f, 82.62890625, 1e-8);
  EXPECT_NEAR(found->carrier.p, 0.0023807786784606, 1e-9);
  EXPECT_NEAR(found->carrier.sd, 3.6884709173766, 1e-9);
  EXPECT_NEAR(found->run.f, 5.5227272727273, 1e-9);
  EXPECT_NEAR(found->run.p, 0.1003013943669, 1e-9);
  EXPECT_NEAR(found->slope, -0.5, 1e-10);
  EXPECT_NEAR(found->run.sd, 0.55901699437495, 1e-10);
  EXPECT_NEAR(found->unit.ratio, 0.023559250359298, 1e-9);
  EXPECT_NEAR(found->carrier.ratio, 0.92497691164456, 1e-9);
  EXPECT_NEAR(found->run.ratio, 0.021246538622261, 1e-9);
  EXPECT_NEAR(found->noise_ratio, 0.030217299373882, 1e-9);
  // Effects are about their mean.
  EXPECT_NEAR(found->unit_effects[0] + found->unit_effects[1], 0.0, 1e-9);
}

TEST(Crossed, of_batteries_that_stayed_on_their_vehicles_is_the_result_of_both_together) {
  const std::vector<Trial> trials{{0, 0, 1, 10.0}, {1, 1, 1, 14.0}, {2, 2, 1, 12.0}, {0, 0, 2, 10.5}, {1, 1, 2, 14.1},
                                  {2, 2, 2, 12.1}, {0, 0, 3, 11.2}, {1, 1, 3, 15.3}, {2, 2, 3, 13.0}};
  const auto found = crossed(trials);
  ASSERT_TRUE(found);
  EXPECT_TRUE(found->confounded);
  for (const Factor& factor : {found->unit, found->carrier}) {
    EXPECT_DOUBLE_EQ(factor.degrees, 2.0);
    EXPECT_NEAR(factor.f, 168.91625615764, 1e-7);
    EXPECT_NEAR(factor.p, 2.5687391669459e-5, 1e-10);
    EXPECT_NEAR(factor.sd, 1.9461357723562, 1e-9);
  }
  EXPECT_NEAR(found->noise_sd, 0.26012817353502, 1e-10);
  EXPECT_NEAR(found->slope, 7.0 / 12.0, 1e-10);
  EXPECT_NEAR(found->unit.ratio, 0.92784880186548, 1e-9);
  EXPECT_EQ(found->carrier.ratio, 0.0);  // counted once
  EXPECT_NEAR(found->run.ratio, 0.055574206309601, 1e-9);
  EXPECT_NEAR(found->noise_ratio, 0.016576991824921, 1e-9);
  EXPECT_TRUE(found->unit_effects.empty());
  EXPECT_TRUE(found->carrier_effects.empty());
}

TEST(Crossed, of_one_run_only_has_no_slope_and_of_one_unit_no_unit_effect) {
  const std::vector<Trial> same_run{{0, 0, 1, 1.0}, {0, 1, 1, 2.0}, {1, 0, 1, 4.0}, {1, 1, 1, 5.5}};
  const auto flat = crossed(same_run);
  ASSERT_TRUE(flat);
  EXPECT_EQ(flat->slope, 0.0);
  EXPECT_EQ(flat->run.sd, 0.0);
  EXPECT_EQ(flat->run.degrees, 0.0);
  EXPECT_FALSE(flat->confounded);
  const std::vector<Trial> one_unit{{0, 0, 1, 1.0}, {0, 1, 2, 2.0}, {0, 0, 3, 2.5}, {0, 1, 4, 4.5}};
  const auto single = crossed(one_unit);
  ASSERT_TRUE(single);
  EXPECT_FALSE(single->confounded);
  EXPECT_EQ(single->unit.degrees, 0.0);
  EXPECT_EQ(single->unit.sd, 0.0);
  EXPECT_DOUBLE_EQ(single->noise_degrees, 1.0);
  // As many trials as unknowns leave nothing to estimate the noise from.
  EXPECT_FALSE(crossed(std::span{one_unit}.first(3)));
}

TEST(Effects, of_impossible_arguments_are_errors_of_the_program) {
  EXPECT_DEATH(static_cast<void>(trend(std::vector{1.0, 2.0, 3.0}, std::vector{1.0, 2.0, 3.0, 4.0})), "y.size");
  EXPECT_DEATH(static_cast<void>(latin_square(0)), "size > 0");
}

// x 0, 0.5, 1 about 0.5, y 0, 0.5, 0.5 about 1/3: Σxx 1/2, Σxy 1/4, Σyy 1/6; 1/24 is left on one degree of freedom, and
// √3 deviations from zero is two thirds of Cauchy's distribution.
TEST(Trend, of_values_below_one_equals_the_regression_by_hand) {
  const auto found = trend(std::vector{0.0, 0.5, 1.0}, std::vector{0.0, 0.5, 0.5});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->slope, 0.5, 1e-12);
  EXPECT_NEAR(found->slope_sd, std::sqrt(1.0 / 12.0), 1e-12);
  EXPECT_NEAR(found->p, 1.0 / 3.0, 1e-10);
  EXPECT_NEAR(found->r_squared, 0.75, 1e-12);
  EXPECT_NEAR(found->at_first, 7.0 / 12.0, 1e-12);
}

// Two deviations of 1, three values each: g is 0.8 times the difference. 80 % need an effect of 1.632 with seven of
// each, 1.507 with eight.
TEST(Comparison, needs_as_many_values_as_have_the_power) {
  const auto found = compare(std::vector{0.0, 1.0, 2.0}, std::vector{1.95, 2.95, 3.95});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->effect, 1.56, 1e-12);
  EXPECT_EQ(found->needed, 8U);
  const auto clear = compare(std::vector{0.0, 1.0}, std::vector{100.0, 101.0});
  ASSERT_TRUE(clear);
  EXPECT_NEAR(clear->effect, 100.0 * std::sqrt(2.0) * 4.0 / 7.0, 1e-9);
  EXPECT_NEAR(clear->power, 1.0, 1e-9);
  EXPECT_EQ(clear->needed, 2U);
}

/// Two units, three carriers and four runs, not all combinations; noise variance 4/9.
std::vector<Trial> incomplete_design(double scale) {
  std::vector<Trial> trials{{0, 0, 1, 10.0}, {1, 1, 1, 14.5}, {0, 1, 2, 13.0}, {1, 2, 2, 19.0},
                            {0, 2, 3, 17.5}, {1, 0, 3, 11.0}, {0, 0, 4, 9.5},  {1, 1, 4, 12.0}};
  for (Trial& trial : trials) trial.value *= scale;
  return trials;
}

// The normal equations in exact fractions.
TEST(Crossed, effects_of_an_incomplete_design_equal_the_exact_least_squares) {
  const auto found = crossed(incomplete_design(1.0));
  ASSERT_TRUE(found);
  ASSERT_EQ(found->unit_effects.size(), 2U);
  EXPECT_NEAR(found->unit_effects[0], -0.5, 1e-9);
  EXPECT_NEAR(found->unit_effects[1], 0.5, 1e-9);
  ASSERT_EQ(found->carrier_effects.size(), 3U);
  EXPECT_NEAR(found->carrier_effects[0], -31.0 / 9.0, 1e-9);
  EXPECT_NEAR(found->carrier_effects[1], -17.0 / 18.0, 1e-9);
  EXPECT_NEAR(found->carrier_effects[2], 79.0 / 18.0, 1e-9);
}

TEST(Crossed, ratios_and_tests_are_the_same_in_any_unit) {
  const auto large = crossed(incomplete_design(1.0));
  const auto small = crossed(incomplete_design(0.01));
  ASSERT_TRUE(large && small);
  EXPECT_NEAR(small->noise_sd, 0.02 / 3.0, 1e-12);
  EXPECT_NEAR(small->slope, -0.005, 1e-12);
  EXPECT_NEAR(small->unit.sd, 0.01 * large->unit.sd, 1e-12);
  EXPECT_NEAR(small->carrier.sd, 0.01 * large->carrier.sd, 1e-12);
  EXPECT_NEAR(small->run.sd, 0.01 * large->run.sd, 1e-12);
  for (const auto part : {&Crossed::unit, &Crossed::carrier, &Crossed::run}) {
    EXPECT_NEAR(((*small).*part).f, ((*large).*part).f, 1e-7);
    EXPECT_NEAR(((*small).*part).p, ((*large).*part).p, 1e-9);
    EXPECT_NEAR(((*small).*part).ratio, ((*large).*part).ratio, 1e-9);
  }
  EXPECT_NEAR(small->noise_ratio, large->noise_ratio, 1e-9);
}

TEST(Crossed, of_equal_values_explains_nothing) {
  const auto found = crossed(incomplete_design(0.0));
  ASSERT_TRUE(found);
  for (const Factor& factor : {found->unit, found->carrier, found->run}) {
    EXPECT_EQ(factor.f, 0.0);
    EXPECT_EQ(factor.p, 1.0);
    EXPECT_EQ(factor.sd, 0.0);
    EXPECT_EQ(factor.ratio, 0.0);
  }
  EXPECT_EQ(found->slope, 0.0);
  EXPECT_EQ(found->noise_sd, 0.0);
  EXPECT_EQ(found->noise_ratio, 0.0);
}

// Row means 1.5 and 4.75, column means 2.5 and 3.75; ±0.125 is left in each of the four.
TEST(Crossed, of_runs_numbered_zero_is_the_table_of_two_factors) {
  const auto found = crossed(std::vector<Trial>{{0, 0, 0, 1.0}, {0, 1, 0, 2.0}, {1, 0, 0, 4.0}, {1, 1, 0, 5.5}});
  ASSERT_TRUE(found);
  EXPECT_FALSE(found->confounded);
  EXPECT_DOUBLE_EQ(found->noise_degrees, 1.0);
  EXPECT_NEAR(found->noise_sd, 0.25, 1e-12);
  EXPECT_NEAR(found->unit_effects.at(0), -1.625, 1e-12);
  EXPECT_NEAR(found->unit_effects.at(1), 1.625, 1e-12);
  EXPECT_NEAR(found->carrier_effects.at(0), -0.625, 1e-12);
  EXPECT_NEAR(found->carrier_effects.at(1), 0.625, 1e-12);
  EXPECT_EQ(found->slope, 0.0);
}

// Each unit had its own run, so that one of its two degrees of freedom is the slope's; likewise for carriers.
TEST(Crossed, is_confounded_where_only_one_factor_is_determined_by_the_runs) {
  std::vector<Trial> trials;
  for (std::size_t u = 0; u < 3; ++u)
    for (std::size_t c = 0; c < 3; ++c)
      trials.push_back({u, c, static_cast<double>(u) + 1.0, static_cast<double>(u * u + 2 * c + u * c * c)});
  for (int exchanged = 0; exchanged < 2; ++exchanged) {
    const auto found = crossed(trials);
    ASSERT_TRUE(found);
    EXPECT_TRUE(found->confounded);
    EXPECT_DOUBLE_EQ(found->noise_degrees, 4.0);
    EXPECT_DOUBLE_EQ(found->unit.degrees, 3.0);
    EXPECT_DOUBLE_EQ(found->carrier.degrees, 3.0);
    EXPECT_TRUE(found->unit_effects.empty());
    for (Trial& trial : trials) std::swap(trial.unit, trial.carrier);
  }
}

}  // namespace
}  // namespace cosiva::statistics
