#include "cosiva/experiments/battery/virtual_rig.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "cosiva/base/test_paths.h"
#include "cosiva/experiments/battery/analysis.h"
#include "cosiva/experiments/battery/load_profile.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;

/// The published cell twice in series, so that a run lasts an hour and a quarter.
VirtualRigOptions small(std::size_t vehicles, std::size_t runs = 1) {
  VirtualRigOptions options;
  options.procedure.vehicles = vehicles;
  options.procedure.runs = runs;
  options.battery.type = *battery::shipped_type("lipo850");
  options.battery.design = {2, 1, 1.0};
  options.seed = 5;
  return options;
}

/// Standstill and driving alternately, 4 W on average.
std::vector<LoadProfile> loads(std::size_t vehicles) {
  LoadProfile load;
  for (int i = 0; i < 200; ++i) {
    load.power_w.push_back(i < 100 ? 5.0 : 3.0);
    load.moved_m.push_back(i < 100 ? 0.05 : 0.0);
  }
  return std::vector<LoadProfile>(vehicles, load);
}

std::size_t first_difference(const std::string& a, const std::string& b) {
  return static_cast<std::size_t>(std::ranges::mismatch(a, b).in1 - a.begin());
}

VirtualRig finished(const VirtualRigOptions& options) {
  VirtualRig rig{options, loads(options.procedure.vehicles)};
  for (int i = 0; i < 10'000 && !rig.done(); ++i) rig.step();
  EXPECT_TRUE(rig.done());
  return rig;
}

TEST(VirtualRig, drains_each_battery_to_its_floor_by_the_measured_load) {
  const VirtualRig rig = finished(small(3));
  ASSERT_EQ(rig.procedure().records().size(), 3U);
  for (const BatteryRun& run : rig.procedure().records()) {
    EXPECT_EQ(run.stop, StopCause::floor);
    // 80 % of 0.85 Ah at about 7.55 V is 18.5 kJ, 4 W of which last 4620 s; monitors err by 1 %, vehicles by 2 %.
    EXPECT_NEAR(run.autonomy_s, 4620.0, 250.0);
    EXPECT_NEAR(run.energy_wh * 3600.0 / run.autonomy_s, 4.0, 0.3);
    EXPECT_NEAR(run.distance_m, 0.25 * run.autonomy_s, 5.0);
    EXPECT_NEAR(run.charge_end, 0.2, 1e-6);
    EXPECT_GT(run.curve.size(), 140U);
  }
}

TEST(VirtualRig, reports_the_gauge_s_error_against_the_ground_truth) {
  double z_sq = 0.0;
  int count = 0;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    VirtualRigOptions options = small(6);
    options.seed = seed;
    const VirtualRig rig = finished(options);
    ASSERT_EQ(rig.ground_truth().size(), 6U);
    for (const TrueEnd& end : rig.ground_truth()) {
      for (const BatteryRun& run : rig.procedure().records()) {
        if (run.vehicle != end.vehicle) continue;
        const double z = (run.charge_end - end.charge) / run.charge_end_sd;
        z_sq += z * z;
        ++count;
        EXPECT_NE(run.charge_end, end.charge);
      }
    }
  }
  EXPECT_NEAR(std::sqrt(z_sq / count), 1.0, 0.35);
}

TEST(VirtualRig, separates_battery_from_vehicle_where_they_swap) {
  VirtualRigOptions options = small(4, 4);
  options.procedure.swap = true;
  options.load_sd = 0.05;
  options.battery.type.capacity_spread = 0.002;
  const VirtualRig rig = finished(options);
  const AutonomyMetrics metrics = analyse(rig.procedure().records(), 4);
  ASSERT_TRUE(metrics.crossed);
  EXPECT_FALSE(metrics.crossed->confounded);
  EXPECT_GT(metrics.crossed->carrier.ratio, 0.8);
  EXPECT_LT(metrics.crossed->carrier.p, 1e-4);
}

TEST(VirtualRig, fades_slightly_with_each_run) {
  VirtualRigOptions options = small(1, 6);
  options.battery.type.capacity_fade_per_cycle = 0.003;
  options.procedure.floor = 0.1;
  const VirtualRig rig = finished(options);
  const AutonomyMetrics metrics = analyse(rig.procedure().records(), 1);
  // A gauge that counts charge of a nominal capacity does not detect the fading; the cut-off and the ground truth do.
  EXPECT_GT(rig.procedure().records().back().tag.cycles, 4.0);
  EXPECT_LT(rig.ground_truth().back().charge, rig.ground_truth().front().charge - 0.005);
}

TEST(VirtualRig, names_failures_and_cut_offs) {
  VirtualRigOptions options = small(6);
  options.failures_per_hour = 0.8;
  const VirtualRig failing = finished(options);
  const AutonomyMetrics metrics = analyse(failing.procedure().records(), 6);
  EXPECT_GT(metrics.failed, 0U);
  EXPECT_LT(metrics.failed, 6U);
  options.failures_per_hour = 0.0;
  options.procedure.floor = 0.0;
  const VirtualRig empty = finished(options);
  for (const BatteryRun& run : empty.procedure().records()) {
    EXPECT_TRUE(run.ended());
    EXPECT_LT(run.charge_end, 0.1);
  }
  EXPECT_GT(analyse(empty.procedure().records(), 6).cut_off, 3U);
}

TEST(VirtualRig, continues_from_its_saved_state_to_the_same_bits) {
  VirtualRigOptions options = small(3, 2);
  options.procedure.swap = true;
  options.failures_per_hour = 1.0;
  options.procedure.pause_every = 60s;
  options.procedure.pause_for = 10s;
  VirtualRig whole{options, loads(3)};
  VirtualRig cut{options, loads(3)};
  for (int i = 0; i < 10'000 && !whole.done(); ++i) {
    whole.step();
    VirtualRig again{options, loads(3)};
    ASSERT_TRUE(again.restore(cut.state_json()));
    cut = std::move(again);
    cut.step();
  }
  const std::string state = cut.state_json();
  EXPECT_TRUE(state == whole.state_json())
      << "the states differ from " << state.substr(first_difference(state, whole.state_json()), 80);
}

TEST(VirtualRig, refuses_the_state_of_another_test) {
  VirtualRig rig{small(2), loads(2)};
  const std::string state = rig.state_json();
  VirtualRigOptions other = small(2);
  other.seed = 6;
  EXPECT_EQ((VirtualRig{other, loads(2)}.restore(state).error().code), "battery.state");
  EXPECT_FALSE((VirtualRig{small(3), loads(3)}.restore(state)));
  EXPECT_FALSE(rig.restore("{}"));
  EXPECT_FALSE(rig.restore(state.substr(0, 100)));
  EXPECT_TRUE(rig.restore(state));
}

TEST(Loads, are_those_of_a_whole_platform_s_vehicles) {
  std::ifstream file{source_dir() + "/zones/lacet4.toml"};
  WorldOptions options;
  options.zone = {"toml", "lacet4.toml", {std::istreambuf_iterator<char>{file}, {}}};
  options.aivs = 3;
  const auto measured = measure_loads(options, 10s, 30s);
  ASSERT_TRUE(measured) << to_string(measured.error());
  ASSERT_EQ(measured->size(), 3U);
  for (const LoadProfile& load : *measured) {
    EXPECT_EQ(load.power_w.size(), 300U);
    // 3 W idle and 0.6 N over 0.6 of efficiency times its speed.
    EXPECT_NEAR(load.mean_w(), 3.0 + load.mean_mps(), 0.25);
    EXPECT_GT(load.mean_mps(), 0.1);
  }
}

}  // namespace
}  // namespace cosiva::experiments
