#include "cosiva/battery/pack.h"
#include "cosiva/battery/cell_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

namespace cosiva::battery {
namespace {

std::shared_ptr<const CellTable> table_of(const char* name) {
  auto type = shipped_type(name);
  EXPECT_TRUE(type) << (type ? "" : to_string(type.error()));
  return std::make_shared<CellTable>(*type);
}

PackHistory plain(std::string id = "B1") { return {std::move(id), 1, false, 0.0}; }

/// From full to the floor, interpolated between two steps.
double seconds_to(Pack& pack, double volt, auto draw, double dt_s) {
  double before_v = pack.voltage_v();
  for (double t_s = 0.0; t_s < 1e6; t_s += dt_s) {
    const PackStep step = draw(pack, dt_s);
    if (step.voltage_v <= volt)
      return t_s + (t_s == 0.0 ? 0.0 : dt_s * (before_v - volt) / (before_v - step.voltage_v) - dt_s);
    if (step.event == PackEvent::brown_out || step.event == PackEvent::empty) return t_s;
    before_v = step.voltage_v;
  }
  return -1.0;
}

struct Check {
  double load;
  double seconds;
};

// Chen and Rincón-Mora's cell from full to 3.0 V: their closed forms, evaluated in steps of 1 s, give these times.
TEST(PublishedCell, lasts_as_long_as_its_closed_form_at_constant_current) {
  const auto table = table_of("lipo850");
  for (const Check& check : {Check{0.17, 17708.0}, {0.425, 7049.0}, {0.85, 3498.0}, {1.7, 1721.0}}) {
    for (const double dt_s : {1.0, 0.1}) {
      Pack pack{table, {}, plain()};
      const double found_s = seconds_to(
          pack, 3.0, [&](Pack& p, double dt) { return p.draw_current(check.load, 25.0, dt); }, dt_s);
      EXPECT_NEAR(found_s, check.seconds, 0.002 * check.seconds) << check.load << " A, step " << dt_s;
    }
  }
}

TEST(PublishedCell, lasts_as_long_as_its_closed_form_at_constant_power) {
  const auto table = table_of("lipo850");
  for (const Check& check : {Check{1.0, 11324.0}, {2.0, 5564.0}, {3.0, 3645.0}}) {
    Pack pack{table, {}, plain()};
    const double found_s = seconds_to(
        pack, 3.0, [&](Pack& p, double dt) { return p.draw_power(check.load, 25.0, dt); }, 1.0);
    EXPECT_NEAR(found_s, check.seconds, 0.002 * check.seconds) << check.load << " W";
  }
}

// Measured by the tester: 3568.8 s at 30.6 A and 1762.3 s at 61.2 A, first discharges of each log.
TEST(LeafCell, lasts_as_long_as_measured) {
  const auto table = table_of("leaf33");
  for (const Check& check : {Check{30.6, 3568.8}, {61.2, 1762.3}}) {
    Pack pack{table, {}, plain()};
    const double found_s = seconds_to(
        pack, 3.0, [&](Pack& p, double dt) { return p.draw_current(check.load, 25.0, dt); }, 1.0);
    EXPECT_NEAR(found_s, check.seconds, 0.005 * check.seconds) << check.load << " A";
  }
}

TEST(Pack, delivers_the_power_that_a_load_requests) {
  Pack pack{table_of("lipo850"), {2, 1, 2.2 / 0.85}, plain()};
  for (int i = 0; i < 600; ++i) {
    const PackStep step = pack.draw_power(8.0, 22.0, 0.1);
    ASSERT_NEAR(step.voltage_v * step.current_a, 8.0, 1e-9);
  }
  EXPECT_LT(pack.voltage_v(), pack.open_circuit_v());
  EXPECT_GT(pack.temperature_c(), 25.0 - 1.0);
  EXPECT_NEAR(pack.delivered_j(), 8.0 * 60.0, 1e-6);
}

TEST(Pack, conserves_energy_and_charge) {
  Pack pack{table_of("lipo850"), {}, plain()};
  double stored_j = 0.0;
  double before = pack.charge();
  while (pack.draw_power(1.5, 25.0, 1.0).event == PackEvent::none) {
    const double now = pack.charge();
    stored_j += pack.table().at(0.5 * (before + now)).open_circuit_v * (before - now) * 3600.0 * 0.85;
    before = now;
  }
  // The difference is stored in the two capacitors: ½ C u², a few joules.
  EXPECT_NEAR(pack.delivered_j() + pack.lost_j(), stored_j, 1e-3 * stored_j);
  EXPECT_NEAR(pack.delivered_ah(), 0.85 * (1.0 - pack.charge()), 1e-9);
}

TEST(Pack, that_cannot_deliver_the_power_browns_out_as_an_event_and_recovers) {
  Pack pack{table_of("lipo850"), {}, plain()};
  // At most e²/4R = 4.1²/(4·0.0745) W of a rested full cell.
  const PackStep step = pack.draw_power(60.0, 25.0, 0.1);
  EXPECT_EQ(step.event, PackEvent::brown_out);
  EXPECT_EQ(step.current_a, 0.0);
  EXPECT_TRUE(std::isfinite(step.voltage_v));
  EXPECT_EQ(pack.draw_power(5.0, 25.0, 0.1).event, PackEvent::none);
  EXPECT_EQ(pack.draw_current(60.0, 25.0, 0.1).event, PackEvent::brown_out);
}

TEST(Pack, once_empty_delivers_nothing_and_accepts_charge) {
  Pack pack{table_of("lipo850"), {}, plain()};
  pack.set_charge(1e-6);
  EXPECT_EQ(pack.draw_current(0.1, 25.0, 1.0).event, PackEvent::empty);
  const PackStep refused = pack.draw_current(0.1, 25.0, 1.0);
  EXPECT_EQ(refused.event, PackEvent::empty);
  EXPECT_EQ(refused.current_a, 0.0);
  EXPECT_EQ(pack.charge(), 0.0);
  pack.draw_current(-0.85, 25.0, 360.0);
  EXPECT_NEAR(pack.charge(), 0.1 * 0.999, 1e-9);  // the coulombic efficiency
}

TEST(Pack, of_equal_cells_equals_one_cell_times_its_numbers) {
  Pack one{table_of("leaf33"), {}, plain()};
  Pack many{table_of("leaf33"), {3, 4, 1.0}, plain()};
  for (int i = 0; i < 1000; ++i) {
    const PackStep a = one.draw_current(30.0, 25.0, 1.0);
    const PackStep b = many.draw_current(120.0, 25.0, 1.0);
    ASSERT_NEAR(b.voltage_v, 3.0 * a.voltage_v, 1e-9);
  }
  EXPECT_NEAR(many.charge(), one.charge(), 1e-12);
  EXPECT_NEAR(many.lost_j(), 12.0 * one.lost_j(), 1e-6 * many.lost_j());
}

TEST(Pack, scaled_lasts_equally_long_at_the_scaled_load) {
  Pack cell{table_of("lipo850"), {}, plain()};
  Pack large{table_of("lipo850"), {1, 1, 10.0}, plain()};
  const auto until_floor = [](Pack& pack, double power_w) {
    int steps = 0;
    while (pack.draw_power(power_w, 25.0, 1.0).event == PackEvent::none) ++steps;
    return steps;
  };
  EXPECT_EQ(until_floor(cell, 2.0), until_floor(large, 20.0));
  EXPECT_NEAR(cell.temperature_c(), large.temperature_c(), 1e-9);
}

TEST(Pack, in_series_ends_with_its_weakest_cell_and_in_parallel_with_the_mean) {
  const auto table = table_of("lipo850");
  const auto ah_of = [&](PackDesign design) {
    double sum = 0.0;
    for (std::uint64_t seed = 1; seed <= 200; ++seed)
      sum += Pack{table, design, {"B", seed, true, 0.0}}.capacity_ah() / design.parallel;
    return sum / 200.0;
  };
  // The least of 8 of a normal is 1.42 SD below the mean; SD is 1 %.
  EXPECT_NEAR(ah_of({8, 1, 1.0}), 0.85 * (1.0 - 0.0142), 0.85 * 0.0014);
  EXPECT_NEAR(ah_of({1, 8, 1.0}), 0.85, 0.85 * 0.0008);
}

TEST(Pack, differs_only_by_its_seed) {
  const auto table = table_of("lipo850");
  const auto digest = [&](std::uint64_t seed) {
    Pack pack{table, {2, 2, 1.0}, {"B", seed, true, 0.0}};
    for (int i = 0; i < 100; ++i) pack.draw_power(6.0, 20.0, 0.1);
    Digest folded;
    pack.fold(folded);
    return folded.hex();
  };
  EXPECT_EQ(digest(7), digest(7));
  EXPECT_NE(digest(7), digest(8));
}

TEST(Pack, loses_capacity_and_gains_resistance_with_every_full_cycle) {
  Pack pack{table_of("leaf33"), {}, plain()};
  for (int cycle = 0; cycle < 10; ++cycle) {
    pack.set_charge(1.0);
    for (int i = 0; i < 3600; ++i) pack.draw_current(0.5 * 30.5, 25.0, 1.0);
    for (int i = 0; i < 3599; ++i) pack.draw_current(0.5 * 30.5, 25.0, 1.0);
    pack.renew(25.0);
  }
  // Each holds 0.4 ‰ less than the previous one: 10 − 45 · 0.0004.
  EXPECT_NEAR(pack.cycles(), 9.982, 1e-3);
  EXPECT_NEAR(pack.capacity_ah(), 30.5 * (1.0 - 9.982 * 0.0004), 1e-5);
  EXPECT_EQ(pack.charge(), 1.0);
  // 0.8 ‰ more resistance per cycle: a rested full cell drops 30 A × 1.86 mΩ × 1.008.
  const double rested_v = pack.voltage_v();
  EXPECT_NEAR(rested_v - pack.draw_current(30.0, 25.0, 1e-3).voltage_v, 30.0 * 1.86e-3 * 1.008, 1e-5);
}

TEST(Pack, has_more_resistance_in_the_cold_and_no_less_in_the_heat) {
  const auto kept = table_of("leaf33");
  const CellTable& table = *kept;
  EXPECT_NEAR(table.heat_factor(0.0), std::exp(20000.0 / 8.314462618 * (1.0 / 273.15 - 1.0 / 298.15)), 1e-3);
  EXPECT_EQ(table.heat_factor(25.0), 1.0);
  EXPECT_EQ(table.heat_factor(60.0), 1.0);
  EXPECT_EQ(table.heat_factor(-80.0), table.heat_factor(-40.0));
}

TEST(Pack, warms_towards_the_equilibrium_of_losses_and_cooling) {
  Pack pack{table_of("lipo850"), {}, plain(), 25.0};
  double heat_w = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double lost_before_j = pack.lost_j();
    pack.draw_current(0.85, 25.0, 1.0);
    heat_w = pack.lost_j() - lost_before_j;
  }
  EXPECT_NEAR(pack.temperature_c(), 25.0 + heat_w / 0.05, 0.2);
}

TEST(Pack, at_rest_returns_to_its_open_circuit_voltage) {
  Pack pack{table_of("leaf33"), {}, plain()};
  for (int i = 0; i < 600; ++i) pack.draw_current(30.0, 25.0, 1.0);
  const double loaded_v = pack.voltage_v();
  for (int i = 0; i < 6000; ++i) pack.draw_power(0.0, 25.0, 1.0);
  EXPECT_GT(pack.voltage_v(), loaded_v + 0.05);
  EXPECT_NEAR(pack.voltage_v(), pack.open_circuit_v(), 1e-5);
  EXPECT_NEAR(pack.table().charge_of(pack.voltage_v()), pack.charge(), 1e-3);
}

TEST(Pack, continues_from_its_saved_state_to_the_same_bits) {
  Pack pack{table_of("lipo850"), {2, 2, 1.0}, {"B7", 3, true, 12.0}};
  for (int i = 0; i < 500; ++i) pack.draw_power(9.0, 20.0, 0.1);
  Pack again{table_of("lipo850"), {2, 2, 1.0}, {"B7", 3, true, 12.0}};
  ASSERT_TRUE(again.restore(pack.state_json()));
  for (int i = 0; i < 500; ++i) {
    pack.draw_power(9.0, 20.0, 0.1);
    again.draw_power(9.0, 20.0, 0.1);
  }
  EXPECT_EQ(again.state_json(), pack.state_json());
}

TEST(Pack, rejects_the_state_of_another_pack) {
  Pack pack{table_of("lipo850"), {}, plain("B1")};
  const auto code = [&](std::string_view json) {
    const auto done = pack.restore(json);
    return done ? std::string("taken") : done.error().code;
  };
  const std::string before = pack.state_json();
  EXPECT_EQ(code(Pack(table_of("lipo850"), {}, plain("B2")).state_json()), "battery.state");
  EXPECT_EQ(code(Pack(table_of("lipo850"), {2, 1, 1.0}, plain("B1")).state_json()), "battery.state");
  EXPECT_EQ(code("{"), "battery.state");
  EXPECT_EQ(code(R"({"id":"B1"})"), "battery.state");
  std::string wrong = before;
  wrong.replace(wrong.find("[[1"), 3, "[[2");
  EXPECT_EQ(code(wrong), "battery.state");
  EXPECT_EQ(pack.state_json(), before);
}

TEST(Pack, derives_the_charge_from_a_rested_voltage) {
  const auto kept = table_of("leaf33");
  const CellTable& table = *kept;
  for (const double charge : {0.0, 0.05, 0.333, 0.5, 0.98, 1.0})
    EXPECT_NEAR(table.charge_of(table.at(charge).open_circuit_v), charge, 1e-9);
  EXPECT_EQ(table.charge_of(1.0), 0.0);
  EXPECT_EQ(table.charge_of(5.0), 1.0);
  EXPECT_NEAR(table.volt_per_charge(0.35), (3.881 - 3.830) / 0.1, 1e-9);
}

}  // namespace
}  // namespace cosiva::battery
