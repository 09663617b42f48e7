// Fleets on two-way tracks, in virtual time: with the vehicles' own program and their obstacle sensors.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <memory>
#include <string>

#include "cosiva/experiments/runs/world/test_world.h"
#include "cosiva/zone/generate/grid.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::snapshot;

zone::ZoneConfiguration grid(std::uint32_t columns, std::uint32_t rows, std::uint32_t bays) {
  zone::GridOptions options;
  options.columns = columns;
  options.rows = rows;
  options.bays = bays;
  options.two_way = true;
  const auto text = zone::generate_grid(options);
  EXPECT_TRUE(text) << to_string(text.error());
  return {"toml", "floor.toml", *text};
}

std::unique_ptr<World> fleet_on(const zone::ZoneConfiguration& zone, std::uint32_t aivs) {
  WorldOptions options;
  options.zone = zone;
  options.aivs = aivs;
  options.as_values = true;  // the same run, in less time
  auto world = World::make(std::move(options));
  EXPECT_TRUE(world) << to_string(world.error());
  return std::move(*world);
}

JsonValue routes(const World& world) { return *JsonValue::parse(world.server().summary_json())->find("routes"); }

JsonValue mission_of(const World& world, const std::string& vehicle) {
  const JsonValue all = snapshot(world);
  for (const JsonValue& aiv : *all.find("aivs")->array())
    if (aiv.text("id") == vehicle) return *aiv.find("mission");
  return {};
}

void go(World& world, const std::string& vehicle, const std::string& to) {
  world.command_server(R"({"command":"go","vehicle":")" + vehicle + R"(","to":")" + to + R"("})");
}

class TwoWayGrid : public ::testing::TestWithParam<std::pair<std::uint32_t, std::uint32_t>> {};

TEST_P(TwoWayGrid, keeps_all_vehicles_moving_without_collision_and_without_deadlock) {
  const auto& [aivs, bays] = GetParam();
  const auto world = fleet_on(grid(6, 5, bays), aivs);
  world->run_for(300s);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  EXPECT_LE(*routes(*world).number("longest_wait_s"), 120.0);
  EXPECT_GE(*routes(*world).number("least_arrivals"), 1.0);
  EXPECT_EQ(snapshot(*world).find("deadlocks")->number("detected"), 0.0);
}

INSTANTIATE_TEST_SUITE_P(Fleets, TwoWayGrid,
                         ::testing::Values(std::pair{6U, 0U}, std::pair{12U, 0U}, std::pair{12U, 8U}));

TEST(PlannedRoutes, lead_around_a_vehicle_whose_program_has_died) {
  const auto world = fleet_on(grid(4, 3, 0), 4);
  world->run_for(20s);
  world->kill_aiv(2);
  world->run_for(30s);
  std::vector<double> before_m;
  for (const auto& vehicle : world->plant().vehicles()) before_m.push_back(vehicle.distance_m);
  world->run_for(120s);
  for (const auto& vehicle : world->plant().vehicles()) {
    const double driven_m = vehicle.distance_m - before_m[vehicle.number - 1];
    if (vehicle.number == 2)
      EXPECT_EQ(driven_m, 0.0);
    else
      EXPECT_GT(driven_m, 20.0) << "AIV" << vehicle.number;
  }
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(PlannedRoutes, lead_two_vehicles_to_each_other_s_node) {
  const auto world = fleet_on(grid(3, 2, 0), 2);
  world->run_for(2s);
  go(*world, "CoSiVA/AIV1", "A1");
  go(*world, "CoSiVA/AIV2", "C2");
  world->run_for(60s);
  ASSERT_EQ(mission_of(*world, "CoSiVA/AIV1").text("state"), "arrived");
  ASSERT_EQ(mission_of(*world, "CoSiVA/AIV2").text("state"), "arrived");
  go(*world, "CoSiVA/AIV1", "C2");
  go(*world, "CoSiVA/AIV2", "A1");
  world->run_for(90s);
  EXPECT_EQ(mission_of(*world, "CoSiVA/AIV1").text("state"), "arrived");
  EXPECT_EQ(mission_of(*world, "CoSiVA/AIV2").text("state"), "arrived");
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(PlannedRoutes, do_not_exist_to_a_node_behind_closed_sections_until_these_are_opened) {
  const auto world = fleet_on(grid(3, 1, 0), 1);
  world->run_for(2s);
  go(*world, "CoSiVA/AIV1", "A1");
  world->run_for(40s);
  ASSERT_EQ(mission_of(*world, "CoSiVA/AIV1").text("state"), "arrived");
  world->command_server(R"({"command":"close","section":"B1-C1"})");
  go(*world, "CoSiVA/AIV1", "C1");
  world->run_for(10s);
  EXPECT_EQ(mission_of(*world, "CoSiVA/AIV1").text("state"), "no route");
  EXPECT_THAT(mission_of(*world, "CoSiVA/AIV1").text("why").value_or(""),
              ::testing::HasSubstr("no path to C1 is free"));
  world->command_server(R"({"command":"open","section":"B1-C1"})");
  world->run_for(40s);
  EXPECT_EQ(mission_of(*world, "CoSiVA/AIV1").text("state"), "arrived");
}

}  // namespace
}  // namespace cosiva::experiments
