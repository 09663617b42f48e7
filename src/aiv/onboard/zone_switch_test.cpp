// Another zone while the vehicle runs.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/localisation/persisted_position.h"
#include "cosiva/aiv/onboard/onboard_fixture.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::lacet4_configuration;
using test::OnboardFixture;
using test::order;
using ::testing::Contains;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

constexpr double edge_m = 0.282743338823;

/// An oval track that begins at a pose, and continues ahead of it for a metre and a half.
zone::ZoneConfiguration track_at(const Pose2& start, const std::string& name) {
  constexpr double degrees = 180.0 / pi;
  std::ostringstream text;
  text.precision(17);
  text << "name = \"" << name << "\"\nformat_version = 1\n[circuit]\nclosed = true\nstart = { x = " << start.x_m
       << ", y = " << start.y_m << ", heading_deg = " << start.heading_rad * degrees << " }\n";
  for (const char* side : {"out", "back"}) {
    text << "[[section]]\nname = \"" << side << "\"\nkind = \"straight\"\nlength_m = 1.5\n"
         << "[[section]]\nname = \"" << side << "_bend\"\nkind = \"arc\"\nradius_m = 0.5\nangle_deg = 180.0\n";
  }
  return {"toml", "track.toml", text.str()};
}

struct SwitchFixture : OnboardFixture {
  using OnboardFixture::OnboardFixture;
  std::vector<std::shared_ptr<const zone::TrafficZone>> floors;

  void announce(const zone::ZoneConfiguration& zone) {
    receive(std::string(wire::zone_topic_prefix) + zone.format, zone::to_payload(zone), true);
  }
  /// The vehicle receives the zone, and the floor changes under the vehicle as soon as it has stopped.
  void switch_to(const zone::ZoneConfiguration& zone) {
    announce(zone);
    ASSERT_TRUE(run_until([&] { return speed_mps == 0.0 && !world.manoeuvring(); }, 3.0));
    change_floor(zone);
    run(0.3);
  }
  void change_floor(const zone::ZoneConfiguration& zone) {
    auto rtm = zone::Rtm::initialise(zone);
    ASSERT_TRUE(rtm) << to_string(rtm.error());
    floors.push_back(rtm->shared_zone());
    world.set_zone(floors.back()->circuit);
  }
  /// Drives on lacet4.
  void set_off() {
    run(0.5);
    order(test::order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848", "loop_se@1131"}));
    run(1.5);
    EXPECT_GT(speed_mps, 0.2);
  }
  const zone::TrafficZone& floor() const { return *floors.back(); }
  double pose_error_m() const { return distance(*core->estimated_pose(), world.pose()); }
};

/// 0.12 m to the left of the vehicle's stopping position, and turned away from it.
zone::ZoneConfiguration track_off_path(const Pose2& X_MB, const std::string& name = "track") {
  return track_at(X_MB * Pose2{-0.3, 0.12, 0.3}, name);
}
zone::ZoneConfiguration track_near_loop(const std::string& name = "track") {
  return track_off_path(lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.55)), name);
}
const std::string first = "out@0";

TEST(ZoneSwitch, brakes_on_the_old_zone_and_keeps_its_pose_on_the_new_one) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.announce(track_near_loop());
  fixture.run(0.1);
  EXPECT_EQ(fixture.state().maps.front().map_id, "lacet4");
  ASSERT_EQ(fixture.state().maps.size(), 2U);
  EXPECT_FALSE(fixture.state().maps.back().enabled);
  ASSERT_TRUE(fixture.run_until([&] { return fixture.speed_mps == 0.0; }, 2.0));
  const Pose2 is_stopped = fixture.world.pose();
  fixture.change_floor(track_near_loop());
  fixture.run(0.3);
  const wire::State& state = fixture.state();
  ASSERT_EQ(state.maps.size(), 1U);
  EXPECT_EQ(state.maps.front().map_id, "track");
  EXPECT_TRUE(state.maps.front().enabled);
  EXPECT_EQ(state.maps.front().map_version.size(), 16U);
  EXPECT_EQ(state.position->map_id, "track");
  EXPECT_TRUE(state.position->position_initialized);
  EXPECT_LT(distance(state.position->pose, is_stopped), 0.005);
  EXPECT_NEAR(state.position->pose.heading_rad, is_stopped.heading_rad, 0.01);
  EXPECT_THAT(state.node_states, IsEmpty());
  EXPECT_EQ(state.order_id, "O-1") << "preserved until there is a new order";
  EXPECT_THAT(fixture.error_types(), Not(Contains("lineLost")));
  EXPECT_EQ(fixture.visualizations.back().position->map_id, "track");
  EXPECT_THAT(fixture.undecodable, IsEmpty());
}

// Without odometry the vehicle may still be braking: what it reported last is no standstill.
TEST(ZoneSwitch, waits_for_odometry_that_shows_that_the_vehicle_has_stopped) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.announce(track_near_loop());
  fixture.silence(wire::Board::PILS);
  fixture.run(2.0);
  EXPECT_EQ(fixture.state().maps.front().map_id, "lacet4");
  fixture.plug(wire::Board::PILS);
  ASSERT_TRUE(fixture.run_until([&] { return fixture.speed_mps == 0.0; }, 3.0));
  fixture.change_floor(track_near_loop());
  fixture.run(0.3);
  EXPECT_EQ(fixture.state().maps.front().map_id, "track");
}

TEST(ZoneSwitch, is_followed_by_a_drive_to_the_new_path_and_along_it) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.switch_to(track_near_loop());
  ASSERT_FALSE(fixture.world.on_line());
  auto text = test::order("O-2").through({first, "out@300", "out@600", "out@900"});
  text.node(0).position = wire::NodePosition{fixture.floor().circuit.pose_at({0, 0.0}).x_m,
                                             fixture.floor().circuit.pose_at({0, 0.0}).y_m,
                                             {},
                                             1.0,
                                             {},
                                             "track"};
  fixture.order(text);
  fixture.run(20.0);
  EXPECT_TRUE(fixture.world.on_line());
  EXPECT_EQ(fixture.state().last_node_id, "out@900");
  EXPECT_NEAR(fixture.world.track_position().s_m, 0.9, 0.015);
  EXPECT_LT(fixture.pose_error_m(), 0.01);
}

TEST(ZoneSwitch, drops_late_messages_for_the_old_zone) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.switch_to(track_near_loop());
  auto late = test::order("O-1", 1).from_sequence(8).through({"loop_se@1131", "loop_se@1414"});
  fixture.order(late);
  fixture.run(0.2);
  EXPECT_THAT(fixture.state().node_states, IsEmpty());
  EXPECT_THAT(fixture.error_types(), Contains("orderUpdateError"));
}

TEST(ZoneSwitch, accepts_no_order_until_it_is_done) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.announce(track_near_loop());
  fixture.order(test::order("O-1", 1).from_sequence(8).through({"loop_se@1131", "loop_se@1414"}));
  fixture.run(0.1);
  EXPECT_THAT(fixture.error_types(), Contains("noRouteError"));
}

TEST(ZoneSwitch, keeps_pause_and_speed_limit) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.act("startPause", "p");
  fixture.act("setSpeedLimit", "s", {{"profile", std::string("slow")}});
  fixture.run(1.0);
  fixture.switch_to(track_near_loop());
  EXPECT_TRUE(fixture.state().paused);
  EXPECT_EQ(fixture.state().position->map_id, "track");
  EXPECT_EQ(fixture.action("p")->status, wire::ActionStatus::finished);
  EXPECT_EQ(persisted_position_from_json(fixture.persisted)->imposed, Profile::slow);
  EXPECT_TRUE(persisted_position_from_json(fixture.persisted)->paused);
}

TEST(ZoneSwitch, to_an_invalid_configuration_does_not_happen) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.announce({"toml", "x", "name = 7"});
  fixture.run(0.5);
  EXPECT_GT(fixture.speed_mps, 0.2) << "an invalid configuration does not stop the vehicle";
  EXPECT_THAT(fixture.error_types(), Contains("zoneError"));
  fixture.announce({"nonsense", "x", "name = 7"});
  fixture.run(0.5);
  EXPECT_THAT(fixture.error_types(), Contains("zoneError"));
  EXPECT_EQ(fixture.state().position->map_id, "lacet4");
  fixture.announce(lacet4_configuration());
  fixture.run(0.5);
  EXPECT_THAT(fixture.error_types(), Not(Contains("zoneError"))) << "the last configuration is valid";
}

TEST(ZoneSwitch, ignores_a_cleared_topic) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.receive(std::string(wire::zone_topic_prefix) + "other", "", true);
  fixture.run(0.3);
  EXPECT_THAT(fixture.error_types(), IsEmpty());
  EXPECT_GT(fixture.speed_mps, 0.2);
}

TEST(ZoneSwitch, back_before_the_standstill_is_called_off_and_the_vehicle_drives_on) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.announce(track_near_loop());
  fixture.run(0.1);
  fixture.announce(lacet4_configuration());
  fixture.run(1.0);
  EXPECT_GT(fixture.speed_mps, 0.2);
  EXPECT_EQ(fixture.state().maps.size(), 1U);
  EXPECT_FALSE(fixture.state().node_states.empty());
}

TEST(ZoneSwitch, twice_in_quick_succession_ends_on_the_last) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.announce(track_near_loop("one"));
  fixture.run(0.06);
  fixture.announce(track_near_loop("two"));
  fixture.announce({"toml", "x", "name = 7"});
  fixture.run(1.0);
  EXPECT_EQ(fixture.state().position->map_id, "two");
}

TEST(ZoneSwitch, back_and_forth_ends_where_it_began) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.switch_to(track_near_loop());
  fixture.switch_to(lacet4_configuration());
  EXPECT_EQ(fixture.state().position->map_id, "lacet4");
  EXPECT_LT(fixture.pose_error_m(), 0.005);
  auto text = test::order("O-3").through({"loop_se@565", "loop_se@848", "loop_se@1131"});
  text.node(0).position = wire::NodePosition{0.0, 0.0, {}, 0.5, {}, "lacet4"};
  const Pose2 node = lacet4().circuit.pose_at(at(lacet4(), "loop_se", 2.0 * edge_m));
  text.node(0).position->x_m = node.x_m;
  text.node(0).position->y_m = node.y_m;
  fixture.order(text);
  fixture.run(12.0);
  EXPECT_EQ(fixture.state().last_node_id, "loop_se@1131");
  EXPECT_LT(fixture.pose_error_m(), 0.01);
}

TEST(ZoneSwitch, to_other_sections_under_the_same_name_takes_place) {
  SwitchFixture fixture;
  fixture.set_off();
  const std::string version = fixture.state().maps.front().map_version;
  fixture.switch_to(track_near_loop("lacet4"));
  EXPECT_EQ(fixture.state().maps.front().map_id, "lacet4");
  EXPECT_NE(fixture.state().maps.front().map_version, version);
  EXPECT_THAT(fixture.state().node_states, IsEmpty());
}

TEST(ZoneSwitch, to_a_distant_zone_leaves_the_vehicle_off_route_until_the_next_one) {
  SwitchFixture fixture;
  fixture.set_off();
  const Pose2 is_stopped = lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.5));
  fixture.switch_to(track_at(is_stopped * Pose2{0.0, 3.0, 0.0}, "far"));
  EXPECT_EQ(fixture.state().position->map_id, "far");
  EXPECT_TRUE(fixture.state().position->position_initialized);
  EXPECT_LT(fixture.pose_error_m(), 0.005);
  EXPECT_THAT(fixture.error_types(), Contains("offCircuit"));
  fixture.order(test::order("O-2").through({first, "out@300"}));
  fixture.run(0.2);
  EXPECT_THAT(fixture.error_types(), Contains("noRouteError"));
  EXPECT_EQ(fixture.speed_mps, 0.0);
  fixture.switch_to(track_near_loop());
  EXPECT_THAT(fixture.error_types(), Not(Contains("offCircuit")));
}

TEST(ZoneSwitch, is_persisted_over_a_crash_off_the_path) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.switch_to(track_near_loop());
  auto setup = fixture.reborn();
  setup.zone = track_near_loop();
  setup.start = std::nullopt;
  SwitchFixture after{setup};
  after.world = fixture.world;
  after.run(0.5);
  EXPECT_EQ(after.state().position->map_id, "track");
  EXPECT_LT(after.pose_error_m(), 0.005);
  EXPECT_THAT(after.error_types(), IsEmpty());
}

TEST(ZoneSwitch, is_restored_by_a_program_that_was_started_with_the_old_zone) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.switch_to(track_near_loop());
  SwitchFixture after{fixture.reborn()};
  after.world = fixture.world;
  after.run(0.1);
  after.announce(track_near_loop());
  after.run(0.5);
  EXPECT_EQ(after.state().position->map_id, "track");
  EXPECT_LT(after.pose_error_m(), 0.005);
}

/// Saved on lacet4, where the vehicle has stopped, and started again when the floor has another zone.
SwitchFixture::Setup reborn_in_another_zone(SwitchFixture& fixture) {
  fixture.set_off();
  fixture.act("startPause", "p");
  EXPECT_TRUE(fixture.run_until([&] { return fixture.speed_mps == 0.0; }, 2.0));
  fixture.run(0.3);
  auto setup = fixture.reborn();
  setup.zone = track_near_loop();
  setup.start = std::nullopt;
  return setup;
}

TEST(ZoneSwitch, while_its_program_was_down_leaves_a_stopped_vehicle_where_it_was) {
  SwitchFixture fixture;
  const auto setup = reborn_in_another_zone(fixture);
  SwitchFixture after{setup};
  after.world = fixture.world;
  after.change_floor(track_near_loop());
  after.run(2.5);
  EXPECT_FALSE(after.core->estimated_pose()) << "the saved zone may still arrive";
  after.run(1.0);
  ASSERT_TRUE(after.core->estimated_pose());
  EXPECT_LT(after.pose_error_m(), 0.005);
  EXPECT_EQ(after.state().position->map_id, "track");
  EXPECT_TRUE(after.state().paused);
}

TEST(ZoneSwitch, while_its_program_was_down_loses_a_vehicle_that_has_moved) {
  SwitchFixture fixture;
  const auto setup = reborn_in_another_zone(fixture);
  SwitchFixture after{setup};
  after.world = fixture.world;
  after.world.odometer_m += 0.02;
  after.change_floor(track_near_loop());
  after.run(5.0);
  EXPECT_FALSE(after.core->estimated_pose());
  EXPECT_THAT(after.error_types(), Contains("positionUnknown"));
}

TEST(ZoneSwitch, while_its_program_was_down_finds_a_vehicle_that_has_moved_where_the_section_is_the_same) {
  SwitchFixture fixture;
  auto setup = reborn_in_another_zone(fixture);
  setup.zone = lacet4_configuration();
  setup.zone->text.replace(setup.zone->text.find("\"lacet4\""), 8, "\"floor\"");
  SwitchFixture after{setup};
  after.world = fixture.world;
  after.world.odometer_m += 0.02;
  after.run(3.5);
  ASSERT_TRUE(after.core->estimated_pose());
  EXPECT_NEAR(after.pose_error_m(), 0.02, 0.005) << "by the odometer";
  EXPECT_EQ(after.state().position->map_id, "floor");
}

TEST(ZoneSwitch, back_to_the_saved_zone_finds_a_vehicle_that_has_moved_however_late_it_is) {
  SwitchFixture fixture;
  const auto setup = reborn_in_another_zone(fixture);
  SwitchFixture after{setup};
  after.world = fixture.world;
  after.world.odometer_m += 0.02;
  after.run(5.0);
  ASSERT_FALSE(after.core->estimated_pose());
  after.announce(lacet4_configuration());
  after.run(0.5);
  ASSERT_TRUE(after.core->estimated_pose());
  EXPECT_NEAR(after.pose_error_m(), 0.02, 0.005);
}

TEST(ZoneSwitch, is_restored_halfway_to_the_path) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.switch_to(track_near_loop());
  auto text = test::order("O-2").through({first, "out@300", "out@600"});
  text.node(0).position = wire::NodePosition{fixture.floor().circuit.pose_at({0, 0.0}).x_m,
                                             fixture.floor().circuit.pose_at({0, 0.0}).y_m,
                                             {},
                                             1.0,
                                             {},
                                             "track"};
  fixture.order(text);
  ASSERT_TRUE(fixture.run_until([&] { return fixture.world.manoeuvring(); }, 3.0));
  fixture.run(0.6);
  auto setup = fixture.reborn();
  setup.zone = track_near_loop();
  setup.start = std::nullopt;
  SwitchFixture after{setup};
  after.world = fixture.world;
  after.floors = fixture.floors;
  after.run(0.5);
  EXPECT_LT(after.pose_error_m(), 0.01);
  after.order(text);
  after.run(15.0);
  EXPECT_TRUE(after.world.on_line());
  EXPECT_LT(after.pose_error_m(), 0.01);
}

// Two vehicles that a switch left next to each other: one of them makes room for the other as before the switch.
TEST(ZoneSwitch, that_leaves_a_path_under_the_vehicle_permits_backing_up_along_it) {
  SwitchFixture fixture;
  fixture.run(0.5);
  fixture.switch_to(track_at(fixture.world.pose() * Pose2{-0.8, 0.0, 0.0}, "track"));
  const Pose2 is_stopped = fixture.world.pose();
  fixture.act("backUp", "b1", {{"distance", 0.25}});
  fixture.run(6.0);
  EXPECT_EQ(fixture.action("b1")->status, wire::ActionStatus::finished);
  EXPECT_LT(distance(fixture.world.pose(), is_stopped * Pose2{-0.25, 0.0, 0.0}), 0.01);
  EXPECT_LT(fixture.pose_error_m(), 0.01);
}

TEST(ZoneSwitch, that_leaves_no_path_under_the_vehicle_permits_no_backing_up) {
  SwitchFixture fixture;
  fixture.run(0.5);
  fixture.switch_to(track_at(fixture.world.pose() * Pose2{-0.8, 0.01, 0.0}, "track"));
  fixture.act("backUp", "beside", {{"distance", 0.25}});
  fixture.run(0.2);
  EXPECT_EQ(fixture.action("beside")->status, wire::ActionStatus::failed);
  fixture.switch_to(track_at(fixture.world.pose() * Pose2{-0.8, 0.0, 0.6}, "askew"));
  fixture.act("backUp", "askew", {{"distance", 0.25}});
  fixture.run(0.2);
  EXPECT_EQ(fixture.action("askew")->status, wire::ActionStatus::failed);
  EXPECT_EQ(fixture.speed_mps, 0.0);
}

TEST(ZoneSwitch, is_followed_by_a_joinLine_onto_the_path_without_an_order) {
  SwitchFixture fixture;
  fixture.set_off();
  fixture.switch_to(track_near_loop());
  const auto join = [&](const char* id, const Pose2& X_MG) {
    fixture.act("joinLine", id, {{"x", X_MG.x_m}, {"y", X_MG.y_m}, {"theta", X_MG.heading_rad}});
    fixture.run(0.3);
    return fixture.action(id)->status;
  };
  EXPECT_EQ(join("far", {9.0, 9.0, 0.0}), wire::ActionStatus::failed);
  fixture.act("joinLine", "nowhere", {{"x", 1.0}, {"y", std::string("north")}});
  fixture.run(0.3);
  EXPECT_EQ(fixture.action("nowhere")->status, wire::ActionStatus::failed);
  EXPECT_EQ(join("there", fixture.floor().circuit.pose_at({0, 0.5})), wire::ActionStatus::running);
  EXPECT_EQ(join("elsewhere", fixture.floor().circuit.pose_at({0, 0.2})), wire::ActionStatus::failed)
      << "the vehicle is joining already";
  fixture.run(8.0);
  EXPECT_EQ(fixture.action("there")->status, wire::ActionStatus::finished);
  ASSERT_TRUE(fixture.world.on_line());
  EXPECT_NEAR(fixture.world.track_position().s_m, 0.5, 0.01);
  EXPECT_EQ(join("again", fixture.floor().circuit.pose_at({0, 0.7})), wire::ActionStatus::failed)
      << "the vehicle is on the path";
}

TEST(ZoneSwitch, responds_to_enableMap_and_downloadMap) {
  SwitchFixture fixture;
  fixture.run(0.5);
  const auto request_switch = [&](std::string type, const std::string& id, const std::string& map) {
    fixture.act(std::move(type), id, {{"mapId", map}, {"mapVersion", std::string{}}});
    fixture.run(0.1);
    return fixture.action(id)->status;
  };
  EXPECT_EQ(request_switch("enableMap", "a", "lacet4"), wire::ActionStatus::finished);
  EXPECT_EQ(request_switch("enableMap", "b", "attic"), wire::ActionStatus::failed);
  EXPECT_EQ(request_switch("downloadMap", "c", "attic"), wire::ActionStatus::failed);
  EXPECT_EQ(request_switch("downloadMap", "d", "lacet4"), wire::ActionStatus::finished);
  fixture.set_off();
  fixture.announce(track_near_loop());
  EXPECT_EQ(request_switch("enableMap", "e", "track"), wire::ActionStatus::running);
  fixture.run(1.0);
  EXPECT_EQ(fixture.action("e")->status, wire::ActionStatus::finished);
}

TEST(PersistedPosition, keeps_an_off_path_pose_and_a_manoeuvre) {
  PersistedPosition persisted{
      "z", "s", 1.5, 7, 9, true, Profile::slow, Pose2{1.0, 2.0, 0.5}, true, Pose2{0.1, 0.0, -0.2}, "next"};
  EXPECT_EQ(persisted_position_from_json(to_json(persisted)).value(), persisted);
  const auto damaged = persisted_position_from_json(R"({"zone":"z","section":"s","s":1,"odometer_um":1,"session":1,)"
                                                    R"("pose":{"x":1e300,"y":0,"theta":0},"off_path":true})");
  ASSERT_TRUE(damaged);
  EXPECT_FALSE(damaged->pose);
  EXPECT_FALSE(damaged->off_path) << "without a pose only the position is known";
}

}  // namespace
}  // namespace cosiva::aiv
