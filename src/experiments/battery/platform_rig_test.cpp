#include "cosiva/experiments/battery/platform_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/experiments/battery/load_profile.h"
#include "cosiva/wire/own/battery_exchange.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;

WorldOptions lacet4(std::uint32_t aivs) {
  std::ifstream file{source_dir() + "/zones/lacet4.toml"};
  WorldOptions options;
  options.zone = {"toml", "lacet4.toml", {std::istreambuf_iterator<char>{file}, {}}};
  options.aivs = aivs;
  options.seed = 3;
  return options;
}

/// Batteries that last some minutes.
VirtualRigOptions small(std::size_t vehicles, std::size_t runs = 1) {
  VirtualRigOptions options;
  options.procedure.vehicles = vehicles;
  options.procedure.runs = runs;
  options.procedure.floor = 0.5;
  options.procedure.temperature_max_c = 60.0;
  options.battery.type = *battery::shipped_type("lipo850");
  options.battery.design = {2, 1, 0.25};
  options.battery.gauge = battery::GaugeMethod::counter;
  options.seed = 3;
  return options;
}

PlatformRig started(const WorldOptions& world, const VirtualRigOptions& options) {
  auto rig = PlatformRig::make(world, options);
  EXPECT_TRUE(rig) << (rig ? "" : to_string(rig.error()));
  return std::move(*rig);
}

void run_to_the_end(PlatformRig& rig) {
  for (int i = 0; i < 20'000 && !rig.done(); ++i) rig.step();
  ASSERT_TRUE(rig.done());
}

TEST(PlatformRig, runs_a_fleet_on_the_circuit_until_each_has_reached_its_floor) {
  PlatformRig rig = started(lacet4(4), small(4));
  run_to_the_end(rig);
  const auto& records = rig.procedure().records();
  ASSERT_EQ(records.size(), 4U);
  for (const BatteryRun& run : records) {
    EXPECT_EQ(run.stop, StopCause::floor);
    EXPECT_GT(run.distance_m, 20.0);
    EXPECT_NEAR(run.charge_end, 0.5, 1e-3);
    // The charge that its monitor counted is half of the nominal capacity, to the report's tenth of a percent.
    EXPECT_NEAR(run.charge_ah, 0.5 * 0.2125, 0.02 * 0.2125);
    EXPECT_EQ(run.started, records.front().started);
  }
  // The vehicles drove together to the end, without a collision.
  EXPECT_TRUE(rig.world().plant().collisions().empty());
  ASSERT_EQ(rig.ground_truth().size(), 4U);
  for (const TrueEnd& end : rig.ground_truth()) EXPECT_NEAR(end.charge, 0.5, 0.05);
}

// changeBattery and batteryReady are messages of the vehicles' own programs. No other component confirms a battery.
TEST(PlatformRig, exchanges_batteries_with_the_vehicles_own_programs) {
  PlatformRig rig = started(lacet4(3), small(3));
  std::vector<std::string> senders;
  FaultInjection::Observer observer;
  observer.on_effect = [&](Process from, const wire::Effect& effect) {
    const auto* message = std::get_if<wire::Publish>(&effect);
    if (message != nullptr && wire::parse_own_topic(wire::battery_ready_topic_prefix, message->topic))
      senders.push_back("AIV" + std::to_string(from));
  };
  rig.world().faults().observe(std::move(observer));
  for (int i = 0; i < 100 && !rig.procedure().running(0); ++i) rig.step();
  EXPECT_TRUE(rig.procedure().running(0));
  EXPECT_THAT(senders, ::testing::UnorderedElementsAre("AIV1", "AIV2", "AIV3"));
}

TEST(PlatformRig, waits_for_a_vehicle_whose_program_is_down) {
  PlatformRig rig = started(lacet4(3), small(3));
  rig.world().kill_aiv(2);
  for (int i = 0; i < 60; ++i) rig.step();
  EXPECT_FALSE(rig.procedure().running(0)) << "the battery of AIV2 was changed, but AIV2 has not confirmed it";
  rig.world().start_aiv(2);
  for (int i = 0; i < 60; ++i) rig.step();
  EXPECT_TRUE(rig.procedure().running(0) && rig.procedure().running(1)) << "the retained request reaches it again";
}

TEST(PlatformRig, agrees_with_a_test_under_the_measured_loads) {
  PlatformRig whole = started(lacet4(4), small(4));
  run_to_the_end(whole);
  auto loads = measure_loads(lacet4(4), 10s, 120s);
  ASSERT_TRUE(loads);
  VirtualRig repeated{small(4), std::move(*loads)};
  while (!repeated.done()) repeated.step();
  const double on_the_circuit_s = analyse(whole.procedure().records(), 4).at_s;
  const double by_its_load_s = analyse(repeated.procedure().records(), 4).at_s;
  EXPECT_NEAR(by_its_load_s, on_the_circuit_s, 0.02 * on_the_circuit_s);
}

TEST(PlatformRig, counts_a_vehicle_that_dies_as_lost_and_not_as_empty) {
  PlatformRig rig = started(lacet4(3), small(3));
  while (rig.procedure().progress(rig.now()).ratio < 0.3) rig.step();
  rig.world().kill_aiv(2);
  run_to_the_end(rig);
  const AutonomyMetrics metrics = analyse(rig.procedure().records(), 3);
  EXPECT_EQ(metrics.failed, 1U);
  EXPECT_THAT(metrics.method, ::testing::HasSubstr("censored"));
  for (const BatteryRun& run : rig.procedure().records())
    EXPECT_EQ(run.stop, run.vehicle == 1 ? StopCause::lost : StopCause::floor);
}

TEST(PlatformRig, survives_the_restart_of_its_server_and_of_a_vehicle) {
  PlatformRig rig = started(lacet4(3), small(3));
  while (rig.procedure().progress(rig.now()).ratio < 0.3) rig.step();
  rig.world().kill_server();
  for (int i = 0; i < 20; ++i) rig.step();
  rig.world().start_server();
  rig.world().kill_aiv(1);
  for (int i = 0; i < 20; ++i) rig.step();
  rig.world().start_aiv(1);
  run_to_the_end(rig);
  EXPECT_EQ(analyse(rig.procedure().records(), 3).failed, 0U);
}

TEST(PlatformRig, reports_a_cut_off_by_a_cell_at_its_floor) {
  VirtualRigOptions options = small(2);
  options.procedure.floor = 0.0;
  PlatformRig rig = started(lacet4(2), options);
  run_to_the_end(rig);
  for (const BatteryRun& run : rig.procedure().records()) {
    EXPECT_EQ(run.stop, StopCause::cut_off);
    EXPECT_TRUE(run.ended());
  }
}

TEST(PlatformRig, swaps_batteries_between_runs) {
  VirtualRigOptions options = small(2, 2);
  options.procedure.swap = true;
  options.procedure.floor = 0.8;
  PlatformRig rig = started(lacet4(2), options);
  run_to_the_end(rig);
  ASSERT_EQ(rig.procedure().records().size(), 4U);
  for (const BatteryRun& run : rig.procedure().records())
    EXPECT_EQ(run.battery, rig.procedure().battery_of(run.run, run.vehicle));
  EXPECT_GT(rig.procedure().records().back().tag.cycles, 0.1);
}

TEST(PlatformRig, with_a_seed_that_passes_texts_receives_the_batteries_reports_as_well) {
  WorldOptions world = lacet4(2);
  world.seed = 10;
  ASSERT_FALSE(passes_values(world.seed));
  VirtualRigOptions options = small(2);
  options.battery.design = {2, 1, 0.15};
  PlatformRig rig = started(world, options);
  run_to_the_end(rig);
  ASSERT_EQ(rig.procedure().records().size(), 2U);
  for (const BatteryRun& run : rig.procedure().records()) {
    EXPECT_EQ(run.stop, StopCause::floor);
    EXPECT_NEAR(run.charge_end, 0.5, 2e-3);
  }
}

}  // namespace
}  // namespace cosiva::experiments
