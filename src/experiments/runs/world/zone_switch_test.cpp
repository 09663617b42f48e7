// The traffic zone switched while the fleet drives (A24), in virtual time.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/base/json_value.h"
#include "cosiva/experiments/runs/world/fault_injection.h"
#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::snapshot;
using testing::switch_to;
using testing::world_of;
using testing::zone_named;

std::size_t twins(const World& world) { return snapshot(world).find("aivs")->array()->size(); }

/// The vehicles that have not driven this distance since, and are not off-route.
std::vector<std::string> left_stopped(const World& world, const std::vector<double>& since_m, double driven_m) {
  std::vector<std::string> ids;
  const JsonValue shot = snapshot(world);
  for (const JsonValue& aiv : *shot.find("aivs")->array()) {
    const auto v = static_cast<std::size_t>(*aiv.number("number")) - 1;
    const bool drove = world.plant().vehicles()[v].distance_m - since_m[v] > driven_m;
    if (!drove && !aiv.text("offRoute")) ids.push_back(*aiv.text("id"));
  }
  return ids;
}

std::vector<double> distances_m(const World& world) {
  std::vector<double> distances;
  for (const auto& v : world.plant().vehicles()) distances.push_back(v.distance_m);
  return distances;
}

TEST(ZoneSwitch, moves_the_fleet_to_another_circuit_without_a_restart_a_jump_or_a_collision) {
  const auto world = world_of(4);
  world->run_for(30s);
  const auto poses = [&] {
    std::vector<Pose2> all;
    for (const auto& v : world->plant().vehicles()) all.push_back(v.X_MB);
    return all;
  };
  auto before = poses();
  switch_to(*world, zone_named("indus8"));
  const auto at_switch_m = distances_m(*world);
  for (int i = 0; i < 1000; ++i) {
    world->run_for(20ms);
    const auto now = poses();
    for (std::size_t v = 0; v < now.size(); ++v) {
      // No body jumps: at most 1.5 m/s.
      EXPECT_LE(distance(before[v], now[v]), 0.03 + 1e-9) << "AIV" << v + 1 << " after " << 0.02 * i << " s";
    }
    before = now;
    ASSERT_EQ(twins(*world), 4U);
  }
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  EXPECT_EQ(snapshot(*world).find("zone")->text("name"), "indus8");
  world->run_for(40s);
  const auto later_m = distances_m(*world);
  for (std::size_t v = 0; v < later_m.size(); ++v)
    EXPECT_GT(later_m[v] - at_switch_m[v], 3.0) << "AIV" << v + 1 << " drives on the new circuit";
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(ZoneSwitch, moves_the_first_twin_within_a_second) {
  const auto world = world_of(12, 3);
  world->run_for(30s);
  for (const char* name : {"indus8", "lacet4", "indus8"}) {
    switch_to(*world, zone_named(name));
    world->run_for(20s);
    const JsonValue shot = snapshot(*world);
    const JsonValue* switched = shot.find("zone")->find("switched");
    ASSERT_NE(switched, nullptr);
    EXPECT_LT(switched->number("first_moving_ms").value_or(1e9), 1000.0) << name;
    EXPECT_GT(switched->number("snapped").value_or(0.0), 0.0) << name;
  }
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(ZoneSwitchStatistics, ten_times_in_five_minutes_gives_the_same_digest_twice_and_no_collision) {
  const auto run = [] {
    const auto world = world_of(12, 5, 0.01);
    world->run_for(10s);
    for (int i = 0; i < 10; ++i) {
      const auto before_m = distances_m(*world);
      switch_to(*world, zone_named(i % 2 == 0 ? "indus8" : "lacet4"));
      world->run_for(29s);
      EXPECT_EQ(twins(*world), 12U);
      EXPECT_THAT(left_stopped(*world, before_m, 0.2), ::testing::IsEmpty()) << "after switch " << i + 1;
    }
    EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
    double driven_m = 0.0;
    for (const double d : distances_m(*world)) driven_m += d;
    EXPECT_GT(driven_m, 12.0 * 20.0);
    return world->digest().hex();
  };
  EXPECT_EQ(run(), run());
}

// Most vehicles are still off the path when the next switch comes.
TEST(ZoneSwitchStatistics, every_five_seconds_causes_no_collision_and_no_endless_wait) {
  const auto world = world_of(12, 6);
  world->run_for(10s);
  for (int i = 0; i < 12; ++i) {
    switch_to(*world, zone_named(i % 2 == 0 ? "indus8" : "lacet4"));
    world->run_for(5s);
    ASSERT_THAT(world->plant().collisions(), ::testing::IsEmpty()) << "after switch " << i + 1;
  }
  const auto before_m = distances_m(*world);
  world->run_for(60s);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  // A vehicle that is too far from the new paths is off-route, and is listed.
  EXPECT_THAT(left_stopped(*world, before_m, 1.0), ::testing::IsEmpty());
}

TEST(ZoneSwitch, to_an_invalid_configuration_leaves_the_old_zone_in_force_and_reports_why) {
  const auto world = world_of(4);
  world->run_for(20s);
  const auto before_m = distances_m(*world);
  zone::ZoneConfiguration broken = zone_named("indus8");
  broken.text.insert(broken.text.find("length_m"), "?");
  switch_to(*world, broken);
  world->run_for(20s);
  EXPECT_EQ(snapshot(*world).find("zone")->text("name"), "lacet4");
  const auto after_m = distances_m(*world);
  for (std::size_t v = 0; v < after_m.size(); ++v) EXPECT_GT(after_m[v] - before_m[v], 1.0);
  // The same when the physical side publishes it.
  world->faults().publish_from_outside({"cosiva/v1/zone/toml", broken.text, 1, true});
  world->run_for(20s);
  const JsonValue shot = snapshot(*world);
  EXPECT_EQ(shot.find("zone")->text("name"), "lacet4");
  const JsonValue* refused = shot.find("zone")->find("refused");
  ASSERT_NE(refused, nullptr);
  EXPECT_THAT(refused->text("why").value_or(""), ::testing::HasSubstr("?"));
  EXPECT_FALSE(refused->text("why").value_or("").empty());
}

TEST(ZoneSwitch, preserves_a_command_given_just_before_it) {
  const auto world = world_of(4);
  world->run_for(20s);
  world->command_server(R"({"command":"stop","vehicle":"CoSiVA/AIV2","id":"c1"})");
  switch_to(*world, zone_named("indus8"));
  world->run_for(10s);
  const JsonValue shot = snapshot(*world);
  bool found = false;
  for (const JsonValue& command : *shot.find("commands")->array()) {
    if (command.text("id") != "c1") continue;
    found = true;
    EXPECT_EQ(command.text("state"), "materialised");
  }
  EXPECT_TRUE(found);
  EXPECT_EQ(world->plant().vehicles().at(1).speed_mps, 0.0);
}

TEST(ZoneSwitch, survives_the_death_of_the_server_and_of_a_vehicle) {
  const auto world = world_of(4);
  world->run_for(20s);
  switch_to(*world, zone_named("indus8"));
  world->run_for(100ms);
  world->kill_server();
  world->run_for(2s);
  world->start_server();
  world->kill_aiv(2);
  world->run_for(1s);
  world->start_aiv(2);
  world->run_for(40s);
  EXPECT_EQ(snapshot(*world).find("zone")->text("name"), "indus8");
  EXPECT_EQ(twins(*world), 4U);
  const auto before_m = distances_m(*world);
  world->run_for(20s);
  const auto after_m = distances_m(*world);
  for (std::size_t v = 0; v < after_m.size(); ++v) EXPECT_GT(after_m[v] - before_m[v], 1.0) << "AIV" << v + 1;
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

}  // namespace
}  // namespace cosiva::experiments
