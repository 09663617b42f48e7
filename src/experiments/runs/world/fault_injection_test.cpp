#include "cosiva/experiments/runs/world/fault_injection.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/experiments/runs/world/fleet.h"
#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::world_of;

double distance_m(const World& world, std::uint32_t number) {
  return world.plant().vehicles().at(number - 1).distance_m;
}

TEST(FaultInjection, a_process_dies_instead_of_carrying_out_an_effect) {
  const auto world = world_of(2);
  world->run_for(5s);
  std::vector<Process> killed;
  std::uint64_t effects = 0;
  FaultInjection::Observer observer;
  observer.on_killed = [&](Process process) { killed.push_back(process); };
  observer.on_effect = [&](Process process, const wire::Effect&) { effects += process == 1 ? 1 : 0; };
  world->faults().observe(std::move(observer));
  world->faults().kill_at_effect(1, 5);
  world->run_for(5s);
  EXPECT_THAT(killed, ::testing::ElementsAre(1U));
  EXPECT_EQ(effects, 4U);
  EXPECT_FALSE(world->faults().running(1));
}

TEST(FaultInjection, a_fleet_stops_without_its_broker_and_drives_on_after_its_return) {
  const auto world = world_of(2);
  world->run_for(10s);
  world->faults().stop_broker();
  world->run_for(3s);
  const double stopped_m = distance_m(*world, 1);
  world->run_for(3s);
  EXPECT_NEAR(distance_m(*world, 1), stopped_m, 1e-3);
  world->faults().start_broker();
  for (Process process = 0; process <= 2; ++process) world->faults().restore_link(process);
  world->run_for(15s);
  EXPECT_TRUE(fleet_is_complete(world->server(), 2));
  EXPECT_GT(distance_m(*world, 1), stopped_m + 1.0);
}

TEST(FaultInjection, a_fleet_drives_on_from_where_it_was_after_the_plant_has_died) {
  const auto world = world_of(2);
  world->run_for(10s);
  const double before_m = distance_m(*world, 1);
  EXPECT_GT(before_m, 1.0);
  const Pose2 before = world->plant().vehicles().front().X_MB;
  world->faults().kill(plant_process);
  EXPECT_FALSE(world->faults().running(plant_process));
  world->run_for(2s);
  world->faults().start(plant_process);
  // The world persists ten times a second: it may have moved for 0.1 s since, at 0.6 m/s at most.
  EXPECT_NEAR(distance_m(*world, 1), before_m, 0.06);
  EXPECT_LT(distance(world->plant().vehicles().front().X_MB, before), 0.06);
  EXPECT_TRUE(world->faults().linked(plant_process));
  world->run_for(30s);
  for (const std::uint32_t number : {1U, 2U}) EXPECT_GT(distance_m(*world, number), before_m + 1.0) << number;
  EXPECT_TRUE(world->plant().collisions().empty());
}

TEST(FaultInjection, a_vehicle_does_not_drive_while_the_streams_of_its_boards_are_closed) {
  const auto world = world_of(2);
  world->run_for(10s);
  world->faults().set_boards(1, false);
  world->run_for(2s);
  const double stopped_m = distance_m(*world, 1);
  world->run_for(3s);
  EXPECT_NEAR(distance_m(*world, 1), stopped_m, 1e-3);
  world->faults().set_boards(1, true);
  world->run_for(10s);
  EXPECT_GT(distance_m(*world, 1), stopped_m + 0.5);
}

TEST(FaultInjection, a_vehicle_that_receives_nothing_stops_and_is_still_online) {
  const auto world = world_of(2);
  world->run_for(10s);
  world->faults().block(1, {false, true});
  world->run_for(3s);
  EXPECT_NEAR(world->plant().vehicles().front().speed_mps, 0.0, 1e-3);
  EXPECT_TRUE(world->faults().linked(1));
  const auto shown = JsonValue::parse(world->server().snapshot_json());
  EXPECT_EQ(shown->find("aivs")->array()->front().flag("lost"), false);
}

/// All messages that the server publishes in a minute, while the clocks of all vehicles are off by `offset`.
std::string messages_of_server(SimDuration offset) {
  const auto world = world_of(4);
  world->run_for(2s);
  std::string messages;
  world->tap([&](SimTime, const std::string& from, const wire::Publish& message) {
    if (from == "server") messages += message.topic + " " + message.payload + "\n";
  });
  for (Process process = 1; process <= 4; ++process) {
    world->kill_aiv(process);
    world->faults().set_clock(process, offset, 0.0);
    world->start_aiv(process);
  }
  world->run_for(60s);
  return messages;
}

// I8. An offset below the tolerance of VehicleClock is not recognised and acts as a delay.
TEST(FaultInjection, no_clock_of_a_vehicle_changes_what_the_server_sends) {
  const std::string of_fast_clock = messages_of_server(24h);
  EXPECT_GT(of_fast_clock.size(), 100'000U);
  EXPECT_TRUE(messages_of_server(-24h) == of_fast_clock);
  EXPECT_TRUE(messages_of_server(24h * 365 * 16) == of_fast_clock);
}

/// The servers of the control areas a and b of e2e/areas, and a vehicle in each.
std::unique_ptr<World> world_of_two_servers() {
  const auto area = [](const std::string& name) {
    return zone::testing::configuration_file("../e2e/areas/" + name + ".toml");
  };
  WorldOptions options;
  options.zone = area("floor");
  options.aivs = 2;
  options.server.area = "a";
  options.server.zone = area("area_a");
  options.other_servers.emplace_back();
  options.other_servers.back().options.area = "b";
  options.other_servers.back().options.zone = area("area_b");
  auto world = World::make(std::move(options));
  EXPECT_TRUE(world) << (world ? "" : to_string(world.error()));
  return std::move(*world);
}

TEST(FaultInjection, servers_of_two_control_areas_each_drive_the_vehicle_in_their_area) {
  const auto world = world_of_two_servers();
  world->run_for(10s);
  EXPECT_TRUE(fleet_is_complete(world->server(), 1));
  EXPECT_TRUE(fleet_is_complete(world->server(first_other_server), 1));
  EXPECT_GT(distance_m(*world, 1), 1.0);
  EXPECT_GT(distance_m(*world, 2), 1.0);
}

TEST(FaultInjection, a_server_of_another_control_area_dies_and_restarts_by_itself) {
  const auto world = world_of_two_servers();
  world->run_for(5s);
  world->faults().kill(first_other_server);
  EXPECT_FALSE(world->faults().running(first_other_server));
  EXPECT_TRUE(world->faults().running(server_process));
  world->run_for(3s);
  const double first_m = distance_m(*world, 1);
  const double second_m = distance_m(*world, 2);
  world->run_for(5s);
  EXPECT_GT(distance_m(*world, 1), first_m + 1.0);
  EXPECT_NEAR(distance_m(*world, 2), second_m, 1e-3) << "no server takes the vehicles of another one that is down";
  world->faults().start(first_other_server);
  world->run_for(10s);
  EXPECT_GT(distance_m(*world, 2), second_m + 1.0);
}

TEST(FaultInjection, a_command_reaches_the_server_that_it_is_given_to) {
  const auto world = world_of_two_servers();
  world->run_for(5s);
  bool decided = false;
  world->faults().command(first_other_server, R"({"command":"stop","vehicle":"*"})",
                          [&](const Result<void>& result) { decided = result.has_value(); });
  EXPECT_TRUE(decided);
  world->run_for(3s);
  const double first_m = distance_m(*world, 1);
  const double second_m = distance_m(*world, 2);
  world->run_for(3s);
  EXPECT_GT(distance_m(*world, 1), first_m + 0.5);
  EXPECT_NEAR(distance_m(*world, 2), second_m, 1e-3);
}

}  // namespace
}  // namespace cosiva::experiments
