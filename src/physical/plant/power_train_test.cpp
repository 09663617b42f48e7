#include "cosiva/physical/plant/power_train.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

namespace cosiva::physical {
namespace {

using ::testing::HasSubstr;

PowerTrain usual(std::uint64_t seed = 1) { return {PowerTrain::usual_table(), Random{seed, "gauge"}}; }

Result<BatteryChange> change(const std::string& json) { return battery_change_from_json(*JsonValue::parse(json)); }

TEST(PowerTrain, has_a_two_cell_pack_that_lasts_hours) {
  PowerTrain train = usual();
  EXPECT_NEAR(train.pack().open_circuit_v(), 2.0 * 4.103, 0.002);  // 3.685 + 0.2156 − 0.1178 + 0.3201 a cell
  double seconds = 0.0;
  for (; !train.cut_off() && seconds < 1e6; seconds += 1.0) train.draw(0.5, 1.0);
  EXPECT_NEAR(train.pack().delivered_j(), 3.5 * seconds, 10.0);
  EXPECT_GT(seconds, 3600.0 * 4.0);  // 2.2 Ah at 7.6 V hold 60 kJ: 4.7 h at 3.5 W
  EXPECT_LT(seconds, 3600.0 * 4.8);
}

TEST(PowerTrain, once_cut_off_gives_nothing_until_the_battery_is_changed) {
  PowerTrain train = usual();
  ASSERT_TRUE(change(R"({"id":"B2","charge":0.005})"));
  train.change(*change(R"({"id":"B2","charge":0.005})"));
  for (int i = 0; i < 5000 && !train.cut_off(); ++i) train.draw(1.0, 0.1);
  ASSERT_TRUE(train.cut_off());
  const double charge = train.pack().charge();
  for (int i = 0; i < 100; ++i) train.draw(0.0, 0.1);
  EXPECT_TRUE(train.cut_off());
  EXPECT_EQ(train.pack().current_a(), 0.0);
  EXPECT_EQ(train.pack().charge(), charge);
  train.change(*change(R"({"id":"B3"})"));
  EXPECT_FALSE(train.cut_off());
  EXPECT_EQ(train.pack().history().id, "B3");
  EXPECT_EQ(train.gauge().charge, 1.0);
}

TEST(PowerTrain, consumes_energy_for_friction_and_acceleration_and_recovers_none) {
  const CartModel cart;
  EXPECT_DOUBLE_EQ(cart.drive_energy_j(2.0, 0.5, 0.0, 4.0), cart.rolling_force_n * 2.0 / cart.drive_efficiency);
  EXPECT_DOUBLE_EQ(cart.drive_energy_j(-2.0, -0.5, 0.0, 4.0), cart.drive_energy_j(2.0, 0.5, 0.0, 4.0));
  EXPECT_EQ(cart.drive_energy_j(0.005, 0.5, -2.0, 0.01), 0.0);
  EXPECT_EQ(cart.drive_energy_j(0.0, 0.0, 0.0, 1.0), 0.0);
  // ∫ m a v dt over a start to 0.5 m/s is ½ m v².
  double joule = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double v = 0.5 * (i + 0.5) / 1000.0;
    joule += cart.drive_energy_j(v * 0.001, v, 0.5, 0.001);
  }
  EXPECT_NEAR(joule, (0.5 * 1.2 * 0.25 + 0.6 * 0.25) / 0.6, 1e-3);
}

TEST(PowerTrain, consumes_more_with_a_higher_load_factor) {
  PowerTrain heavy = usual();
  heavy.set_load_factor(1.1);
  heavy.draw(0.05, 0.1);
  EXPECT_NEAR(heavy.load_w(), 1.1 * 3.5, 1e-12);
}

TEST(PowerTrain, reports_the_gauge_s_estimate_and_not_the_ground_truth) {
  double sum_sq = 0.0;
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    PowerTrain train = usual(seed);
    for (int i = 0; i < 1440; ++i) train.draw(2.5, 5.0);
    const double used = 1.0 - train.pack().charge();
    EXPECT_EQ(train.readings().charge, train.gauge().charge);
    const double error = train.gauge().charge - train.pack().charge();
    sum_sq += error * error / (used * used);
  }
  // A gain of 1 %, and an offset of 5 mA on 0.45 A.
  EXPECT_NEAR(std::sqrt(sum_sq / 100.0), 0.015, 0.005);
}

TEST(BatteryChange, may_be_of_any_type) {
  const auto leaf =
      change(R"({"id":"L1","type":"leaf33","scale":0.1,"cycles":12,"seed":7,"spread":true,"gauge":"kalman"})");
  ASSERT_TRUE(leaf) << to_string(leaf.error());
  EXPECT_EQ(leaf->type.name, "leaf33");
  EXPECT_EQ(leaf->design.series, 1U);
  EXPECT_EQ(leaf->history.cycles, 12.0);
  EXPECT_EQ(leaf->gauge, battery::GaugeMethod::kalman);
  PowerTrain train = usual();
  train.change(*leaf);
  EXPECT_NEAR(train.pack().open_circuit_v(), 4.178, 1e-9);
  EXPECT_NEAR(train.pack().capacity_ah(), 3.05, 0.15);
}

TEST(BatteryChange, that_is_invalid_is_refused) {
  EXPECT_THAT(to_string(change("{}").error()), HasSubstr("'id'"));
  EXPECT_THAT(to_string(change("[]").error()), HasSubstr("expected an object"));
  EXPECT_THAT(to_string(change(R"({"id":"B","charge":80})").error()), HasSubstr("'charge'"));
  EXPECT_THAT(to_string(change(R"({"id":"B","type":"aa"})").error()), HasSubstr("there are leaf33, lipo850"));
  EXPECT_THAT(to_string(change(R"({"id":"B","type":7})").error()), HasSubstr("'type'"));
  EXPECT_THAT(to_string(change(R"({"id":"B","type":"{}"})").error()), HasSubstr("'format'"));
  EXPECT_THAT(to_string(change(R"({"id":"B","gauge":"magic"})").error()), HasSubstr("counter, rest or kalman"));
  EXPECT_EQ(change(R"({"id":"B","scale":0})").error().code, "plant.battery");
}

}  // namespace
}  // namespace cosiva::physical
