// Virtual bodies, the vehicle's reports of detected obstacles and of its boards, and edits of the zone.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/onboard/onboard_fixture.h"

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;
using test::at;
using test::lacet4;
using test::OnboardFixture;
using test::order;
using ::testing::AllOf;
using ::testing::Contains;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

const wire::VehicleId me{"CoSiVA", "AIV1"};
constexpr double radius_m = 0.06;
constexpr double front_m = 0.10;

/// Drives along the loop in the south-east, at medium speed, with a server that sends heartbeats.
struct Driving : OnboardFixture {
  Driving() {
    server_heartbeats = true;
    run(0.5);
    order(test::order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@2545"}));
    run(1.0);
    EXPECT_GT(speed_mps, 0.39);
  }
  static Point2 on_loop(double s_m) { return position(lacet4().circuit.pose_at(at(lacet4(), "loop_se", s_m))); }
  static wire::Body person(double s_m, std::string id = "P1") {
    const Point2 p = on_loop(s_m);
    return {std::move(id), "person", p.x_m, p.y_m, 0.0, 0.0, radius_m, 0.0, 0.0};
  }
  [[nodiscard]] double s_m() const { return ground_truth.track_position(lacet4().circuit).s_m; }

  void receive_virtual_obstacles(std::vector<wire::Body> bodies) {
    receive(wire::own_topic(wire::virtual_obstacles_topic_prefix, me),
            to_json(wire::VirtualObstacles{++aheads, now, "lacet4", std::move(bodies)}));
  }
  /// As a server does: ten times a second, for `seconds`.
  void run_with(const std::vector<wire::Body>& bodies, double seconds) {
    for (int i = 0; i < static_cast<int>(seconds * 10.0); ++i) {
      receive_virtual_obstacles(bodies);
      run(0.1);
    }
  }
  std::vector<std::string> warnings() const {
    std::vector<std::string> texts;
    for (const wire::Log& line : logs) {
      if (line.level == 'w') texts.push_back(line.text);
    }
    return texts;
  }
  std::uint32_t aheads{0};
};

// --- virtual obstacles and their acknowledgement ------------------------------------------------------------------

TEST(Perception, the_first_virtual_obstacles_are_acknowledged_even_when_empty) {
  Driving fixture;
  fixture.receive_virtual_obstacles({});
  ASSERT_THAT(fixture.felts, SizeIs(1));
  EXPECT_EQ(fixture.felts[0], (wire::VirtualObstaclesAck{1, fixture.now, false, "", std::nullopt}));
  for (int i = 0; i < 30; ++i) {
    fixture.receive_virtual_obstacles({});
    fixture.run(0.1);
  }
  EXPECT_THAT(fixture.felts, SizeIs(3)) << "nothing changed: once a second, since one may be lost";
}

TEST(Perception, a_body_on_the_path_causes_a_decision_at_once) {
  Driving fixture;
  fixture.receive_virtual_obstacles({});
  const int drives = fixture.drives;
  fixture.receive_virtual_obstacles({Driving::person(fixture.s_m() + 0.4)});
  EXPECT_EQ(fixture.drives, drives + 1) << "the motors received a command at once";
  ASSERT_THAT(fixture.felts, SizeIs(2));
  EXPECT_EQ(fixture.felts[1].virtual_obstacles_header_id, 2U);
  EXPECT_EQ(fixture.felts[1].decided, fixture.now);
  EXPECT_TRUE(fixture.felts[1].braking);
  EXPECT_EQ(fixture.felts[1].body, "P1");
  ASSERT_TRUE(fixture.felts[1].distance_m);
  EXPECT_NEAR(*fixture.felts[1].distance_m, 0.4 - radius_m - front_m, 0.03);
}

TEST(Perception, stops_the_vehicle_before_a_person_until_the_person_is_removed) {
  Driving fixture;
  const double person_s_m = fixture.s_m() + 0.5;
  fixture.run_with({Driving::person(person_s_m)}, 3.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  EXPECT_NEAR(person_s_m - fixture.s_m() - radius_m - front_m, clearance_m, 0.03);
  EXPECT_TRUE(fixture.state().field_violation);
  EXPECT_FALSE(fixture.state().driving);
  EXPECT_THAT(fixture.state().errors, IsEmpty()) << "an obstacle is no fault";
  fixture.receive_virtual_obstacles({});
  EXPECT_FALSE(fixture.felts.back().braking);
  EXPECT_EQ(fixture.felts.back().body, "");
  fixture.run(1.0);
  EXPECT_GT(fixture.speed_mps, 0.39);
  EXPECT_FALSE(fixture.state().field_violation);
}

TEST(Perception, a_distant_body_is_perceived_without_braking_until_it_is_near) {
  Driving fixture;
  const std::vector<wire::Body> bodies{Driving::person(fixture.s_m() + 1.2)};
  fixture.receive_virtual_obstacles(bodies);
  ASSERT_THAT(fixture.felts, SizeIs(1));
  EXPECT_FALSE(fixture.felts[0].braking);
  fixture.run_with(bodies, 4.0);
  int changes = 0;
  for (std::size_t i = 1; i < fixture.felts.size(); ++i)
    changes += fixture.felts[i].braking != fixture.felts[i - 1].braking;
  EXPECT_EQ(changes, 1);
  EXPECT_TRUE(fixture.felts.back().braking);
  EXPECT_EQ(fixture.felts.back().body, "P1");
  EXPECT_EQ(fixture.speed_mps, 0.0);
}

TEST(Perception, an_added_or_removed_body_is_acknowledged_without_braking) {
  Driving fixture;
  const wire::Body far = Driving::person(fixture.s_m() + 1.2);
  fixture.receive_virtual_obstacles({});
  fixture.receive_virtual_obstacles({far});
  fixture.receive_virtual_obstacles({far});
  ASSERT_THAT(fixture.felts, SizeIs(2));
  fixture.receive_virtual_obstacles({Driving::person(fixture.s_m() + 1.25, "P2"), far});
  fixture.receive_virtual_obstacles({far, Driving::person(fixture.s_m() + 1.25, "P2")});
  ASSERT_THAT(fixture.felts, SizeIs(3)) << "their order is not a change";
  fixture.receive_virtual_obstacles({});
  ASSERT_THAT(fixture.felts, SizeIs(4));
  EXPECT_EQ(fixture.felts.back().virtual_obstacles_header_id, 6U);
}

TEST(Perception, is_acknowledged_again_when_the_broker_is_back) {
  Driving fixture;
  fixture.receive_virtual_obstacles({});
  fixture.link(false);
  fixture.link(true);
  fixture.receive_virtual_obstacles({});
  EXPECT_THAT(fixture.felts, SizeIs(2));
}

TEST(Perception, another_body_in_front_of_the_first_is_acknowledged) {
  Driving fixture;
  const double there_m = fixture.s_m() + 0.6;
  fixture.run_with({Driving::person(there_m)}, 3.0);
  fixture.receive_virtual_obstacles({Driving::person(there_m), Driving::person(there_m - 0.1, "P2")});
  EXPECT_EQ(fixture.felts.back().body, "P2");
  EXPECT_EQ(fixture.felts.back().virtual_obstacles_header_id, fixture.aheads);
}

TEST(Perception, a_person_walking_across_causes_one_stop_and_one_start) {
  Driving fixture;
  const Pose2 X_MP = lacet4().circuit.pose_at(at(lacet4(), "loop_se", fixture.s_m() + 0.8));
  int stops = 0;
  bool was_stopped = false;
  for (int i = 0; i < 500; ++i) {  // from 0.4 m right of the path to 0.8 m left of it, at 0.24 m/s
    if (i % 10 == 0) {
      const Point2 p = X_MP * Point2{0.0, -0.4 + 0.0024 * i};
      const Point2 ahead = X_MP * Point2{0.0, 1.0};
      const double vx = 0.24 * (ahead.x_m - X_MP.x_m);
      const double vy = 0.24 * (ahead.y_m - X_MP.y_m);
      fixture.receive_virtual_obstacles({{"P1", "person", p.x_m, p.y_m, 0.0, 0.0, radius_m, vx, vy}});
    }
    fixture.step();
    stops += !was_stopped && fixture.speed_mps == 0.0 ? 1 : 0;
    was_stopped = fixture.speed_mps == 0.0;
  }
  EXPECT_EQ(stops, 1);
  EXPECT_GT(fixture.speed_mps, 0.0);
  EXPECT_THAT(fixture.felts, Contains(Field(&wire::VirtualObstaclesAck::braking, true)));
  EXPECT_FALSE(fixture.felts.back().braking);
}

TEST(Perception, expires_after_a_second_without_messages_and_this_is_acknowledged) {
  Driving fixture;
  fixture.run_with({Driving::person(fixture.s_m() + 0.5)}, 3.0);
  fixture.run(0.8);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  fixture.run(1.0);
  EXPECT_GT(fixture.speed_mps, 0.0);
  EXPECT_FALSE(fixture.felts.back().braking);
  const std::size_t before = fixture.felts.size();
  fixture.receive_virtual_obstacles({});
  EXPECT_THAT(fixture.felts, SizeIs(before + 1)) << "the first message after that is acknowledged";
}

TEST(Perception, ends_when_the_server_leaves_a_vehicle_without_an_order) {
  Driving fixture;
  fixture.run_with({Driving::person(fixture.s_m() + 0.5)}, 3.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  fixture.server_heartbeats = false;
  fixture.receive(wire::server_connection_topic, R"({"connectionState":"OFFLINE","timestamp":"2026-01-01T00:00:00Z"})");
  fixture.run(1.5);
  EXPECT_EQ(fixture.speed_mps, 0.0) << "it has an order of that server";
  fixture.act("cancelOrder", "c");
  fixture.run(0.1);
  fixture.order(test::order("M-1").through({"loop_se@283", "loop_se@565", "loop_se@2545"}));
  fixture.run(0.5);
  EXPECT_GT(fixture.speed_mps, 0.0);
}

TEST(Perception, outlasts_a_restart_of_the_server) {
  Driving fixture;
  fixture.run_with({Driving::person(fixture.s_m() + 0.5)}, 3.0);
  fixture.server_heartbeats = false;
  fixture.run(5.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  fixture.server_heartbeats = true;
  fixture.run(0.9);
  EXPECT_EQ(fixture.speed_mps, 0.0) << "the new server had no time yet to publish its bodies";
  fixture.aheads = 0;
  fixture.receive_virtual_obstacles({Driving::person(fixture.s_m() + 0.3)});
  EXPECT_EQ(fixture.felts.back().virtual_obstacles_header_id, 1U) << "a new server receives an acknowledgement";
}

TEST(Perception, malformed_virtual_obstacles_are_refused_with_one_line_per_kind_and_change_nothing) {
  Driving fixture;
  const std::string topic = wire::own_topic(wire::virtual_obstacles_topic_prefix, me);
  const std::vector<wire::Body> bodies{Driving::person(fixture.s_m() + 0.5)};
  fixture.run_with(bodies, 3.0);
  const std::string good = to_json(wire::VirtualObstacles{99, fixture.now, "lacet4", {}});
  for (int i = 0; i < 5; ++i) {
    for (const std::string& text :
         {std::string(), std::string("{"), good.substr(0, good.size() - 1), std::string(R"({"headerId":1})"),
          std::string(40000, ' ') + good, to_json(wire::VirtualObstacles{99, fixture.now, "elsewhere", {}})})
      fixture.receive(topic, text);
    fixture.receive_virtual_obstacles(bodies);
    fixture.run(0.1);
  }
  EXPECT_EQ(fixture.speed_mps, 0.0);
  for (auto perceived = fixture.felts.rbegin();
       perceived != fixture.felts.rend() && perceived->virtual_obstacles_header_id > 30; ++perceived)
    EXPECT_EQ(perceived->body, "P1");
  const auto warnings = fixture.warnings();
  EXPECT_THAT(warnings, SizeIs(3)) << "not JSON, a field, another map";
  for (const std::string& text : warnings) EXPECT_THAT(text, HasSubstr("virtual obstacles not used"));
}

TEST(Perception, logs_at_most_sixteen_kinds_of_fault) {
  Driving fixture;
  for (int i = 0; i < 32; ++i) {
    wire::VirtualObstacles ahead{1, fixture.now, "lacet4", std::vector<wire::Body>(32, Driving::person(0.5))};
    ahead.bodies[static_cast<std::size_t>(i)].radius_m = -1.0;
    fixture.receive(wire::own_topic(wire::virtual_obstacles_topic_prefix, me), to_json(ahead));
  }
  EXPECT_THAT(fixture.warnings(), SizeIs(16));
}

TEST(Perception, ignores_retained_messages_and_messages_for_other_vehicles) {
  Driving fixture;
  const std::string text =
      to_json(wire::VirtualObstacles{1, fixture.now, "lacet4", {Driving::person(fixture.s_m() + 0.4)}});
  fixture.receive(wire::own_topic(wire::virtual_obstacles_topic_prefix, me), text, true);
  fixture.receive(wire::own_topic(wire::virtual_obstacles_topic_prefix, {"CoSiVA", "AIV2"}), text);
  fixture.run(0.2);
  EXPECT_THAT(fixture.felts, IsEmpty());
  EXPECT_GT(fixture.speed_mps, 0.39);
}

TEST(Perception, before_a_zone_or_a_position_is_known_is_harmless) {
  OnboardFixture::Setup setup;
  setup.zone_notified = false;
  OnboardFixture no_zone{setup};
  const std::string text = to_json(wire::VirtualObstacles{1, no_zone.now, "lacet4", {Driving::person(0.4)}});
  no_zone.receive(wire::own_topic(wire::virtual_obstacles_topic_prefix, me), text);
  no_zone.run(0.2);
  EXPECT_THAT(no_zone.felts, IsEmpty());
  setup.zone_notified = true;
  setup.start.reset();
  OnboardFixture no_position{setup};
  no_position.receive(wire::own_topic(wire::virtual_obstacles_topic_prefix, me), text);
  no_position.run(0.2);
  ASSERT_THAT(no_position.felts, SizeIs(1));
  EXPECT_FALSE(no_position.felts[0].braking);
}

// --- detected obstacles ---------------------------------------------------------------------------------------------

TEST(Seeing, reports_the_location_of_the_obstacle_on_its_path) {
  Driving fixture;
  const Point2 p = Driving::on_loop(fixture.s_m() + 0.7);
  fixture.obstacles = {p};
  fixture.run(3.0);
  EXPECT_EQ(fixture.speed_mps, 0.0);
  ASSERT_FALSE(fixture.sightings.empty());
  const wire::DetectedObstacleReport& detected = fixture.sightings.back();
  ASSERT_TRUE(detected.obstacle);
  EXPECT_EQ(detected.map_id, "lacet4");
  EXPECT_LT(distance({detected.obstacle->x_m, detected.obstacle->y_m}, p), 0.04);
  EXPECT_NEAR(detected.obstacle->distance_m, clearance_m, 0.04);
  EXPECT_EQ(detected.clear_m, detected.obstacle->distance_m);
  const std::size_t before = fixture.sightings.size();
  fixture.run(2.0);
  EXPECT_GE(fixture.sightings.size() - before, 15U) << "the stopped vehicle continues to report";
}

TEST(Seeing, reports_the_end_of_a_detection_three_times_and_then_nothing) {
  Driving fixture;
  EXPECT_THAT(fixture.sightings, IsEmpty());
  fixture.obstacles = {Driving::on_loop(fixture.s_m() + 0.7)};
  fixture.run(1.0);
  fixture.obstacles.clear();
  fixture.run(2.0);
  ASSERT_GE(fixture.sightings.size(), 3U);
  int without = 0;
  for (const wire::DetectedObstacleReport& detected : fixture.sightings) without += detected.obstacle ? 0 : 1;
  EXPECT_EQ(without, 3);
  EXPECT_NEAR(fixture.sightings.back().clear_m, 1.2, 1e-9);
}

TEST(Seeing, does_not_report_the_neighbouring_lane) {
  Driving fixture;
  const Pose2 X_MP = lacet4().circuit.pose_at(at(lacet4(), "loop_se", fixture.s_m() + 0.6));
  fixture.obstacles = {X_MP * Point2{0.0, 0.3}, X_MP * Point2{0.0, -0.3}};
  fixture.run(0.5);
  EXPECT_THAT(fixture.sightings, IsEmpty());
}

// --- boards ---------------------------------------------------------------------------------------------------------

TEST(BoardsReport, is_published_twice_a_second_with_every_board) {
  OnboardFixture fixture;
  fixture.run(3.0);
  EXPECT_GE(fixture.boards_reports.size(), 6U);
  EXPECT_LE(fixture.boards_reports.size(), 7U);
  const wire::BoardsReport& report = fixture.boards_reports.back();
  ASSERT_THAT(report.boards, SizeIs(4));
  for (const auto& line : report.boards) {
    EXPECT_EQ(line.health, "ok") << to_string(line.board);
    EXPECT_EQ(line.firmware_hash, 0xF00DU);
    EXPECT_EQ(line.frames_bad, 0U);
  }
  // PILS: 50 odometries and 10 heartbeats a second.
  EXPECT_NEAR(static_cast<double>(report.boards[0].frames), 60.0 * to_seconds(report.timestamp - virtual_epoch), 5.0);
  ASSERT_TRUE(report.power);
  EXPECT_EQ(report.power->voltage_mv, 7400);
  ASSERT_TRUE(report.ranges);
  EXPECT_THAT(report.ranges->range_mm, SizeIs(13));
  EXPECT_EQ(report.header_id + 1, fixture.boards_reports.size());
}

TEST(BoardsReport, counts_damage_on_both_sides_and_names_lost_and_faulty_boards) {
  OnboardFixture fixture;
  fixture.run(1.0);
  fixture.feed(wire::InputKind::bytes, wire::port_name(1, wire::Board::PILS), std::string("\x01garbage\x00", 9));
  fixture.send_from_board(wire::Board::PILS, wire::Heartbeat{4711, 3, 2, 0});
  fixture.silence(wire::Board::PRAV);
  fixture.self_test[wire::Board::DOBS] = 7;
  // Its next heartbeat would report no damage: its last report counts.
  fixture.silence(wire::Board::PILS);
  fixture.run(1.0);
  const auto& lines = fixture.boards_reports.back().boards;
  EXPECT_EQ(lines[0].frames_bad, 4U);
  EXPECT_GE(lines[0].frames_missed, 2U);
  EXPECT_EQ(lines[0].uptime_ms, 4711U);
  EXPECT_EQ(lines[0].health, "lost");
  EXPECT_EQ(lines[1].health, "lost");
  EXPECT_EQ(lines[2].health, "faulty");
  EXPECT_EQ(lines[2].self_test, 7);
  EXPECT_EQ(lines[3].health, "ok");
}

TEST(BoardsReport, continues_without_a_zone_and_stops_without_a_broker) {
  OnboardFixture::Setup setup;
  setup.zone_notified = false;
  OnboardFixture fixture{setup};
  fixture.run(1.0);
  EXPECT_FALSE(fixture.boards_reports.empty());
  fixture.link(false);
  const std::size_t before = fixture.boards_reports.size();
  fixture.run(2.0);
  EXPECT_EQ(fixture.boards_reports.size(), before);
}

// --- edits of the zone ----------------------------------------------------------------------------------------------

std::string edited(std::string_view from, std::string_view to) {
  std::string text = test::lacet4_configuration().text;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(ZoneEdit, a_moved_tag_rectifies_at_its_new_position_while_the_vehicle_drives) {
  Driving fixture;
  // Tag 2 is located 1.4137 m along the loop; from now on its configured position is 0.05 m earlier.
  fixture.receive("cosiva/v1/zone/toml", edited("s_m = 1.4137", "s_m = 1.3637"), true);
  EXPECT_THAT(fixture.warnings(), IsEmpty());
  EXPECT_GT(fixture.speed_mps, 0.39) << "an edit does not stop the vehicle";
  fixture.run_until([&] { return fixture.s_m() >= 1.3637; }, 5.0);
  fixture.send_from_board(wire::Board::PRAV, wire::TagRead{0, 2, 0});
  const auto estimated = fixture.core->estimated_pose();
  ASSERT_TRUE(estimated);
  // Read at the field's rim, 20 mm before the tag, and 20 ms ago.
  const double expected_m = 1.3637 - 0.020 + 0.4 * 0.020;
  EXPECT_LT(distance(position(*estimated), Driving::on_loop(expected_m)), 0.006);
  fixture.run(0.2);
  EXPECT_EQ(fixture.state().order_id, "O-1");
  EXPECT_GT(fixture.speed_mps, 0.39);
}

TEST(ZoneEdit, makes_another_version_of_the_zone_until_it_is_undone) {
  Driving fixture;
  const auto reported_after = [&](const std::string& text) {
    fixture.receive("cosiva/v1/zone/toml", text, true);
    fixture.run(0.5);
    return fixture.state().maps.at(0).map_version;
  };
  const std::string with_moved_tag = edited("s_m = 1.4137", "s_m = 1.3637");
  EXPECT_EQ(reported_after(with_moved_tag), zone::version_of({"toml", "", with_moved_tag}));
  const std::string original = test::lacet4_configuration().text;
  EXPECT_EQ(reported_after(original), zone::version_of({"toml", "", original}));
}

TEST(ZoneEdit, another_beacon_pitch_is_in_force_at_once) {
  // Northwards at x = 0.15 the path meets beacons of the old grid at y = 0.15 + 0.30 n; of the new one at 0.15 + 0.25
  // n.
  const auto corrected = [](bool edit) {
    OnboardFixture::Setup setup;
    setup.start = OnboardOptions::Start{"north", 0.50};
    setup.ground_truth = at(lacet4(), "north", 0.50);
    OnboardFixture fixture{setup};
    fixture.run(0.3);
    if (edit) fixture.receive("cosiva/v1/zone/toml", edited("pitch_m = 0.30", "pitch_m = 0.25"), true);
    auto rtm =
        zone::Rtm::initialise({"toml", "", edited("pitch_m = 0.30", edit ? "pitch_m = 0.25" : "pitch_m = 0.30")});
    const Point2 here = position(lacet4().circuit.pose_at(at(lacet4(), "north", 0.55)));
    const auto beacon = rtm->zone().beacons->nearest(here);
    fixture.send_from_board(wire::Board::PRAV, wire::TagRead{0, beacon->number, 0});
    // The rim of the field, 20 mm before the beacon.
    const double rim_m = rtm->zone().circuit.locate(beacon->position, pi / 2).position.s_m - 0.020;
    return distance(position(*fixture.core->estimated_pose()),
                    position(lacet4().circuit.pose_at(at(lacet4(), "north", rim_m))));
  };
  EXPECT_LT(corrected(false), 0.005);
  EXPECT_LT(corrected(true), 0.005);
}

TEST(ZoneEdit, an_invalid_zone_is_refused_and_does_not_stop_the_vehicle) {
  Driving fixture;
  fixture.receive("cosiva/v1/zone/toml", "this is no zone", true);
  fixture.receive("cosiva/v1/zone/toml", "", true);
  const auto warnings = fixture.warnings();
  ASSERT_THAT(warnings, SizeIs(1)) << "a cleared topic has no effect";
  EXPECT_THAT(warnings[0], HasSubstr("not used"));
  fixture.run(0.3);
  EXPECT_GT(fixture.speed_mps, 0.39);
  fixture.receive("cosiva/v1/zone/toml", test::lacet4_configuration().text, true);
  EXPECT_THAT(fixture.warnings(), SizeIs(1)) << "the zone in force again is not a change";
}

}  // namespace
}  // namespace cosiva::aiv
