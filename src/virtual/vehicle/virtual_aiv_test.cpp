#include "cosiva/virtual/vehicle/virtual_aiv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/testing/test_zone.h"
#include "cosiva/virtual/vehicle/virtual_fixture.h"

namespace cosiva::virtual_side {
namespace {

using aiv::test::at;
using aiv::test::lacet4;
using ::testing::IsEmpty;

struct Lacet4Fixture : test::VirtualFixture {
  Lacet4Fixture(std::string_view section, double s_m)
      : VirtualFixture{aiv::test::lacet4_configuration(), lacet4(), at(lacet4(), section, s_m)} {}
};

const std::vector<std::string> to_1131{"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848", "loop_se@1131"};

TEST(VirtualAiv, announces_itself_as_a_vehicle_of_its_own_manufacturer) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.2);
  EXPECT_EQ(fixture.aiv.id(), (wire::VehicleId{"CoSiVA.virtual", "V1"}));
  ASSERT_EQ(fixture.connections.size(), 1U);
  EXPECT_EQ(fixture.connections[0].state, wire::ConnectionState::online);
  EXPECT_FALSE(fixture.factsheets.empty());
  ASSERT_FALSE(fixture.states.empty());
  ASSERT_TRUE(fixture.state().position);
  EXPECT_LT(distance(fixture.state().position->pose, lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.0))), 1e-6);
  // An observer of its appearance receives no error.
  EXPECT_THAT(fixture.states.front().errors, IsEmpty());
  EXPECT_EQ(fixture.states.front().battery.charge_percent, 100.0);
  EXPECT_THAT(fixture.strange, IsEmpty());
}

TEST(VirtualAiv, stays_stopped_until_it_is_commanded_to_drive) {
  Lacet4Fixture fixture{"loop_se", 0.3};
  fixture.run(3.0);
  EXPECT_EQ(fixture.aiv.track_position().s_m, 0.3);
  EXPECT_EQ(fixture.aiv.speed_mps(), 0.0);
}

TEST(VirtualAiv, drives_its_order_and_reports_the_nodes) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.2);
  fixture.order(to_1131);
  double fastest_mps = 0.0;
  for (int i = 0; i < 500; ++i) {
    const double before_mps = fixture.aiv.speed_mps();
    fixture.step();
    const double change_mps2 = (fixture.aiv.speed_mps() - before_mps) / 0.02;
    EXPECT_LE(change_mps2, lacet4().profiles.medium.acceleration_mps2 + 1e-6);
    fastest_mps = std::max(fastest_mps, fixture.aiv.speed_mps());
  }
  EXPECT_NEAR(fastest_mps, lacet4().profiles.medium.speed_mps, 1e-6);
  EXPECT_EQ(fixture.aiv.speed_mps(), 0.0);
  EXPECT_NEAR(fixture.aiv.track_position().s_m, 1.131, 0.01);
  EXPECT_EQ(fixture.state().last_node_id, "loop_se@1131");
  EXPECT_THAT(fixture.state().node_states, IsEmpty());
  EXPECT_THAT(fixture.strange, IsEmpty());
}

TEST(VirtualAiv, reads_the_tags_it_passes_and_knows_its_position) {
  Lacet4Fixture fixture{"east", 1.12};
  fixture.run(0.2);
  fixture.order({"east@1120", "east@1310", "loop_se@0", "loop_se@283", "loop_se@565"});
  ASSERT_TRUE(fixture.run_until([&] { return fixture.state().last_node_id == "loop_se@565"; }, 8.0));
  fixture.run(1.0);
  ASSERT_FALSE(fixture.state().information.empty());
  EXPECT_EQ(fixture.state().information[0].type, "lastTag");
  EXPECT_EQ(fixture.state().information[0].references[0].value, "1");
  EXPECT_LT(fixture.estimate_error_m(), 0.002);
}

TEST(VirtualAiv, estimates_its_position_correctly_all_round_the_circuit) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.2);
  fixture.order({"loop_se@0", "loop_se@2545"});
  double worst_m = 0.0;
  for (int i = 0; i < 400; ++i) {
    fixture.step();
    // A position is up to a period of visualization old.
    if (fixture.aiv.speed_mps() == 0.0) worst_m = std::max(worst_m, fixture.estimate_error_m());
  }
  EXPECT_LT(worst_m, 0.003);
}

TEST(VirtualAiv, stops_within_half_a_second_without_heartbeats_of_its_host) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.5);
  fixture.order({"loop_se@0", "loop_se@2545"});
  fixture.run(1.5);
  EXPECT_GT(fixture.aiv.speed_mps(), 0.2);
  fixture.server_heartbeats = false;
  fixture.run(1.5);
  EXPECT_EQ(fixture.aiv.speed_mps(), 0.0);
  fixture.server_heartbeats = true;
  fixture.run(1.5);
  EXPECT_GT(fixture.aiv.speed_mps(), 0.2);
}

TEST(VirtualAiv, does_not_jump_after_a_pause_of_its_host) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.5);
  fixture.order(to_1131);
  fixture.run(1.5);
  const double before_m = fixture.aiv.track_position().s_m;
  fixture.now += std::chrono::seconds{10};
  fixture.step();
  EXPECT_LT(fixture.aiv.track_position().s_m - before_m, 0.05);
}

TEST(VirtualAiv, obeys_pause_and_speed_like_any_vehicle) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.5);
  fixture.order({"loop_se@0", "loop_se@2545"});
  fixture.run(1.5);
  const auto act = [&](std::string type, std::string id, std::vector<wire::Parameter> parameters) {
    wire::InstantActions message;
    message.header = {1, fixture.now, "2.1.0", fixture.aiv.id().manufacturer, fixture.aiv.id().serial_number};
    message.actions.push_back({std::move(type), std::move(id), "", wire::BlockingType::hard, std::move(parameters)});
    fixture.receive(wire::vda_topic(fixture.aiv.id(), "instantActions"), wire::vda5050::encode(message));
  };
  act("startPause", "a1", {});
  fixture.run(1.0);
  EXPECT_EQ(fixture.aiv.speed_mps(), 0.0);
  EXPECT_TRUE(fixture.state().paused);
  act("setSpeedLimit", "a2", {{"profile", std::string("slow")}});
  act("stopPause", "a3", {});
  fixture.run(1.5);
  EXPECT_NEAR(fixture.aiv.speed_mps(), lacet4().profiles.slow.speed_mps, 1e-6);
}

TEST(VirtualAiv, stops_before_a_body_that_its_server_sent_and_continues) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.2);
  fixture.order({"loop_se@0", "loop_se@2545"});
  fixture.run(1.0);
  const Point2 p = position(lacet4().circuit.pose_at(at(lacet4(), "loop_se", 0.9)));
  const wire::Body person{"P1", "person", p.x_m, p.y_m, 0.0, 0.0, 0.06, 0.0, 0.0};
  for (int i = 0; i < 40; ++i) {
    fixture.ahead({person});
    fixture.run(0.1);
  }
  EXPECT_EQ(fixture.aiv.speed_mps(), 0.0);
  EXPECT_NEAR(0.9 - 0.06 - 0.1 - fixture.aiv.track_position().s_m, 0.12, 0.02) << "the clearance of any vehicle";
  ASSERT_FALSE(fixture.felts.empty());
  EXPECT_TRUE(fixture.felts.back().braking);
  EXPECT_EQ(fixture.felts.back().body, "P1");
  EXPECT_TRUE(fixture.state().field_violation);
  fixture.ahead({});
  fixture.run(1.0);
  EXPECT_GT(fixture.aiv.speed_mps(), 0.2);
  EXPECT_THAT(fixture.strange, IsEmpty());
}

TEST(VirtualAiv, reports_healthy_boards_without_echoes) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(2.0);
  ASSERT_FALSE(fixture.reports.empty());
  for (const auto& line : fixture.reports.back().boards) {
    EXPECT_EQ(line.health, "ok");
    EXPECT_NE(line.firmware_hash, 0U);
    EXPECT_EQ(line.frames_bad + line.frames_missed, 0U);
    EXPECT_GT(line.frames, 4U);
  }
  for (const std::uint16_t range_mm : fixture.reports.back().ranges->range_mm) EXPECT_EQ(range_mm, wire::no_echo);
  EXPECT_EQ(fixture.reports.back().power->charge_permille, 1000);
}

// --- edits of the zone
// ------------------------------------------------------------------------------------------------

zone::ZoneConfiguration edited(std::string_view from, std::string_view to) {
  zone::ZoneConfiguration configuration = aiv::test::lacet4_configuration();
  const std::size_t found = configuration.text.find(from);
  EXPECT_NE(found, std::string::npos) << from;
  configuration.text.replace(found, from.size(), to);
  return configuration;
}

TEST(VirtualAiv, reads_a_moved_tag_at_its_new_position_and_drives_on) {
  Lacet4Fixture fixture{"loop_se", 1.0};
  fixture.run(0.2);
  fixture.order({"loop_se@848", "loop_se@2545"});
  fixture.run(0.5);
  fixture.zone(edited("s_m = 1.4137", "s_m = 1.9000"));
  ASSERT_TRUE(fixture.run_until([&] { return fixture.aiv.track_position().s_m > 1.6; }, 5.0));
  EXPECT_GT(fixture.aiv.speed_mps(), 0.2);
  for (const auto& information : fixture.state().information) EXPECT_NE(information.type, "lastTag");
  fixture.run(3.0);
  EXPECT_EQ(fixture.state().information[0].type, "lastTag");
  EXPECT_EQ(fixture.state().information[0].references[0].value, "2");
  EXPECT_LT(fixture.estimate_error_m(), 0.003);
}

/// The same geometry, `up_m` further north, under another name.
zone::ZoneConfiguration shifted(double up_m) {
  zone::ZoneConfiguration configuration = edited("name = \"lacet4\"", "name = \"moved\"");
  const std::string was = "y = -0.15";
  configuration.text.replace(configuration.text.find(was), was.size(), "y = " + std::to_string(up_m - 0.15));
  return configuration;
}

TEST(VirtualAiv, drives_on_after_an_unreadable_zone) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.2);
  fixture.order({"loop_se@0", "loop_se@2545"});
  fixture.run(1.0);
  const zone::ZoneConfiguration unreadable = edited("radius_m = 0.6", "radius_m = 0.61");  // the sections do not join
  fixture.receive(std::string(wire::zone_topic_prefix) + unreadable.format, zone::to_payload(unreadable));
  fixture.run(1.5);
  EXPECT_GT(fixture.aiv.speed_mps(), 0.2);
}

TEST(VirtualAiv, stops_when_the_geometry_changes_and_is_then_off_the_new_path) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.2);
  fixture.order({"loop_se@0", "loop_se@2545"});
  fixture.run(1.5);
  const Pose2 before = fixture.aiv.X_MB();
  fixture.zone(shifted(0.1));
  fixture.run(2.5);
  EXPECT_EQ(fixture.aiv.speed_mps(), 0.0);
  const Pose2 is_stopped = fixture.aiv.X_MB();
  EXPECT_LT(distance(before, is_stopped), 0.3);
  EXPECT_LT(lacet4().circuit.locate(position(is_stopped)).distance_m, 1e-9) << "its stopping position on the old path";
  EXPECT_LT(fixture.estimate_error_m(), 0.005);
  EXPECT_EQ(fixture.state().position->map_id, "moved");
  EXPECT_THAT(fixture.state().node_states, IsEmpty()) << "that order was of the old map";
  fixture.run(2.0);
  EXPECT_EQ(fixture.aiv.X_MB(), is_stopped);
}

TEST(VirtualAiv, seeks_the_new_path_and_follows_it_with_the_next_order) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.2);
  fixture.order({"loop_se@0", "loop_se@2545"});
  fixture.run(1.0);
  fixture.zone(shifted(0.05));
  fixture.run(2.5);
  fixture.order({fixture.waypoint_behind(), "loop_se@2545"}, "O-2");
  ASSERT_TRUE(fixture.run_until([&] { return fixture.aiv.speed_mps() > 0.3; }, 15.0));
  const Point2 p = position(fixture.aiv.X_MB());
  EXPECT_LT(lacet4().circuit.locate({p.x_m, p.y_m - 0.05}).distance_m, 1e-6);
  fixture.run(0.5);
  EXPECT_LT(fixture.estimate_error_m(), 0.05) << "a position is up to a period of visualization old";
  EXPECT_THAT(fixture.strange, IsEmpty());
}

/// Nodes a (0.5, -0.2), b (1.5, -0.2) and c (1.5, 0.8), with an edge from each to the next: at b a vehicle turns on the
/// spot.
zone::ZoneConfiguration corner() {
  std::string text = R"({"metaInformation":{"projectIdentification":"corner","creator":"test",)"
                     R"("exportTimestamp":"2024-01-01T00:00:00.00Z","lifVersion":"1.0.0"},)"
                     R"("layouts":[{"layoutId":"corner","layoutVersion":"1","nodes":[)";
  const auto node = [&](const char* id, const char* x, const char* y) {
    text += std::string(R"({"nodeId":")") + id + R"(","nodePosition":{"x":)" + x + R"(,"y":)" + y;
    text += R"(},"vehicleTypeNodeProperties":[{"vehicleTypeId":"cart"}]},)";
  };
  const auto edge = [&](const char* from, const char* to) {
    text += std::string(R"({"edgeId":")") + from + to + R"(","startNodeId":")" + from + R"(","endNodeId":")" + to;
    text += R"(","vehicleTypeEdgeProperties":[{"vehicleTypeId":"cart","vehicleOrientation":0,"maxSpeed":1.0}]},)";
  };
  node("a", "0.5", "-0.2");
  node("b", "1.5", "-0.2");
  node("c", "1.5", "0.8");
  text.back() = ']';
  text += R"(,"edges":[)";
  edge("a", "b");
  edge("b", "c");
  text.back() = ']';
  text += R"(,"stations":[]}]})";
  return {"lif", "corner.lif.json", text, "[vehicle]\nlength_m = 0.20\nwidth_m = 0.12\n"};
}

TEST(VirtualAiv, drives_a_layout_after_a_switch_and_turns_on_the_spot_at_its_nodes) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.2);
  fixture.zone(corner());
  fixture.run(1.0);
  fixture.order({"a", "b", "c"});
  double slowest_at_b_mps = 1.0;
  ASSERT_TRUE(fixture.run_until(
      [&] {
        if (distance(position(fixture.aiv.X_MB()), {1.5, -0.2}) < 1e-9)
          slowest_at_b_mps = std::min(slowest_at_b_mps, fixture.aiv.speed_mps());
        return fixture.state().last_node_id == "c";
      },
      40.0))
      << fixture.aiv.X_MB().x_m << ' ' << fixture.aiv.X_MB().y_m;
  fixture.run(1.5);
  EXPECT_EQ(slowest_at_b_mps, 0.0);
  EXPECT_NEAR(fixture.aiv.X_MB().x_m, 1.5, 1e-6);
  EXPECT_NEAR(fixture.aiv.X_MB().y_m, 0.8, 0.02);
  EXPECT_NEAR(fixture.aiv.X_MB().heading_rad, 0.5 * pi, 1e-6);
  EXPECT_LT(fixture.estimate_error_m(), 0.01);
  EXPECT_THAT(fixture.state().errors, IsEmpty());
  EXPECT_THAT(fixture.strange, IsEmpty());
}

TEST(VirtualAiv, is_deterministic) {
  const auto run = [] {
    Lacet4Fixture fixture{"east", 1.12};
    fixture.run(0.2);
    fixture.order({"east@1120", "east@1310", "loop_se@0", "loop_se@283"});
    fixture.run(5.0);
    return fixture.digest();
  };
  const std::string digest = run();
  EXPECT_EQ(digest, run());
  Lacet4Fixture other{"east", 1.12};
  other.run(5.2);
  EXPECT_NE(digest, other.digest());
}

TEST(VirtualAiv, publishes_offline_when_it_is_removed) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.5);
  fixture.farewell();
  EXPECT_EQ(fixture.connections.back().state, wire::ConnectionState::offline);
  EXPECT_THAT(fixture.strange, IsEmpty());
}

TEST(VirtualAiv, publishes_nothing_while_its_host_has_no_broker) {
  Lacet4Fixture fixture{"loop_se", 0.0};
  fixture.run(0.5);
  wire::Effects effects;
  fixture.aiv.link(fixture.now, false, effects);
  const std::size_t before = fixture.states.size();
  fixture.run(3.0);
  EXPECT_EQ(fixture.states.size(), before);
}

}  // namespace
}  // namespace cosiva::virtual_side
