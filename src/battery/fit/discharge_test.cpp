#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "cosiva/battery/fit/discharge.h"
#include "cosiva/battery/fit/log.h"

namespace cosiva::battery {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

/// The log of a battery of 1 Ah under a current that depends on the time, sampled every `every_s`.
struct Tester {
  double every_s{10.0};
  double last_s{3600.0};
  double volt_at(double used_ah, double current_a) const { return 4.2 - used_ah - 0.05 * current_a; }

  template <class Current>
  Log log(const Current& current) const {
    Log log{"my.csv", {}, {}, {}, {}};
    double used_ah = 0.0;
    for (double t = 0.0; t <= last_s; t += 1.0) {
      used_ah += current(t) / 3600.0;
      if (std::fmod(t, every_s) != 0.0) continue;
      log.time_s.push_back(t);
      log.current_a.push_back(current(t));
      log.voltage_v.push_back(volt_at(used_ah, current(t)));
      log.counted_ah.push_back(used_ah);
    }
    return log;
  }
};

/// 20 s of 1 A in every 300 s, and 0.5 A for the last three minutes of each.
double pulses(double t) {
  const double within_s = std::fmod(t - 50.0, 300.0);
  if (t < 50.0) return 0.0;
  return within_s < 20.0 ? 1.0 : within_s < 120.0 ? 0.0 : 0.5;
}
double true_ah(double last_s) {
  double used_ah = 0.0;
  for (double t = 0.0; t <= last_s; t += 1.0) used_ah += pulses(t) / 3600.0;
  return used_ah;
}

TEST(Charge, uncertainty_between_samples_is_reported_and_correct) {
  for (const double every_s : {10.0, 30.0, 60.0}) {
    Log log = Tester{every_s}.log(pulses);
    log.counted_ah.clear();
    const auto all = discharges_from_full(log, 4.2);
    ASSERT_EQ(all.size(), 1U) << every_s;
    EXPECT_FALSE(all[0].is_counted);
    EXPECT_GT(all[0].uncertain, 0.005) << every_s;
    EXPECT_LT(all[0].uncertain, 0.5) << every_s;
    EXPECT_NEAR(all[0].used_ah.back(), true_ah(3600.0), all[0].uncertain * true_ah(3600.0)) << every_s;
  }
}

TEST(Charge, uncertainty_of_a_load_that_changes_with_each_sample_is_small_because_errors_cancel) {
  const auto drive = [](double t) { return t < 60.0 ? 0.0 : 0.5 + 0.4 * std::sin(t) + 0.1 * std::sin(7.1 * t); };
  const Tester tester{1.0};
  Log log = tester.log(drive);
  log.counted_ah.clear();
  const auto all = discharges_from_full(log, 4.2);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_LT(all[0].uncertain, 0.01);
}

TEST(Charge, of_a_steady_load_has_no_uncertainty) {
  const Log log = Tester{60.0}.log([](double t) { return t < 120.0 ? 0.0 : 1.0; });
  const auto all = discharges_from_full(log, 4.2);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_LT(all[0].uncertain, 0.02);
}

TEST(Charge, counted_by_the_tester_is_used) {
  const Log log = Tester{60.0}.log(pulses);
  const auto all = discharges_from_full(log, 4.2);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_TRUE(all[0].is_counted);
  EXPECT_EQ(all[0].uncertain, 0.0);
  EXPECT_NEAR(all[0].used_ah.back(), true_ah(3600.0), 1e-3);
}

TEST(Charge, counted_by_the_tester_is_ignored_if_it_contradicts_the_samples) {
  Log log = Tester{60.0}.log(pulses);
  for (double& counted_ah : log.counted_ah) counted_ah *= 4.0;
  const auto all = discharges_from_full(log, 4.2);
  ASSERT_EQ(all.size(), 1U);
  EXPECT_FALSE(all[0].is_counted);
}

TEST(Charge, with_uncertainty_is_scaled_to_a_known_capacity) {
  Log log = Tester{60.0}.log(pulses);
  log.counted_ah.clear();
  auto all = discharges_from_full(log, 4.2);
  const double capacity_ah = true_ah(3600.0);
  const double floor_v = lowest_under_load_v(all[0]);
  auto far = all;
  scale_to_capacity(far, 3.0 * capacity_ah, floor_v);
  EXPECT_EQ(far[0].scale, 1.0);  // this is another battery, not an inaccurate log
  auto high = all;
  scale_to_capacity(high, capacity_ah, floor_v - 0.5);
  EXPECT_EQ(high[0].scale, 1.0);  // not discharged to the end
  scale_to_capacity(all, capacity_ah, floor_v);
  EXPECT_NE(all[0].scale, 1.0);
  EXPECT_NEAR(*std::ranges::max_element(all[0].used_ah), capacity_ah, 1e-12);
}

TEST(Charge, a_tester_s_column_is_read_through_its_resets) {
  std::string text =
      "test_time_second,voltage_volt,current_ampere,step_index,discharging_capacity_ah,charging_capacity_ah\n";
  for (int t = 0; t <= 3000; t += 60) {
    const bool second = t > 1500;  // another step: its count restarts at zero
    const double counted_ah = (second ? t - 1500 : t) / 3600.0;
    text += std::to_string(t) + "," + std::to_string(4.1 - 0.0003 * t) + ",-1.0," + (second ? "2," : "1,") +
            std::to_string(counted_ah) + ",0\n";
  }
  const auto logs = read_logs(text, "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  EXPECT_NEAR(logs->front().counted_ah.back(), 3000.0 / 3600.0, 1e-4);
}

TEST(Charge, a_column_rounded_to_hundredths_is_no_better_than_the_samples) {
  std::string text = "test_time_second,voltage_volt,current_ampere,discharging_capacity_ah,charging_capacity_ah\n";
  for (int t = 0; t <= 3000; t += 10)
    text +=
        std::to_string(t) + "," + std::to_string(4.1 - 0.0003 * t) + ",-1.0,0." + (t < 360 ? "0" : "8") + "1,0.00\n";
  const auto logs = read_logs(text, "my.csv");
  ASSERT_TRUE(logs) << to_string(logs.error());
  EXPECT_TRUE(logs->front().counted_ah.empty());
}

TEST(Full, is_not_the_voltage_that_a_regeneration_reaches) {
  // Charged to 4.2 V, rested, discharged; a regeneration pulse of 10 s reaches 4.35 V.
  Log log{"my.csv", {}, {}, {}, {}};
  double used_ah = 1.0;
  for (int t = 0; t <= 9000; t += 10) {
    const bool charges = t < 3600;
    const bool regenerates = t == 4500;
    const double current_a = charges ? -1.0 : regenerates ? -5.0 : t < 3900 ? 0.0 : 0.7;
    used_ah = std::max(0.0, used_ah + current_a * 10.0 / 3600.0);
    log.time_s.push_back(t);
    log.current_a.push_back(current_a);
    log.voltage_v.push_back(regenerates ? 4.35 : charges ? 4.2 - used_ah : 4.18 - used_ah);
  }
  EXPECT_NEAR(highest_voltage_v({log}), 4.2, 1e-9);
  EXPECT_EQ(discharges_from_full(log, highest_voltage_v({log})).size(), 1U);
}

/// Two discharges with a charge between them.
Log two_discharges() {
  return Tester{10.0, 9000.0}.log([](double t) {
    if (t < 100.0) return 0.0;
    if (t < 2800.0) return 1.0;
    if (t < 5500.0) return -1.0;
    return t < 5800.0 ? 0.0 : 0.5;
  });
}

TEST(Log, is_split_into_its_discharges_each_of_which_still_begins_full) {
  const Log log = two_discharges();
  const auto parts = split_at_charges(log, 4.2);
  ASSERT_EQ(parts.size(), 2U);
  EXPECT_EQ(parts[1].name, "my.csv, discharge 2");
  const auto whole = discharges_from_full(log, 4.2);
  ASSERT_EQ(whole.size(), 2U);
  for (std::size_t k = 0; k < 2; ++k) {
    const auto own = discharges_from_full(parts[k], 4.2);
    ASSERT_EQ(own.size(), 1U) << k;
    EXPECT_NEAR(own[0].used_ah.back(), whole[k].used_ah.back(), 1e-9) << k;
    EXPECT_EQ(load_on_s(own[0]), load_on_s(whole[k])) << k;
  }
  EXPECT_EQ(split_at_charges(parts[0], 4.2).size(), 1U);
  EXPECT_EQ(split_at_charges(parts[0], 4.2)[0].name, parts[0].name);
}

}  // namespace
}  // namespace cosiva::battery
