#include "cosiva/experiments/statistics/survival.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/statistics/sample.h"
#include "cosiva/experiments/statistics/tolerance.h"

namespace cosiva::statistics {
namespace {

// Remission of leukaemia under 6-MP in weeks, the textbooks' example (Freireich et al. 1963).
const std::vector<Duration> remissions{{6, true},   {6, true},   {6, true},   {6, false}, {7, true},   {9, false},
                                       {10, true},  {10, false}, {11, false}, {13, true}, {16, true},  {17, false},
                                       {19, false}, {20, false}, {22, true},  {23, true}, {25, false}, {32, false},
                                       {32, false}, {34, false}, {35, false}};

TEST(KaplanMeier, equals_the_textbook_s_curve) {
  const Survival curve = kaplan_meier(remissions, 0.95, SurvivalBand::log_log);
  ASSERT_EQ(curve.steps.size(), 7U);
  const std::vector<double> at{6, 7, 10, 13, 16, 22, 23};
  const std::vector<double> ratio{0.8571, 0.8067, 0.7529, 0.6902, 0.6275, 0.5378, 0.4482};
  for (std::size_t i = 0; i < at.size(); ++i) {
    EXPECT_EQ(curve.steps[i].at, at[i]);
    EXPECT_NEAR(curve.steps[i].ratio, ratio[i], 5e-5);
    EXPECT_LT(curve.steps[i].band.low, ratio[i]);
    EXPECT_GT(curve.steps[i].band.high, ratio[i]);
  }
  // log-log 95 % band at 6 weeks, as R's survival gives it (conf.type = "log-log").
  EXPECT_NEAR(curve.steps[0].band.low, 0.620, 0.001);
  EXPECT_NEAR(curve.steps[0].band.high, 0.952, 0.001);
  EXPECT_EQ(curve.when_ended(0.5), 23.0);
  EXPECT_EQ(curve.when_ended(0.1), 6.0);
  EXPECT_EQ(curve.when_ended(0.6), std::nullopt);
  EXPECT_NEAR(curve.restricted_mean, 23.29, 0.01);
  EXPECT_NEAR(curve.restricted_mean_sd, 2.83, 0.01);
}

// No duration is censored before the first three remissions end: the band is Wilson's interval of 18 of 21 there.
TEST(KaplanMeier, has_wilson_s_interval_of_a_ratio_as_its_band) {
  const Survival curve = kaplan_meier(remissions);
  EXPECT_NEAR(curve.steps[0].band.low, 0.6536, 1e-4);
  EXPECT_NEAR(curve.steps[0].band.high, 0.9502, 1e-4);
  EXPECT_EQ(curve.band_at(6.0), curve.steps[0].band);
  EXPECT_EQ(curve.band_at(6.9), curve.steps[0].band);
  EXPECT_EQ(curve.band_at(1000.0), curve.steps.back().band);
  // Before the first end, 21 of 21 are running: from 21/(21 + z²) to 1.
  EXPECT_NEAR(curve.band_at(5.9).low, 0.8454, 1e-4);
  EXPECT_DOUBLE_EQ(curve.band_at(5.9).high, 1.0);
  for (const SurvivalStep& step : curve.steps) {
    EXPECT_LT(step.band.low, step.ratio);
    EXPECT_GT(step.band.high, step.ratio);
  }
  // The same ratio of the two that are left is less certain than that of all four.
  const Interval detected =
      kaplan_meier(std::vector<Duration>{{1, true}, {2, true}, {3, true}, {4, true}}).steps[1].band;
  const Interval censored =
      kaplan_meier(std::vector<Duration>{{0.5, false}, {0.5, false}, {3, true}, {4, true}}).steps[0].band;
  EXPECT_LT(detected.high - detected.low, censored.high - censored.low);
}

TEST(KaplanMeier, has_a_wide_band_for_a_ratio_that_few_durations_reached) {
  const Survival curve = kaplan_meier(std::vector<Duration>{{1, true}, {2, true}, {4, true}});
  EXPECT_EQ(curve.steps[2].ratio, 0.0);
  EXPECT_EQ(curve.steps[2].band.low, 0.0);
  EXPECT_GT(curve.steps[2].band.high, 0.5);
  EXPECT_LT(curve.steps[2].band.high, 0.7);
  EXPECT_EQ(kaplan_meier(std::vector<Duration>{{1, true}}).steps[0].band.low, 0.0);
  EXPECT_EQ(kaplan_meier({}).band_at(3.0), (Interval{1.0, 1.0}));
}

TEST(KaplanMeier, band_contains_the_true_curve_about_as_often_as_stated) {
  Random random{5, "bands"};
  constexpr int fleets = 1000;
  double wilson = 0.0;
  double log_log = 0.0;
  for (int fleet = 0; fleet < fleets; ++fleet) {
    std::vector<Duration> durations;
    for (int i = 0; i < 12; ++i) {
      const double end = random.uniform(1.0, 2.0);
      const double failure = random.uniform(0.0, 6.0);
      durations.push_back({std::min(end, failure), end <= failure});
    }
    const Survival best = kaplan_meier(durations);
    const Survival usual = kaplan_meier(durations, 0.95, SurvivalBand::log_log);
    for (const double ratio : {0.9, 0.75, 0.5, 0.25, 0.1}) {
      const auto holds = [&](const Survival& curve) {
        const Interval band = curve.band_at(2.0 - ratio);
        return band.low <= ratio && ratio <= band.high ? 1.0 / (5.0 * fleets) : 0.0;
      };
      wilson += holds(best);
      log_log += holds(usual);
    }
  }
  EXPECT_NEAR(wilson, 0.95, 0.012);
  EXPECT_LT(log_log, 0.90) << "no clear difference";
}

TEST(KaplanMeier, without_censoring_is_the_plain_ratio_and_the_plain_mean) {
  const Survival curve = kaplan_meier(std::vector<Duration>{{1, true}, {2, true}, {4, true}, {5, true}});
  ASSERT_EQ(curve.steps.size(), 4U);
  EXPECT_DOUBLE_EQ(curve.steps[1].ratio, 0.5);
  EXPECT_DOUBLE_EQ(curve.steps[3].ratio, 0.0);
  EXPECT_DOUBLE_EQ(curve.restricted_mean, 3.0);
  EXPECT_EQ(kaplan_meier(std::vector<Duration>{{1, true}, {2, true}, {4, true}, {5, true}}, 0.95, SurvivalBand::log_log)
                .steps[3]
                .band,
            (Interval{0.0, 0.0}));
  EXPECT_TRUE(kaplan_meier({}).steps.empty());
}

TEST(CensoredNormal, without_censoring_is_the_usual_mean_and_deviation) {
  const std::vector<double> values{3490.71, 3652.06, 3602.42, 3619.98, 3598.24, 3646.51, 3595.89, 3591.32, 3651.98};
  std::vector<Duration> durations;
  for (const double value : values) durations.push_back({value, true});
  const auto fit = censored_normal(durations);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->mean, 3605.46, 0.01);
  EXPECT_NEAR(fit->sd, 49.69, 0.01);
  EXPECT_NEAR(fit->mean_interval.low, mean_interval(values)->low, 0.05);
  EXPECT_NEAR(fit->mean_interval.high, mean_interval(values)->high, 0.05);
  EXPECT_NEAR(fit->effective_size, 9.0, 1e-3);
  EXPECT_NEAR(fit->tolerance_low, 3454.8, 0.1);
}

// Cells 6 and 9 of the nine (there is no cell 8): their vehicles fail at 2000 and 3000 s. Such a failure is no short
// autonomy, but no autonomy at all.
TEST(CensoredNormal, does_not_count_a_failure_as_an_end) {
  std::vector<Duration> durations{{3490.71, true}, {3652.06, true}, {3602.42, true}, {3619.98, true}, {3598.24, true},
                                  {2000.0, false}, {3595.89, true}, {3000.0, false}, {3651.98, true}};
  const auto fit = censored_normal(durations);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->mean, 3602.0, 1.0);
  EXPECT_EQ(fit->ended, 7U);
  double plain = 0.0;
  for (const Duration& one : durations) plain += one.value / 9.0;
  EXPECT_NEAR(plain, 3357.0, 0.5);
  EXPECT_EQ(kaplan_meier(durations).when_ended(0.5), 3602.42);
}

TEST(CensoredNormal, estimates_the_true_values_behind_a_limit) {
  Random random{3, "censored"};
  std::vector<Duration> durations;
  for (int i = 0; i < 20'000; ++i) {
    const double value = random.gaussian(100.0, 10.0);
    durations.push_back({std::min(value, 105.0), value < 105.0});
  }
  const auto fit = censored_normal(durations);
  EXPECT_NEAR(fit->mean, 100.0, 0.3);
  EXPECT_NEAR(fit->sd, 10.0, 0.3);
  EXPECT_LT(fit->effective_size, 20'000.0);
}

TEST(CensoredNormal, is_nothing_for_too_few_values) {
  EXPECT_FALSE(censored_normal({}));
  EXPECT_FALSE(censored_normal(std::vector<Duration>{{5, true}, {6, false}}));
  EXPECT_FALSE(censored_normal(std::vector<Duration>{{5, true}, {5, true}, {6, false}}));
}

// The bands at 6, 13 and 23 weeks by their formulas with 30 digits.
TEST(KaplanMeier, bands_equal_the_reference_along_the_curve) {
  const Survival log_log = kaplan_meier(remissions, 0.95, SurvivalBand::log_log);
  const Survival wilson = kaplan_meier(remissions);
  struct Row {
    std::size_t step;
    std::size_t at_risk;
    std::size_t ended;
    double ratio;
    Interval log_log;
    Interval wilson;
  };
  for (const Row& row :
       {Row{0, 21, 3, 0.85714285714286, {0.61971795526598, 0.951551747647}, {0.65363939719379, 0.95018987500275}},
        Row{3, 12, 1, 0.69019607843137, {0.43161022248618, 0.84906596334945}, {0.46440028035267, 0.85128465463912}},
        Row{6, 6, 1, 0.44817927170868, {0.18805200595923, 0.68014262849524}, {0.22624213453275, 0.69287469526}}}) {
    EXPECT_EQ(wilson.steps[row.step].at_risk, row.at_risk);
    EXPECT_EQ(wilson.steps[row.step].ended, row.ended);
    EXPECT_NEAR(wilson.steps[row.step].ratio, row.ratio, 1e-12);
    EXPECT_NEAR(log_log.steps[row.step].band.low, row.log_log.low, 1e-10);
    EXPECT_NEAR(log_log.steps[row.step].band.high, row.log_log.high, 1e-10);
    EXPECT_NEAR(wilson.steps[row.step].band.low, row.wilson.low, 1e-10);
    EXPECT_NEAR(wilson.steps[row.step].band.high, row.wilson.high, 1e-10);
  }
  EXPECT_NEAR(wilson.restricted_mean, 23.287394957983, 1e-10);
  EXPECT_NEAR(wilson.restricted_mean_sd, 2.8274676233714, 1e-10);
  EXPECT_EQ(wilson.restricted_to, 35.0);
  EXPECT_EQ(log_log.band_at(1.0), (Interval{1.0, 1.0}));
  // 90 %: narrower.
  const Survival less = kaplan_meier(remissions, 0.9);
  EXPECT_NEAR(less.steps[3].band.low, 0.50022014957793, 1e-10);
  EXPECT_NEAR(less.steps[3].band.high, 0.83218487390324, 1e-10);
}

TEST(KaplanMeier, of_censored_durations_only_has_no_end) {
  const Survival curve = kaplan_meier(std::vector<Duration>{{2, false}, {3, false}});
  EXPECT_TRUE(curve.steps.empty());
  EXPECT_EQ(curve.restricted_mean, 3.0);
  EXPECT_EQ(curve.restricted_mean_sd, 0.0);
  EXPECT_EQ(curve.when_ended(0.1), std::nullopt);
}

// Maximum likelihood and its observed information by Newton's method with 30 digits: seven ends, and two units that ran
// 3580 s and 3610 s without an end.
TEST(CensoredNormal, equals_the_maximum_of_the_likelihood) {
  const std::vector<Duration> durations{{3490.71, true}, {3652.06, true}, {3602.42, true},
                                        {3619.98, true}, {3598.24, true}, {3580.0, false},
                                        {3595.89, true}, {3610.0, false}, {3651.98, true}};
  const auto fit = censored_normal(durations);
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->mean, 3610.536852603, 1e-5);
  EXPECT_NEAR(fit->sd, 54.165204668422, 1e-5);
  EXPECT_NEAR(fit->effective_size, 7.9525718321826, 1e-6);
  EXPECT_NEAR(fit->mean_interval.low, 3563.5382535468, 1e-4);
  EXPECT_NEAR(fit->mean_interval.high, 3657.5354516592, 1e-4);
  EXPECT_NEAR(fit->tolerance_low, 3427.871740098, 1e-3);
  EXPECT_EQ(fit->ended, 7U);
  const auto less = censored_normal(durations, 0.9);
  EXPECT_NEAR(less->mean_interval.low, 3573.2135829253, 1e-4);
  EXPECT_NEAR(less->mean_interval.high, 3647.8601222807, 1e-4);
}

// Where all end at once no number of durations has Greenwood's variance, which is 0: the band is that of one duration.
TEST(KaplanMeier, of_durations_that_all_end_at_once_has_the_band_of_one) {
  const double z = 1.959963984540054;
  for (const std::size_t number : {1U, 3U}) {
    const Survival curve = kaplan_meier(std::vector<Duration>(number, Duration{2.0, true}));
    ASSERT_EQ(curve.steps.size(), 1U);
    EXPECT_EQ(curve.steps[0].band.low, 0.0);
    EXPECT_NEAR(curve.steps[0].band.high, z * z / (1.0 + z * z), 1e-12);
    EXPECT_EQ(curve.restricted_mean, 2.0);
    EXPECT_EQ(curve.restricted_mean_sd, 0.0);
  }
}

// A unit that still runs forty deviations after the others' ends: its tail is below the smallest number at first.
TEST(CensoredNormal, of_a_duration_far_beyond_the_ends_is_at_the_maximum_of_the_likelihood) {
  const std::vector<Duration> durations{{10.0, true}, {10.02, true}, {10.01, true}, {10.41, false}};
  const auto fit = censored_normal(durations);
  ASSERT_TRUE(fit);
  const auto log_likelihood = [&](double mean, double sd) {
    double sum = 0.0;
    for (const Duration& one : durations) {
      const double z = (one.value - mean) / sd;
      sum += one.ended ? -0.5 * z * z - std::log(sd) : std::log(0.5 * std::erfc(z / std::sqrt(2.0)));
    }
    return sum;
  };
  const double sd = fit->sd * std::sqrt(2.0 / 3.0);  // without the correction for three ends
  const double best = log_likelihood(fit->mean, sd);
  EXPECT_TRUE(std::isfinite(best));
  for (const double step : {-0.01 * sd, 0.01 * sd}) {
    EXPECT_GT(best, log_likelihood(fit->mean + step, sd)) << step;
    EXPECT_GT(best, log_likelihood(fit->mean, sd + step)) << step;
  }
}

TEST(KaplanMeier, of_no_durations_is_zero_throughout) {
  const Survival curve = kaplan_meier({});
  EXPECT_EQ(curve.restricted_mean, 0.0);
  EXPECT_EQ(curve.restricted_mean_sd, 0.0);
  EXPECT_EQ(curve.restricted_to, 0.0);
  EXPECT_EQ(curve.when_ended(0.5), std::nullopt);
}

TEST(KaplanMeier, reaches_a_ratio_at_the_end_that_reaches_it_exactly) {
  const Survival curve = kaplan_meier(std::vector<Duration>{{1, true}, {2, true}, {4, true}, {5, true}});
  EXPECT_EQ(curve.when_ended(0.25), 1.0);
  EXPECT_EQ(curve.when_ended(0.5), 2.0);
  EXPECT_EQ(curve.when_ended(0.75), 4.0);
  EXPECT_EQ(curve.when_ended(1.0), 5.0);
  EXPECT_EQ(curve.when_ended(0.51), 4.0);
}

// At equal times an end comes first: both were still running before it.
TEST(KaplanMeier, counts_a_duration_censored_at_the_time_of_an_end_as_at_risk) {
  for (const bool first : {true, false}) {
    const Survival curve = kaplan_meier(std::vector<Duration>{{3, first}, {3, !first}, {5, true}});
    ASSERT_EQ(curve.steps.size(), 2U);
    EXPECT_EQ(curve.steps[0].at_risk, 3U);
    EXPECT_EQ(curve.steps[0].ended, 1U);
    EXPECT_DOUBLE_EQ(curve.steps[0].ratio, 2.0 / 3.0);
    EXPECT_EQ(curve.steps[1].at_risk, 1U);
    EXPECT_DOUBLE_EQ(curve.restricted_mean, 3.0 + 2.0 * 2.0 / 3.0);
  }
}

// Of 10 and 12: mean 11, deviation √2, and one degree of freedom, whose t is 12.706.
TEST(CensoredNormal, of_two_ends_is_the_usual_interval) {
  const auto fit = censored_normal(std::vector<Duration>{{10, true}, {12, true}});
  ASSERT_TRUE(fit);
  EXPECT_NEAR(fit->mean, 11.0, 1e-8);
  EXPECT_NEAR(fit->sd, std::sqrt(2.0), 1e-8);
  EXPECT_NEAR(fit->effective_size, 2.0, 1e-6);
  EXPECT_NEAR(fit->mean_interval.low, 11.0 - 12.706204736, 1e-5);
  EXPECT_NEAR(fit->mean_interval.high, 11.0 + 12.706204736, 1e-5);
  EXPECT_NEAR(fit->tolerance_low, 11.0 - std::sqrt(2.0) * tolerance_factor(2), 1e-4);
}

// Among 2000 ends one unit still runs after about thirty deviations. At the maximum of the likelihood both derivatives
// are zero: Σz + h and Σ(z² − 1) + z·h, with h the density over the upper tail.
TEST(CensoredNormal, of_many_ends_and_one_far_duration_has_both_derivatives_zero) {
  std::vector<Duration> durations{{140.0, false}};
  for (int i = 0; i < 1000; ++i) {
    durations.push_back({99.0, true});
    durations.push_back({101.0, true});
  }
  const auto fit = censored_normal(durations);
  ASSERT_TRUE(fit);
  const double sd = fit->sd * std::sqrt(1999.0 / 2000.0);  // without the correction for 2000 ends
  const double far = (140.0 - fit->mean) / sd;
  ASSERT_GT(far, 29.0);
  ASSERT_LT(far, 31.0);
  const double h = std::exp(-0.5 * far * far) / std::sqrt(2.0 * pi) / (0.5 * std::erfc(far / std::sqrt(2.0)));
  double by_mean = h;
  double by_sd = far * h;
  for (std::size_t i = 1; i < durations.size(); ++i) {
    const double z = (durations[i].value - fit->mean) / sd;
    by_mean += z;
    by_sd += z * z - 1.0;
  }
  EXPECT_NEAR(by_mean, 0.0, 1e-3);
  EXPECT_NEAR(by_sd, 0.0, 0.02);
}

}  // namespace
}  // namespace cosiva::statistics
