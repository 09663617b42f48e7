#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck/gtest.h>

#include <cmath>

#include "cosiva/base/digest.h"
#include "cosiva/physical/plant/plant_fixture.h"
#include "cosiva/physical/plant/test_zones.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::physical {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

constexpr wire::Drive fast{500, 800, 1000, 0};
constexpr wire::Drive still{0, 800, 1000, 0};

/// Two straight sections, at a right angle.
zone::ZoneConfiguration corner() {
  std::string text{zone_head};
  text += R"(
[[section]]
name = "in"
kind = "straight"
length_m = 1.0
pivots = true
next = ["north"]
[[section]]
name = "north"
kind = "straight"
start = { x = 1.0, y = 0.0, heading_deg = 90 }
length_m = 4.0
next = []
)";
  return {"toml", "corner", text + "[[start]]\nsection = \"in\"\ns_m = 0.5\n"};
}

class RestartedPlant : public ::testing::Test {
 protected:
  static double odometer_m(const PlantFixture& fixture, std::uint32_t vehicle = 1) {
    return 1e-6 * static_cast<double>(fixture.received<wire::Odometry>(vehicle).back().distance_um);
  }
};

TEST_F(RestartedPlant, has_its_vehicles_where_they_were_at_most_100_ms_before_its_end) {
  PlantFixture fixture{lacet4(), 2};
  fixture.drive(1, fast);
  fixture.run_for(7s);
  const TrueVehicle before = fixture.ground_truth(1);
  const TrueVehicle other = fixture.ground_truth(2);
  fixture.restart();
  const TrueVehicle after = fixture.ground_truth(1);
  EXPECT_LE(after.distance_m, before.distance_m);
  EXPECT_GE(after.distance_m, before.distance_m - 0.5 * 0.1 - 1e-9);
  EXPECT_NEAR(distance(after.X_MB, before.X_MB), before.distance_m - after.distance_m, 1e-3);
  EXPECT_NEAR(after.charge, before.charge, 1e-4);
  EXPECT_LT(after.charge, 1.0);
  EXPECT_EQ(fixture.ground_truth(2).X_MB, other.X_MB);
  EXPECT_THAT(fixture.logged, IsEmpty());
}

TEST_F(RestartedPlant, has_the_boards_of_the_same_sessions_and_the_same_odometer) {
  PlantFixture fixture{lacet4(), 1};
  fixture.drive(1, fast);
  fixture.run_for(7s);
  const auto session = fixture.received<wire::Hello>(1).front().session;
  const double before_m = odometer_m(fixture);
  const std::uint32_t before_ms = fixture.received<wire::Odometry>(1).back().board_ms;
  fixture.forget();
  fixture.restart();
  fixture.run_for(20ms);
  EXPECT_EQ(fixture.received<wire::Hello>(1).front().session, session);
  EXPECT_NEAR(odometer_m(fixture), before_m, 0.5 * 0.12);
  EXPECT_NEAR(odometer_m(fixture), fixture.ground_truth(1).distance_m, 0.02);
  EXPECT_NEAR(fixture.received<wire::Odometry>(1).back().board_ms, before_ms + 2020, 41);
}

TEST_F(RestartedPlant, lets_no_vehicle_drive_on_without_a_new_command) {
  PlantFixture fixture{straight(20.0)};
  fixture.drive(1, fast);
  fixture.run_for(3s);
  fixture.fall_unresponsive(1);
  fixture.restart();
  const double at_start_m = fixture.ground_truth(1).distance_m;
  fixture.run_for(3s);
  // From 0.5 m/s with 1 m/s², behind the motor's lag.
  EXPECT_NEAR(fixture.ground_truth(1).distance_m, at_start_m + 0.5 * 0.5 / 2.0 + 0.5 * 0.05, 0.01);
  EXPECT_EQ(fixture.ground_truth(1).speed_mps, 0.0);
}

RC_GTEST_FIXTURE_PROP(RestartedPlant, ends_where_an_undisturbed_one_ends_whenever_it_died, ()) {
  // Through the drive to the joint, the turn on the spot, and the drive away from it.
  const auto died_at = 10 * std::chrono::milliseconds{*rc::gen::inRange(1, 800)};
  PlantFixture fixture{corner()};
  fixture.drive(1, fast);
  fixture.run_for(died_at);
  fixture.restart();
  fixture.run_for(20s);
  const Pose2 end = fixture.ground_truth(1).X_MB;
  RC_ASSERT(distance(end, Pose2{1.0, 4.0, 0.5 * pi}) < 0.005);
  RC_ASSERT(std::fabs(wrap_angle(end.heading_rad - 0.5 * pi)) < 0.01);
}

TEST_F(RestartedPlant, has_the_obstacles_that_it_had) {
  PlantFixture fixture{straight(20.0)};
  fixture.run_for(1s);
  fixture.feed(wire::InputKind::command, "", R"({"addObstacle":{"id":"box","x":5.0,"y":0.4,"radius":0.1}})");
  fixture.restart();
  fixture.feed(wire::InputKind::command, "", R"({"removeObstacle":"crate"})");
  EXPECT_THAT(fixture.logged, ElementsAre(HasSubstr("there is box")));
  fixture.feed(wire::InputKind::command, "", R"({"removeObstacle":"box"})");
  fixture.restart();
  fixture.feed(wire::InputKind::command, "", R"({"removeObstacle":"box"})");
  EXPECT_THAT(fixture.logged.back(), HasSubstr("there is none at all"));
}

TEST_F(RestartedPlant, counts_the_contacts_before_it) {
  PlantFixture fixture{straight(20.0)};
  fixture.feed(wire::InputKind::command, "", R"({"addObstacle":{"id":"box","x":2.0,"y":0.0,"radius":0.1}})");
  fixture.drive(1, fast);
  fixture.run_for(6s);
  ASSERT_EQ(fixture.core().collisions().size(), 1U);
  const SimTime at = fixture.core().collisions().front().at;
  fixture.restart();
  ASSERT_EQ(fixture.core().collisions().size(), 1U);
  EXPECT_EQ(fixture.core().collisions().front().at, at);
  EXPECT_EQ(fixture.core().collisions().front().b, "box");
}

TEST_F(RestartedPlant, has_the_batteries_that_were_installed) {
  PlantFixture fixture{straight(20.0)};
  fixture.run_for(1s);
  fixture.feed(wire::InputKind::command, "",
               R"({"changeBattery":{"vehicle":1,"id":"B7","type":"leaf33","charge":0.6,"cycles":120}})");
  fixture.feed(wire::InputKind::command, "", R"({"setLoad":{"vehicle":1,"factor":4}})");
  fixture.run_for(60s);
  const TrueVehicle before = fixture.ground_truth(1);
  const auto reported_permille = fixture.received<wire::Power>(1).back().charge_permille;
  fixture.restart();
  const TrueVehicle after = fixture.ground_truth(1);
  EXPECT_NEAR(after.charge, before.charge, 1e-6);
  EXPECT_LT(after.charge, 0.6);
  EXPECT_NEAR(after.power.voltage_v, before.power.voltage_v, 1e-3);
  EXPECT_NEAR(after.power.load_w, before.power.load_w, 1e-9);
  fixture.run_for(1s);
  EXPECT_NEAR(fixture.received<wire::Power>(1).back().charge_permille, reported_permille, 2)
      << "the gauge continues as well";
}

TEST_F(RestartedPlant, remains_on_the_zone_that_it_was_switched_to) {
  PlantFixture fixture{straight(20.0)};
  fixture.feed(wire::InputKind::message, std::string(wire::zone_topic_prefix) + "toml", corner().text);
  fixture.run_for(100ms);
  const TrueVehicle before = fixture.ground_truth(1);
  fixture.restart();
  EXPECT_EQ(fixture.core().options().zone.text, corner().text);
  EXPECT_EQ(fixture.ground_truth(1).X_MB, before.X_MB);
  EXPECT_EQ(fixture.ground_truth(1).position, std::nullopt) << "off the new floor's path";
  fixture.restart();
  EXPECT_EQ(fixture.core().options().zone.text, corner().text);
}

TEST_F(RestartedPlant, has_a_vehicle_that_had_not_stopped_since_a_switch_on_the_floor_before) {
  PlantFixture fixture{straight(20.0), 1};
  fixture.drive(1, fast);
  fixture.run_for(3s);
  fixture.feed(wire::InputKind::message, std::string(wire::zone_topic_prefix) + "toml", corner().text);
  fixture.run_for(100ms);
  fixture.restart();
  EXPECT_EQ(fixture.core().options().zone.text, corner().text);
  fixture.run_for(1s);
  EXPECT_NEAR(fixture.ground_truth(1).speed_mps, 0.5, 1e-3);
  fixture.drive(1, still);
  fixture.run_for(2s);
  EXPECT_EQ(fixture.ground_truth(1).position, std::nullopt) << "stopped: off the new floor's path";
}

TEST_F(RestartedPlant, does_not_restore_what_a_plant_with_other_options_has_persisted) {
  PlantFixture fixture{straight(20.0)};
  fixture.drive(1, fast);
  fixture.run_for(3s);
  fixture.options.seed = 2;
  fixture.restart();
  EXPECT_EQ(fixture.ground_truth(1).distance_m, 0.0);
  EXPECT_THAT(fixture.logged, ElementsAre(HasSubstr("the vehicles are at their start positions: ")));
}

TEST_F(RestartedPlant, whose_zone_file_was_moved_persists_the_same_bytes) {
  PlantFixture fixture{lacet4()};
  zone::ZoneConfiguration moved = lacet4();
  moved.origin = "elsewhere/" + moved.origin;
  PlantFixture other{moved};
  for (PlantFixture* each : {&fixture, &other}) each->run_for(1s);
  EXPECT_NE(fixture.persisted, "");
  EXPECT_EQ(fixture.persisted, other.persisted);
}

TEST_F(RestartedPlant, begins_at_the_start_positions_where_the_state_is_damaged) {
  PlantFixture fixture{straight(20.0)};
  fixture.drive(1, fast);
  fixture.run_for(3s);
  fixture.persisted[fixture.persisted.size() / 2] ^= 1;
  fixture.restart();
  EXPECT_EQ(fixture.ground_truth(1).distance_m, 0.0);
  EXPECT_THAT(fixture.logged, ElementsAre(HasSubstr("start positions: not a whole snapshot")));
}

TEST_F(RestartedPlant, whose_frames_pass_as_values_persists_nothing_but_has_the_bytes) {
  PlantFixture fixture{straight(20.0)};
  fixture.options.as_values = true;
  fixture.restart();
  fixture.persisted.clear();
  fixture.run_for(1s);
  EXPECT_EQ(fixture.persisted, "");
  EXPECT_NE(fixture.core().persisted_bytes(), "");
}

TEST_F(RestartedPlant, has_the_layout_of_its_format_number) {
  const auto layout_of = [](PlantFixture fixture) {
    fixture.run_for(1s);
    Digest digest;
    for (const auto& [type, members] : persisted_layout(fixture.core())) {
      digest.add(std::string_view{type});
      digest.add(std::string_view{members});
    }
    return digest.hex();
  };
  const std::string layout = layout_of(PlantFixture{straight(20.0)});
  EXPECT_EQ(layout, PlantCore::persisted_layout_digest)
      << "The members that the plant persists have changed: increase PlantCore::persisted_format, and set "
         "persisted_layout_digest to \""
      << layout << '"';
  EXPECT_EQ(layout_of(PlantFixture{lacet4(), 3}), layout) << "the layout depends on the state";
}

}  // namespace
}  // namespace cosiva::physical
