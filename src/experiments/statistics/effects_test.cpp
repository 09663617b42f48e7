#include "cosiva/experiments/statistics/effects.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <set>
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

}  // namespace
}  // namespace cosiva::statistics
