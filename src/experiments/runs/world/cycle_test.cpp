// All components in one common, slower cycle: another run than at the live platform's rate, and as safe.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/experiments/runs/world/test_disturbance.h"
#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;

WorldOptions fleet(std::uint32_t aivs, std::optional<SimDuration> cycle, std::uint64_t seed = 1,
                   const std::string& zone = "lacet4") {
  WorldOptions options;
  options.zone = testing::zone_named(zone);
  options.aivs = aivs;
  options.seed = seed;
  options.cycle = cycle;
  options.as_values = true;
  options.rules = {};  // crisp: the figures are of these
  return options;
}

std::unique_ptr<World> world_with(WorldOptions options) {
  auto world = World::make(std::move(options));
  EXPECT_TRUE(world.has_value()) << (world ? "" : to_string(world.error()));
  return std::move(*world);
}

double driven_m(const World& world) {
  double sum_m = 0.0;
  for (const auto& v : world.plant().vehicles()) sum_m += v.distance_m;
  return sum_m;
}

/// The distance that fleets of these seeds drive in such a cycle, compared with that at the live rate.
double ratio_driven(std::uint32_t aivs, SimDuration cycle, std::uint64_t seeds = 1) {
  double live_m = 0.0;
  double slow_m = 0.0;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto live = world_with(fleet(aivs, std::nullopt, seed));
    const auto slow = world_with(fleet(aivs, cycle, seed));
    live->run_for(200s);
    slow->run_for(200s);
    EXPECT_THAT(slow->plant().collisions(), ::testing::IsEmpty()) << aivs << " AIVs";
    for (const auto& v : slow->plant().vehicles()) EXPECT_GT(v.distance_m, 30.0) << "AIV" << v.number;
    live_m += driven_m(*live);
    slow_m += driven_m(*slow);
  }
  return slow_m / live_m;
}

TEST(Cycle, at_ten_hertz_a_sparse_fleet_drives_as_far_as_at_the_live_rate) {
  EXPECT_NEAR(ratio_driven(4, 100ms), 1.0, 0.005);
}

/// Where crossings are rarely free, every tenth of a second until a vehicle is known to have left one matters. The
/// order at the crossings differs from run to run, and with it the distance: by some percent in a single run.
TEST(CycleStatistics, at_ten_hertz_a_crowded_fleet_loses_some_distance_and_at_twenty_almost_none) {
  EXPECT_NEAR(ratio_driven(12, 100ms, 4), 0.94, 0.04);
  EXPECT_NEAR(ratio_driven(12, 50ms, 4), 1.0, 0.04);
}

TEST(CycleStatistics, at_ten_hertz_there_is_no_collision_among_persons_stops_and_lost_messages) {
  for (const std::uint64_t seed : {1U, 2U, 3U}) {
    WorldOptions options = fleet(12, 100ms, seed);
    options.network.loss = 0.05;
    const auto world = world_with(std::move(options));
    testing::Disturbance disturbance{*world, testing::zone_named("lacet4"), seed};
    for (int s = 0; s < 240; ++s) disturbance.second();
    disturbance.end();
    std::vector<double> before_m;
    for (const auto& v : world->plant().vehicles()) before_m.push_back(v.distance_m);
    world->run_for(60s);
    EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty()) << seed;
    EXPECT_EQ(testing::deadlock_metrics(*world).open, 0.0) << seed;
    for (const auto& v : world->plant().vehicles()) EXPECT_GT(v.distance_m, before_m[v.number - 1] + 3.0) << v.number;
  }
}

TEST(Cycle, at_ten_hertz_a_dead_vehicle_is_not_hit_and_rejoins) {
  const auto world = world_with(fleet(6, 100ms));
  world->run_for(20s);
  world->kill_aiv(2);
  world->run_for(30s);
  world->kill_server();
  world->run_for(5s);
  EXPECT_NEAR(world->plant().vehicles()[0].speed_mps, 0.0, 1e-3) << "without its server";
  world->start_server();
  world->start_aiv(2);
  const double before_m = world->plant().vehicles()[1].distance_m;
  world->run_for(60s);
  EXPECT_GT(world->plant().vehicles()[1].distance_m, before_m + 3.0);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(Cycle, gives_equal_digests_for_equal_seeds_only) {
  const auto run = [](std::uint64_t seed) {
    const auto world = world_with(fleet(4, 100ms, seed));
    world->run_for(20s);
    return world->digest().hex();
  };
  EXPECT_EQ(run(7), run(7));
  EXPECT_NE(run(7), run(8));
}

TEST(Cycle, of_more_than_a_tenth_of_a_second_or_faster_than_the_boards_is_refused) {
  for (const SimDuration cycle : {SimDuration{101ms}, SimDuration{19ms}, SimDuration{}}) {
    const auto world = World::make(fleet(2, cycle));
    ASSERT_FALSE(world);
    EXPECT_EQ(world.error().code, "world.cycle");
    EXPECT_THAT(world.error().message, ::testing::HasSubstr("from 20 to 100 ms"));
  }
}

}  // namespace
}  // namespace cosiva::experiments
