// Traffic without unreported deadlocks, in virtual time: with the vehicles' own program, their obstacle sensors, and a
// lossy link.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/experiments/runs/world/test_disturbance.h"
#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::deadlock_metrics;
using testing::DeadlockMetrics;
using testing::Disturbance;
using testing::zone_named;

class Unquiet : public ::testing::TestWithParam<std::tuple<const char*, std::uint64_t>> {};

TEST_P(Unquiet, area_has_no_collision_and_no_persistent_deadlock) {
  const auto& [name, seed] = GetParam();
  WorldOptions options;
  options.zone = zone_named(name);
  options.aivs = 12;
  options.seed = seed;
  options.network.loss = 0.05;
  options.as_values = true;  // the same run, in less time
  const auto world = World::make(options);
  ASSERT_TRUE(world);
  Disturbance disturbance{**world, options.zone, seed};
  for (int s = 0; s < 600; ++s) disturbance.second();
  disturbance.end();
  (*world)->run_for(15s);
  std::vector<double> before_m;
  for (const auto& vehicle : (*world)->plant().vehicles()) before_m.push_back(vehicle.distance_m);
  (*world)->run_for(30s);
  EXPECT_THAT((*world)->plant().collisions(), ::testing::IsEmpty());
  const DeadlockMetrics metrics = deadlock_metrics(**world);
  EXPECT_EQ(metrics.open, 0.0);
  EXPECT_EQ(metrics.detected, metrics.resolved);
  for (const auto& vehicle : (*world)->plant().vehicles())
    EXPECT_GT(vehicle.distance_m - before_m[vehicle.number - 1], 1.0) << "AIV" << vehicle.number << " drives on";
}

std::string name_of(const ::testing::TestParamInfo<Unquiet::ParamType>& one) {
  return std::string(std::get<0>(one.param)) + "_" + std::to_string(std::get<1>(one.param));
}

INSTANTIATE_TEST_SUITE_P(Statistics, Unquiet,
                         ::testing::Values(std::tuple{"lacet4", 1U}, std::tuple{"lacet4", 2U},
                                           std::tuple{"indus8", 1U}),
                         name_of);

}  // namespace
}  // namespace cosiva::experiments
