#include "cosiva/experiments/runs/world/test_world.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/base/json_value.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::bijection;
using testing::total_m;
using testing::world_of;

double number_at(const JsonValue& json, std::string_view a, std::string_view b) {
  return json.find(a)->number(b).value_or(-1.0);
}

const physical::TrueVehicle vehicle(const World& world, std::uint32_t number) {
  return world.plant().vehicles().at(number - 1);
}

TEST(World, four_AIVs_circulate_each_with_its_twin_without_collision) {
  const auto world = world_of(4);
  world->run_for(120s);

  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  for (const auto& v : world->plant().vehicles()) {
    EXPECT_GE(v.laps, 1U) << "AIV" << v.number << " drove " << v.distance_m << " m";
  }
  const JsonValue metrics = bijection(*world);
  EXPECT_EQ(metrics.number("physical"), 4.0);
  EXPECT_EQ(metrics.number("virtual"), 4.0);
  EXPECT_EQ(metrics.number("matched"), 4.0);
  EXPECT_GE(metrics.number("matched_ratio").value_or(0.0), 0.999);
  EXPECT_LE(number_at(metrics, "divergence_m", "p99"), 0.03);
  EXPECT_LE(number_at(metrics, "age_ms", "p99"), 150.0);
}

TEST(World, gives_equal_digests_for_equal_seeds_only) {
  const auto run = [](std::uint64_t seed) {
    const auto world = world_of(4, seed, 0.02);
    world->run_for(30s);
    return world->digest().hex();
  };
  const std::string first = run(7);
  EXPECT_EQ(run(7), first);
  EXPECT_NE(run(8), first);
}

TEST(World, a_stop_command_stops_the_physical_vehicle_until_restart) {
  const auto world = world_of(4);
  world->run_for(10s);
  for (int i = 0; i < 200 && vehicle(*world, 2).speed_mps < 0.2; ++i) world->run_for(100ms);
  ASSERT_GT(vehicle(*world, 2).speed_mps, 0.1) << "the vehicle waits at a crossing for ever";

  world->command_server(R"({"id":"c1","command":"stop","vehicle":"CoSiVA/AIV2"})");
  world->run_for(2s);
  EXPECT_NEAR(vehicle(*world, 2).speed_mps, 0.0, 1e-3);
  const double stopped_at = vehicle(*world, 2).distance_m;
  world->run_for(5s);
  EXPECT_NEAR(vehicle(*world, 2).distance_m, stopped_at, 1e-3);

  world->command_server(R"({"id":"c2","command":"restart","vehicle":"CoSiVA/AIV2"})");
  world->run_for(10s);
  EXPECT_GT(vehicle(*world, 2).distance_m, stopped_at + 0.5);
  const JsonValue metrics = bijection(*world);
  EXPECT_EQ(number_at(metrics, "commands", "issued"), 2.0);
  EXPECT_EQ(number_at(metrics, "commands", "materialised"), 2.0);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(World, slow_limits_the_speed_on_the_physical_side) {
  const auto world = world_of(1);
  world->run_for(10s);
  world->command_server(R"({"command":"slow","vehicle":"*"})");
  world->run_for(3s);
  for (int i = 0; i < 100; ++i) {
    world->run_for(100ms);
    EXPECT_LE(vehicle(*world, 1).speed_mps, 0.17);
  }
}

TEST(World, an_obstacle_on_the_path_stops_a_vehicle_until_its_removal) {
  const auto world = world_of(1);
  world->run_for(5s);
  // On the south-eastern loop (centre (0.75, −0.75), radius 0.60), away from crossings.
  world->command_plant(R"({"addObstacle":{"id":"box","x":1.1742640687,"y":-1.1742640687,"radius":0.05}})");
  world->run_for(60s);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  EXPECT_NEAR(vehicle(*world, 1).speed_mps, 0.0, 1e-3);
  const double stopped_at = vehicle(*world, 1).distance_m;
  world->command_plant(R"({"removeObstacle":"box"})");
  world->run_for(10s);
  EXPECT_GT(vehicle(*world, 1).distance_m, stopped_at + 0.5);
}

TEST(World, a_dead_vehicle_is_shown_broken_and_not_hit_and_rejoins) {
  const auto world = world_of(4);
  world->run_for(15s);
  world->kill_aiv(1);
  world->run_for(2s);
  const JsonValue shown = *JsonValue::parse(world->server().snapshot_json());
  EXPECT_EQ(shown.find("aivs")->array()->at(0).text("connection"), "CONNECTIONBROKEN");
  world->run_for(60s);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());

  const double stopped_at = vehicle(*world, 1).distance_m;
  world->start_aiv(1);
  world->run_for(30s);
  EXPECT_GT(vehicle(*world, 1).distance_m, stopped_at + 1.0);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

// A vehicle that dies stops at an arbitrary position, which is seldom one where it would have waited.
TEST(World, one_vehicle_after_the_other_dies_anywhere_and_all_vehicles_drive_on_each_time) {
  const auto world = world_of(4);
  world->run_for(10s);
  std::vector<double> before_m(4);
  for (std::uint32_t kill = 0; kill < 12; ++kill) {
    const std::uint32_t number = 1 + kill % 4;
    world->kill_aiv(number);
    world->run_for(std::chrono::milliseconds{3000 + 740 * kill});
    world->start_aiv(number);
    for (const auto& v : world->plant().vehicles()) before_m[v.number - 1] = v.distance_m;
    world->run_for(45s);
    for (const auto& v : world->plant().vehicles())
      EXPECT_GT(v.distance_m, before_m[v.number - 1] + 1.0) << "AIV" << v.number << " after " << kill + 1 << " deaths";
  }
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(World, without_its_server_the_fleet_stops_and_continues_when_it_is_back) {
  const auto world = world_of(4);
  world->run_for(20s);
  world->kill_server();
  world->run_for(3s);
  for (const auto& v : world->plant().vehicles()) EXPECT_NEAR(v.speed_mps, 0.0, 1e-3) << "AIV" << v.number;
  const double before = total_m(*world);
  world->run_for(5s);
  EXPECT_NEAR(total_m(*world), before, 1e-3);

  world->start_server();
  world->run_for(60s);
  for (const auto& v : world->plant().vehicles()) EXPECT_GT(v.distance_m, 3.0);
  EXPECT_GT(total_m(*world), before + 10.0);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  EXPECT_EQ(bijection(*world).number("matched"), 4.0);
}

TEST(World, refuses_a_bad_zone_with_its_location) {
  WorldOptions options;
  options.zone = {"toml", "bad.toml", "name = \"x\"\nformat_version = 1\n"};
  const auto world = World::make(std::move(options));
  ASSERT_FALSE(world.has_value());
  EXPECT_THAT(to_string(world.error()), ::testing::HasSubstr("bad.toml"));
}

}  // namespace
}  // namespace cosiva::experiments
