#include "physical/plant/battery.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

namespace cosiva::physical {
namespace {

TEST(Battery, is_a_two_cell_pack) {
  const Battery battery;
  EXPECT_NEAR(battery.open_circuit_v(1.0), 2.0 * 4.103, 0.002);  // 3.685 + 0.2156 − 0.1178 + 0.3201
  EXPECT_NEAR(battery.open_circuit_v(0.0), 2.0 * 2.654, 0.001);
  EXPECT_GT(battery.resistance_ohm(0.02), battery.resistance_ohm(0.5));
}

TEST(Battery, gives_what_the_load_asks_for) {
  Battery battery{{}, 0.7};
  battery.draw(0.5, 0.1);  // 5 W over the idle load
  EXPECT_NEAR(battery.voltage_v() * battery.current_a(), 8.0, 1e-9);
  EXPECT_LT(battery.voltage_v(), battery.open_circuit_v(0.7));
  EXPECT_DOUBLE_EQ(battery.delivered_j(), battery.voltage_v() * battery.current_a() * 0.1);
}

TEST(Battery, conserves_energy_until_it_is_empty) {
  Battery battery;
  double stored_j = 0.0;
  double seconds = 0.0;
  while (!battery.empty() && seconds < 1e6) {
    const double before = battery.charge();
    battery.draw(0.5, 1.0);
    const double middle = 0.5 * (before + battery.charge());
    stored_j += battery.open_circuit_v(middle) * (before - battery.charge()) * 3600.0 * battery.model().capacity_ah;
    seconds += 1.0;
  }
  EXPECT_NEAR(battery.delivered_j() + battery.lost_j(), stored_j, 1e-3 * stored_j);
  EXPECT_NEAR(battery.delivered_j(), 3.5 * seconds, 10.0);
  EXPECT_GT(seconds, 3600.0 * 4.0);  // 2.2 Ah at 7.6 V hold 60 kJ: 4.7 h at 3.5 W
  EXPECT_LT(seconds, 3600.0 * 4.8);
  EXPECT_LT(battery.charge(), 0.03);
  EXPECT_GE(battery.charge(), 0.0);
}

TEST(Battery, once_empty_gives_nothing) {
  Battery battery{{}, 0.001};
  battery.draw(1.0, 0.1);
  ASSERT_TRUE(battery.empty());
  const double charge = battery.charge();
  for (int i = 0; i < 100; ++i) battery.draw(0.0, 0.1);
  EXPECT_TRUE(battery.empty());
  EXPECT_EQ(battery.current_a(), 0.0);
  EXPECT_EQ(battery.charge(), charge);
}

TEST(Battery, pays_friction_and_speeding_up_and_gets_nothing_back) {
  const Battery battery;
  const BatteryModel& model = battery.model();
  EXPECT_DOUBLE_EQ(battery.drive_energy_j(2.0, 0.5, 0.0, 4.0), model.rolling_force_n * 2.0 / model.drive_efficiency);
  EXPECT_DOUBLE_EQ(battery.drive_energy_j(-2.0, -0.5, 0.0, 4.0), battery.drive_energy_j(2.0, 0.5, 0.0, 4.0));
  EXPECT_EQ(battery.drive_energy_j(0.005, 0.5, -2.0, 0.01), 0.0);
  EXPECT_EQ(battery.drive_energy_j(0.0, 0.0, 0.0, 1.0), 0.0);
  // ∫ m a v dt over a start to 0.5 m/s is ½ m v².
  double joule = 0.0;
  for (int i = 0; i < 1000; ++i) {
    const double v = 0.5 * (i + 0.5) / 1000.0;
    joule += battery.drive_energy_j(v * 0.001, v, 0.5, 0.001);
  }
  EXPECT_NEAR(joule, (0.5 * 1.2 * 0.25 + 0.6 * 0.25) / 0.6, 1e-3);
}

TEST(Battery, warms_towards_what_its_losses_and_the_room_settle_at) {
  Battery battery;
  for (int i = 0; i < 3600; ++i) battery.draw(5.0, 1.0);
  const double heat_w = battery.resistance_ohm(battery.charge()) * battery.current_a() * battery.current_a();
  const BatteryModel& model = battery.model();
  EXPECT_NEAR(battery.temperature_c(), model.ambient_c + heat_w / model.heat_loss_w_per_k, 0.15);
  EXPECT_GT(battery.temperature_c(), model.ambient_c + 0.2);
}

TEST(Gauge, errs_by_its_gain_and_no_more) {
  double sum_sq = 0.0;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    Battery battery;
    BatteryGauge gauge{Random{seed, "gauge"}};
    for (int i = 0; i < 7200; ++i) {
      battery.draw(0.5, 1.0);
      gauge.count(battery, 1.0);
    }
    const double used = 1.0 - battery.charge();
    const double error = gauge.read(battery).charge - battery.charge();
    sum_sq += error * error / (used * used);
  }
  EXPECT_NEAR(std::sqrt(sum_sq / 200.0), 0.01, 4.0 * 0.01 / 20.0);
}

}  // namespace
}  // namespace cosiva::physical
