// Augmented co-simulation over the whole platform: physical vehicles perceive virtual objects, and physical obstacles
// that they detect are shown virtually (A2, A3).
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <algorithm>

#include "cosiva/base/json_value.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/runs/world/test_world.h"

namespace cosiva::experiments {
namespace {

using namespace std::chrono_literals;
using testing::bijection;
using testing::snapshot;
using testing::world_of;

physical::TrueVehicle vehicle(const World& world, std::uint32_t number) {
  return world.plant().vehicles().at(number - 1);
}

/// A point at a distance ahead of a vehicle, straight along its heading.
Point2 ahead_of(const World& world, std::uint32_t number, double distance_m) {
  return vehicle(world, number).X_MB * Point2{distance_m, 0.0};
}

std::string person(const std::string& id, Point2 at) {
  JsonWriter json;
  json.begin_object().field("command", "add").key("virtualObject").begin_object();
  json.field("id", id).field("kind", "person").field("x", at.x_m).field("y", at.y_m).end_object().end_object();
  return json.take();
}

const JsonValue* aiv_of(const JsonValue& snapshot, std::string_view id) {
  for (const JsonValue& aiv : *snapshot.find("aivs")->array()) {
    if (aiv.text("id") == id) return &aiv;
  }
  return nullptr;
}

/// Runs until AIV1 drives on a straight, with 0.5 m of it left.
void until_on_a_straight(World& world) {
  for (int i = 0; i < 1200; ++i) {
    const auto v = vehicle(world, 1);
    const bool along_x = std::fabs(std::fabs(v.X_MB.y_m) - 0.15) < 0.01 && std::fabs(v.X_MB.x_m) < 0.75;
    const bool along_y = std::fabs(std::fabs(v.X_MB.x_m) - 0.15) < 0.01 && std::fabs(v.X_MB.y_m) < 0.75;
    const Point2 there = v.X_MB * Point2{0.5, 0.0};
    if (v.speed_mps > 0.3 && (along_x || along_y) && std::fabs(there.x_m) < 0.75 && std::fabs(there.y_m) < 0.75) return;
    world.run_for(50ms);
  }
  FAIL() << "it never drives along a straight";
}

TEST(Augmented, a_person_added_ahead_of_a_physical_vehicle_stops_it_until_its_removal) {
  const auto world = world_of(1);
  until_on_a_straight(*world);
  const Point2 there = ahead_of(*world, 1, 0.45);
  world->command_server(person("P1", there));
  world->run_for(3s);
  const auto is_stopped = vehicle(*world, 1);
  EXPECT_NEAR(is_stopped.speed_mps, 0.0, 1e-3);
  EXPECT_GT(distance(position(is_stopped.X_MB), there), 0.10) << "its front stops before the person";
  EXPECT_LT(distance(position(is_stopped.X_MB), there), 0.45);

  const JsonValue shown = snapshot(*world);
  const JsonValue* aiv = aiv_of(shown, "CoSiVA/AIV1");
  ASSERT_NE(aiv, nullptr);
  EXPECT_EQ(aiv->text("brakingFor"), "P1");
  world->run_for(10s);
  EXPECT_NEAR(vehicle(*world, 1).distance_m, is_stopped.distance_m, 1e-3)
      << "the vehicle stays stopped while the person is present";

  world->command_server(R"({"command":"remove","id":"P1"})");
  world->run_for(5s);
  EXPECT_GT(vehicle(*world, 1).distance_m, is_stopped.distance_m + 0.5);
}

TEST(Augmented, the_vehicle_brakes_within_50_ms_of_the_command) {
  const auto world = world_of(1);
  for (int i = 0; i < 20; ++i) {
    until_on_a_straight(*world);
    world->command_server(person("P" + std::to_string(i), ahead_of(*world, 1, 0.35)));
    world->run_for(2s);
    world->command_server(R"({"command":"remove","id":"*"})");
    world->run_for(3s);
  }
  const JsonValue metrics = bijection(*world);
  const JsonValue* brakes = metrics.find("effects")->find("brakes_ms");
  EXPECT_EQ(brakes->number("count"), 20.0);
  EXPECT_LE(brakes->number("p99").value_or(1e9), 50.0);
}

TEST(Augmented, a_person_who_walks_across_stops_the_vehicle_only_while_in_its_path) {
  const auto world = world_of(1);
  until_on_a_straight(*world);
  const Pose2 here = vehicle(*world, 1).X_MB;
  const Point2 from = here * Point2{0.5, 0.16};
  const Point2 to = here * Point2{0.5, -0.4};
  JsonWriter json;
  json.begin_object().field("command", "add").key("virtualObject").begin_object();
  json.field("id", "P1").field("kind", "person").field("speed", 0.1).field("repeat", "once").key("path").begin_array();
  for (const Point2 p : {from, to}) json.begin_array().value(p.x_m).value(p.y_m).end_array();
  json.end_array().end_object().end_object();
  world->command_server(json.take());
  const double before_m = vehicle(*world, 1).distance_m;
  double slowest_mps = 1.0;
  for (int i = 0; i < 100; ++i) {
    world->run_for(100ms);
    slowest_mps = std::min(slowest_mps, vehicle(*world, 1).speed_mps);
    const JsonValue shown = snapshot(*world);
    const JsonValue& walker = shown.find("virtualObjects")->array()->at(0);
    const double gap_m =
        distance(position(vehicle(*world, 1).X_MB), {walker.number("x").value(), walker.number("y").value()});
    EXPECT_GT(gap_m, 0.10) << "after " << i << " tenths of a second";
  }
  EXPECT_NEAR(slowest_mps, 0.0, 1e-3) << "the vehicle stops for the person";
  EXPECT_GT(vehicle(*world, 1).distance_m, before_m + 0.7) << "and drives on afterwards";
}

TEST(Augmented, a_virtual_AIV_added_ahead_of_a_physical_one_brakes_it_until_its_removal) {
  const auto world = world_of(1);
  world->command_server(R"({"command":"stop","vehicle":"CoSiVA.virtual/V1"})");  // the vehicle does not exist yet: the
                                                                                 // command is refused without effect
  // Behind a straight's last crossing, where a vehicle may stop; the next 0.35 m are on the same straight.
  std::string section;
  double s_m = 0.0;
  for (int i = 0; i < 2400 && section.empty(); ++i) {
    world->run_for(20ms);
    const JsonValue shown = snapshot(*world);
    const JsonValue* aiv = aiv_of(shown, "CoSiVA/AIV1");
    if (aiv == nullptr || !aiv->number("s")) continue;
    const std::string on = aiv->text("section").value_or("");
    s_m = *aiv->number("s");
    if (!on.starts_with("loop") && s_m > 1.08 && s_m < 1.12 && vehicle(*world, 1).speed_mps > 0.3) section = on;
  }
  ASSERT_FALSE(section.empty()) << "it never drives on";
  JsonWriter json;
  json.begin_object().field("command", "add").key("virtualObject").begin_object();
  json.field("id", "V1").field("kind", "aiv").field("section", section).field("s", s_m + 0.35);
  json.end_object().end_object();
  world->command_server(json.take());
  world->run_for(500ms);
  world->command_server(R"({"command":"stop","vehicle":"CoSiVA.virtual/V1"})");
  world->run_for(5s);
  const auto is_stopped = vehicle(*world, 1);
  EXPECT_NEAR(is_stopped.speed_mps, 0.0, 1e-3);
  const JsonValue shown = snapshot(*world);
  const JsonValue* v1 = aiv_of(shown, "CoSiVA.virtual/V1");
  ASSERT_NE(v1, nullptr);
  EXPECT_TRUE(*v1->find("augmented")->flag());
  const double gap_m = distance(position(is_stopped.X_MB), {v1->number("x").value(), v1->number("y").value()});
  EXPECT_GT(gap_m, 0.20) << "a vehicle's length between the body origins";

  world->command_server(R"({"command":"remove","id":"V1"})");
  world->run_for(8s);
  EXPECT_GT(vehicle(*world, 1).distance_m, is_stopped.distance_m + 0.5);
  EXPECT_EQ(aiv_of(snapshot(*world), "CoSiVA.virtual/V1"), nullptr);
  const JsonValue metrics = bijection(*world);
  EXPECT_EQ(metrics.number("physical"), 1.0);
  EXPECT_EQ(metrics.number("virtual"), 1.0);
  EXPECT_EQ(metrics.number("matched_ratio"), 1.0) << "a virtual object has no vehicle and needs none";
}

TEST(Augmented, virtual_and_physical_AIVs_circulate_together_without_contact) {
  const auto world = world_of(4);
  world->run_for(10s);
  for (const char* id : {"V1", "V2", "V3"}) {
    world->command_server(std::string(R"({"command":"add","virtualObject":{"kind":"aiv","id":")") + id + "\"}}");
    world->run_for(3s);
  }
  double nearest_m = 1e9;
  std::vector<Point2> first(3);
  std::vector<double> furthest_m(3, 0.0);
  for (int i = 0; i < 1800; ++i) {
    world->run_for(100ms);
    const JsonValue shown = snapshot(*world);
    for (std::size_t v = 0; v < 3; ++v) {
      const JsonValue* aiv = aiv_of(shown, "CoSiVA.virtual/V" + std::to_string(v + 1));
      ASSERT_NE(aiv, nullptr);
      const Point2 p{aiv->number("x").value(), aiv->number("y").value()};
      if (i == 0) first[v] = p;
      furthest_m[v] = std::max(furthest_m[v], distance(p, first[v]));
      for (const auto& real : world->plant().vehicles())
        nearest_m = std::min(nearest_m, distance(p, position(real.X_MB)));
    }
  }
  EXPECT_GT(nearest_m, 0.12) << "bodies are 0.20 m by 0.12 m";
  for (const double furthest : furthest_m) EXPECT_GT(furthest, 1.5) << "each circulates";
  for (const auto& real : world->plant().vehicles()) EXPECT_GT(real.distance_m, 10.0);
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
  EXPECT_EQ(bijection(*world).number("augmented"), 3.0);
}

TEST(Augmented, a_physical_obstacle_is_shown_at_its_position_and_vanishes_when_passed_and_not_detected) {
  const auto world = world_of(1);
  world->run_for(5s);
  // At the centre of the south-eastern loop's arc (centre (0.75, -0.75), radius 0.60).
  const Point2 box{1.1742640687, -1.1742640687};
  world->command_plant(R"({"addObstacle":{"id":"box","x":1.1742640687,"y":-1.1742640687,"radius":0.05}})");
  world->run_for(60s);
  {
    const JsonValue shown = snapshot(*world);
    ASSERT_EQ(shown.find("obstacles")->array()->size(), 1U);
    const JsonValue& twin = shown.find("obstacles")->array()->at(0);
    EXPECT_LT(distance({twin.number("x").value(), twin.number("y").value()}, box), 0.08);
    EXPECT_NEAR(twin.number("radius").value(), 0.05, 0.04);
    EXPECT_EQ(*twin.find("detectedBy")->array()->at(0).text(), "CoSiVA/AIV1");
  }
  world->command_plant(R"({"removeObstacle":"box"})");
  world->run_for(15s);
  EXPECT_THAT(*snapshot(*world).find("obstacles")->array(), ::testing::IsEmpty());
  const JsonValue metrics = bijection(*world);
  EXPECT_GE(metrics.find("effects")->find("shown_ms")->number("count"), 1.0);
}

TEST(Augmented, vehicles_that_detect_each_other_report_no_obstacle) {
  const auto world = world_of(8);
  for (int i = 0; i < 120; ++i) {
    world->run_for(500ms);
    EXPECT_THAT(*snapshot(*world).find("obstacles")->array(), ::testing::IsEmpty()) << "after " << i / 2 << " s";
  }
}

TEST(Augmented, all_of_it_is_restored_after_the_server_was_killed) {
  const auto world = world_of(2);
  world->run_for(10s);
  world->command_server(R"({"command":"add","virtualObject":{"kind":"person","id":"P1","x":0.0,"y":0.9}})");
  world->command_server(R"({"command":"add","virtualObject":{"kind":"aiv","id":"V1"}})");
  world->command_server(R"({"command":"edit","edit":{"moveTags":[{"number":1,"section":"east","s":1.2}]}})");
  world->run_for(5s);
  world->kill_server();
  world->run_for(2s);
  world->start_server();
  world->run_for(5s);
  const JsonValue shown = snapshot(*world);
  EXPECT_EQ(shown.find("virtualObjects")->array()->size(), 1U);
  EXPECT_NE(aiv_of(shown, "CoSiVA.virtual/V1"), nullptr);
  EXPECT_THAT(world->server().zone_configuration()->text, ::testing::HasSubstr("s_m = 1.2"));
  world->run_for(60s);
  for (const auto& v : world->plant().vehicles()) EXPECT_GT(v.distance_m, 5.0) << "AIV" << v.number;
  EXPECT_THAT(world->plant().collisions(), ::testing::IsEmpty());
}

TEST(Augmented, a_tag_moved_on_the_page_moves_everywhere_and_rectifies_at_its_new_position) {
  const auto world = world_of(1);
  world->run_for(10s);
  world->command_server(
      R"({"command":"edit","edit":{"removeTags":[3],"addTags":[{"number":77,"section":"loop_ne","s":0.5}]}})");
  std::vector<double> detected;
  for (int i = 0; i < 900; ++i) {
    world->run_for(100ms);
    const JsonValue shown = snapshot(*world);
    const auto tag = aiv_of(shown, "CoSiVA/AIV1")->number("lastTag");
    if (tag && (detected.empty() || detected.back() != *tag)) detected.push_back(*tag);
  }
  EXPECT_THAT(detected, ::testing::Contains(77.0));
  EXPECT_THAT(detected, ::testing::Not(::testing::Contains(3.0)));
  const auto ground_truth = vehicle(*world, 1);
  const auto current_estimate = world->aiv(1).estimated_pose();
  ASSERT_TRUE(current_estimate.has_value());
  EXPECT_LT(distance(position(*current_estimate), position(ground_truth.X_MB)), 0.03);
}

TEST(Augmented, gives_the_same_digest_twice) {
  const auto run = [] {
    const auto world = world_of(3, 5, 0.02);
    world->run_for(8s);
    world->command_server(R"({"command":"add","virtualObject":{"kind":"aiv","id":"V1"}})");
    world->command_server(
        R"({"command":"add","virtualObject":{"kind":"person","id":"P1","path":[[0.5,0.5],[-0.5,0.5]],"speed":0.2,"repeat":"loop"}})");
    world->run_for(20s);
    return world->digest().hex();
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace cosiva::experiments
