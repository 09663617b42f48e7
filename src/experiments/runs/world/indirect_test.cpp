// Travel in indirect direction (A32), in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/base/json_value.h"
#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::bijection;
using testing::snapshot;
using testing::switch_to;
using testing::world_of;
using testing::zone_named;

zone::ZoneConfiguration indirect(const std::string& name) {
  return zone::in_travel_direction(zone_named(name), zone::TravelDirection::indirect).value();
}

std::unique_ptr<World> indirect_world(const std::string& name, std::uint32_t aivs, std::uint64_t seed = 1) {
  WorldOptions options;
  options.zone = indirect(name);
  options.aivs = aivs;
  options.seed = seed;
  auto world = World::make(std::move(options));
  EXPECT_TRUE(world.has_value()) << (world ? "" : to_string(world.error()));
  return std::move(*world);
}

/// The displacement of a body along its own heading: negative for a body that drives backwards.
double forwards_m(const Pose2& before, const Pose2& now) { return (inverse(before) * now).x_m; }

/// Lets the world run while every body drives backwards, and its twin has its pose.
void expect_backwards(World& world, SimDuration duration) {
  std::vector<Pose2> before;
  for (const auto& v : world.plant().vehicles()) before.push_back(v.X_MB);
  for (SimDuration run{}; run < duration; run += 100ms) {
    world.run_for(100ms);
    const JsonValue shot = snapshot(world);
    const auto& aivs = *shot.find("aivs")->array();
    for (std::size_t v = 0; v < before.size(); ++v) {
      const Pose2 now = world.plant().vehicles()[v].X_MB;
      EXPECT_LE(forwards_m(before[v], now), 1e-3) << "AIV" << v + 1;
      before[v] = now;
      const double heading_off = wrap_angle(aivs[v].number("heading").value_or(9.0) - now.heading_rad);
      EXPECT_LE(std::fabs(heading_off), 0.3) << "the twin of AIV" << v + 1 << " has the heading of its vehicle";
    }
  }
}

TEST(IndirectTravel, leads_each_vehicle_backwards_over_whole_laps_with_its_twin_and_without_collision) {
  const auto world = indirect_world("lacet4", 4);
  world->run_for(2s);
  expect_backwards(*world, 120s);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  for (const auto& v : world->plant().vehicles())
    EXPECT_GE(v.laps, 1U) << "AIV" << v.number << " drove " << v.distance_m << " m";
  const JsonValue metrics = bijection(*world);
  EXPECT_EQ(metrics.number("matched"), 4.0);
  EXPECT_LE(metrics.find("divergence_m")->number("p99").value_or(1.0), 0.03);
}

TEST(IndirectTravel, crosses_forks_and_junctions_of_a_plant) {
  const auto world = indirect_world("indus8", 6);
  world->run_for(2s);
  expect_backwards(*world, 100s);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  double driven_m = 0.0;
  for (const auto& v : world->plant().vehicles()) driven_m += v.distance_m;
  EXPECT_GT(driven_m, 6 * 5.0);
}

TEST(IndirectTravel, begins_and_ends_on_order_without_a_jump_and_each_vehicle_stays_on_its_path) {
  const auto world = world_of(4);
  world->run_for(20s);
  for (const bool backwards : {true, false, true}) {
    std::vector<Pose2> before;
    for (const auto& v : world->plant().vehicles()) before.push_back(v.X_MB);
    switch_to(*world, backwards ? indirect("lacet4") : zone_named("lacet4"));
    for (int i = 0; i < 250; ++i) {
      world->run_for(20ms);
      for (std::size_t v = 0; v < before.size(); ++v) {
        const Pose2 now = world->plant().vehicles()[v].X_MB;
        EXPECT_LE(distance(before[v], now), 0.03 + 1e-9);
        EXPECT_LE(std::fabs(wrap_angle(before[v].heading_rad - now.heading_rad)), 0.2) << "no body turns round";
        before[v] = now;
      }
    }
    const JsonValue shot = snapshot(*world);
    for (const JsonValue& aiv : *shot.find("aivs")->array())
      EXPECT_FALSE(aiv.text("offRoute")) << *aiv.text("id") << " " << *aiv.text("offRoute");
    if (backwards) expect_backwards(*world, 10s);
    world->run_for(10s);
  }
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  for (const auto& v : world->plant().vehicles()) EXPECT_GT(v.distance_m, 5.0);
}

TEST(IndirectTravel, stops_before_an_obstacle_behind_the_body) {
  const auto world = indirect_world("lacet4", 1);
  for (int i = 0; i < 100 && world->plant().vehicles()[0].speed_mps < 0.25; ++i) world->run_for(100ms);
  const Pose2 X_MB = world->plant().vehicles()[0].X_MB;
  const zone::Circuit circuit = zone::Rtm::initialise(indirect("lacet4"))->zone().circuit;
  const Pose2 behind = circuit.pose_at(circuit.advance(world->plant().vehicles()[0].position.value(), 0.8));
  JsonWriter json;
  json.begin_object().key("addObstacle").begin_object().field("id", "box").field("x", behind.x_m);
  json.field("y", behind.y_m).field("radius", 0.05).end_object().end_object();
  world->command_plant(json.take());
  world->run_for(8s);
  EXPECT_NEAR(world->plant().vehicles()[0].speed_mps, 0.0, 1e-3);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  world->command_plant(R"({"removeObstacle":"box"})");
  world->run_for(5s);
  EXPECT_GT(distance(world->plant().vehicles()[0].X_MB, X_MB), 0.5);
}

TEST(IndirectTravel, leads_virtual_AIVs_backwards_among_the_physical_ones) {
  const auto world = indirect_world("lacet4", 3);
  world->run_for(5s);
  world->command_server(R"({"command":"add","virtualObject":{"kind":"aiv","id":"V1"}})");
  world->run_for(10s);
  std::optional<Pose2> before;
  double driven_m = 0.0;
  for (int i = 0; i < 600; ++i) {
    world->run_for(100ms);
    const JsonValue shot = snapshot(*world);
    for (const JsonValue& aiv : *shot.find("aivs")->array()) {
      if (aiv.text("id") != "CoSiVA.virtual/V1") continue;
      const Pose2 now{*aiv.number("x"), *aiv.number("y"), *aiv.number("heading")};
      if (before) {
        EXPECT_LE(forwards_m(*before, now), 5e-3);
        driven_m += distance(*before, now);
      }
      before = now;
    }
  }
  EXPECT_GT(driven_m, 4.0);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(IndirectTravel, gives_equal_digests_for_equal_seeds) {
  const auto run = [](std::uint64_t seed) {
    const auto world = indirect_world("lacet4", 4, seed);
    world->run_for(20s);
    return world->digest().hex();
  };
  const std::string first = run(7);
  EXPECT_EQ(run(7), first);
  EXPECT_NE(run(8), first);
}

}  // namespace
}  // namespace cosiva::experiments
