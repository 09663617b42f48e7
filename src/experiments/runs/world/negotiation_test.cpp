// Vehicles agree on crossings among themselves over the direct link while the server observes (`--autonomy negotiate`).
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <memory>
#include <string>

#include "cosiva/experiments/runs/world/fault_injection.h"
#include "cosiva/experiments/runs/world/fleet.h"
#include "cosiva/experiments/runs/world/test_world.h"
#include "cosiva/wire/own/own_messages.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::total_m;

struct Fleet {
  std::uint64_t seed{1};
  double radio_loss{0.0};
  std::uint32_t aivs{12};
  std::uint32_t ignores_claims{0};  ///< the number of a vehicle that drives as its base permits; 0: none
};

std::unique_ptr<World> world_of(const Fleet& fleet) {
  WorldOptions options;
  options.zone = testing::zone_named("lacet4");
  options.aivs = fleet.aivs;
  options.seed = fleet.seed;
  options.as_values = passes_values(fleet.seed);
  options.server.negotiated_crossings = true;
  options.radio.emplace();
  options.radio->loss = fleet.radio_loss;
  options.radio->duplication = fleet.radio_loss;
  options.radio->reordering = fleet.radio_loss;
  options.adapt_aiv = [ignores = fleet.ignores_claims](aiv::OnboardOptions& aiv) {
    if (aiv.number != ignores) aiv.autonomy = aiv::Autonomy::negotiate;
  };
  auto world = World::make(std::move(options));
  EXPECT_TRUE(world.has_value());
  return std::move(*world);
}

TEST(NegotiationStatistics, of_12_vehicles_for_10_minutes_has_no_collision_and_all_drive) {
  for (const double loss : {0.0, 0.1, 0.3}) {
    for (std::uint64_t seed = 1; seed <= 2; ++seed) {
      const auto world = world_of({.seed = seed, .radio_loss = loss});
      world->run_for(600s);
      EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty()) << seed << ", loss " << loss;
      double least_m = 1e9;
      for (const auto& vehicle : world->plant().vehicles()) least_m = std::min(least_m, vehicle.distance_m);
      std::printf("seed %d, radio loss %.1f: %.1f m, the least of one vehicle %.1f m\n", static_cast<int>(seed), loss,
                  total_m(*world), least_m);
      EXPECT_GT(least_m, 17.31) << "a lap of the clover";
    }
  }
}

TEST(Negotiation, does_not_need_the_server_after_it_has_released_a_base) {
  const auto world = world_of({.seed = 5, .aivs = 4});
  world->run_for(60s);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  EXPECT_GT(total_m(*world), 20.0);
}

TEST(Negotiation, refuses_a_virtual_AIV_which_takes_no_part_in_it) {
  const auto world = world_of({.aivs = 2});
  world->run_for(5s);
  world->command_server(R"({"command":"add","virtualObject":{"kind":"aiv","id":"V1"}})");
  world->run_for(2s);
  EXPECT_TRUE(fleet_is_complete(world->server(), 2));
  EXPECT_FALSE(fleet_is_complete(world->server(), 3));
  const std::string summary = world->server().summary_json();
  EXPECT_EQ(summary.find("CoSiVA.virtual/V1"), std::string::npos);
}

TEST(Negotiation, without_a_radio_lets_no_vehicle_enter_a_crossing_once_others_are_known) {
  const auto world = world_of({.seed = 6});
  world->run_for(20s);
  world->faults().publish_from_outside({std::string(wire::plant_radio_topic), R"({"vehicle":"*","loss":1})", 1, false});
  world->run_for(20s);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  world->faults().publish_from_outside({std::string(wire::plant_radio_topic), R"({"vehicle":"*","loss":0})", 1, false});
  const double before_m = total_m(*world);
  world->run_for(60s);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  EXPECT_GT(total_m(*world), before_m + 20.0) << "all continue";
}

TEST(Negotiation, cannot_protect_vehicles_from_one_that_ignores_claims) {
  std::size_t collisions = 0;
  for (std::uint64_t seed = 1; seed <= 5 && collisions == 0; ++seed) {
    const auto world = world_of({.seed = seed, .ignores_claims = 1});
    world->run_for(300s);
    collisions += world->plant().collisions().size();
  }
  EXPECT_GT(collisions, 0U) << "otherwise the test above could not fail";
}

}  // namespace
}  // namespace cosiva::experiments
