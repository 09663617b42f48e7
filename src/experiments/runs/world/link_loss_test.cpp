// Vehicles that lose their broker: by default they brake, and with `finish-base` they drive to the end of their bases
// while they receive from each other by the direct link (A3, A9). Nothing collides, whatever the radio loses.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "cosiva/experiments/runs/world/fault_injection.h"
#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::total_m;

struct Fleet {
  std::uint64_t seed{1};
  aiv::LinkLoss link_loss{aiv::LinkLoss::finish_base};
  double radio_loss{0.0};
  std::uint32_t aivs{8};
};

std::unique_ptr<World> world_of(const Fleet& fleet) {
  WorldOptions options;
  options.zone = testing::zone_named("lacet4");
  options.aivs = fleet.aivs;
  options.seed = fleet.seed;
  options.as_values = passes_values(fleet.seed);
  options.radio.emplace();
  options.radio->loss = fleet.radio_loss;
  options.adapt_aiv = [link_loss = fleet.link_loss](aiv::OnboardOptions& aiv) { aiv.link_loss = link_loss; };
  auto world = World::make(std::move(options));
  EXPECT_TRUE(world.has_value());
  return std::move(*world);
}

/// The distance that all vehicles together drive after the broker has died.
double driven_without_broker_m(World& world) {
  world.faults().stop_broker();
  const double before_m = total_m(world);
  world.run_for(20s);
  return total_m(world) - before_m;
}

TEST(LinkLossStatistics, finished_bases_cause_no_collision_whatever_the_radio_loses) {
  double braked_m = 0.0;
  std::vector<double> finished_m;
  for (const double loss : {0.0, 0.1, 0.5, 1.0}) {
    double sum_m = 0.0;
    for (std::uint64_t seed = 1; seed <= 10; ++seed) {
      const auto world = world_of({.seed = seed, .radio_loss = loss});
      world->run_for(10s + 700ms * seed);
      sum_m += driven_without_broker_m(*world);
      EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty()) << seed << ", loss " << loss;
      for (const auto& vehicle : world->plant().vehicles())
        EXPECT_LT(vehicle.speed_mps, 0.01) << "AIV" << vehicle.number << " stops at the end of its base";
      if (loss > 0.0) continue;
      const auto usual = world_of({.seed = seed, .link_loss = aiv::LinkLoss::brake});
      usual->run_for(10s + 700ms * seed);
      braked_m += driven_without_broker_m(*usual);
    }
    finished_m.push_back(sum_m);
  }
  std::printf(
      "driven after the loss of the broker, 10 seeds of 8 AIVs: %.2f m braking; finishing %.2f, %.2f, %.2f, %.2f m\n",
      braked_m, finished_m[0], finished_m[1], finished_m[2], finished_m[3]);
  EXPECT_GT(finished_m[0], braked_m + 10.0) << "a base is up to 2 m long, and most vehicles are on one";
  EXPECT_GT(finished_m[1], 0.9 * finished_m[0]) << "at 10 % loss, 300 ms without an intent are rare";
  EXPECT_GE(finished_m[2], finished_m[3]);
}

TEST(LinkLossInWorld, continues_with_the_broker) {
  const auto world = world_of({.seed = 3});
  world->run_for(15s);
  world->faults().stop_broker();
  world->run_for(15s);
  world->faults().start_broker();
  world->faults().restore_link(server_process);
  for (Process aiv = 1; aiv <= 8; ++aiv) world->faults().restore_link(aiv);
  world->run_for(5s);
  const double before_m = total_m(*world);
  world->run_for(30s);
  EXPECT_GT(total_m(*world), before_m + 10.0);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(LinkLossInWorld, of_one_server_stops_all_vehicles_at_the_ends_of_their_bases) {
  const auto world = world_of({.seed = 4});
  world->run_for(15s);
  world->kill_server();
  world->run_for(20s);
  for (const auto& vehicle : world->plant().vehicles()) EXPECT_LT(vehicle.speed_mps, 0.01);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  world->start_server();
  const double before_m = total_m(*world);
  world->run_for(30s);
  EXPECT_GT(total_m(*world), before_m + 10.0);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(LinkLossInWorld, gives_the_same_digest_for_the_same_seed_and_the_radio_is_part_of_it) {
  const auto run = [](double loss) {
    const auto world = world_of({.seed = 10, .radio_loss = loss, .aivs = 4});
    world->run_for(12s);
    world->faults().stop_broker();
    world->run_for(5s);
    return world->digest().hex();
  };
  const std::string first = run(0.2);
  EXPECT_EQ(run(0.2), first);
  EXPECT_NE(run(0.0), first);
}

}  // namespace
}  // namespace cosiva::experiments
