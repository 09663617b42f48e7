// The reports of CoSiVA vehicles beyond VDA 5050: detected obstacles and the state of the boards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class DetectionFixture : public testing::Test {
 protected:
  DetectionFixture() {
    aiv.blocked = true;
    fixture.run_for(1s);
  }
  void see(const FixtureVehicle& vehicle, std::optional<wire::DetectedObstacleReport::Obstacle> obstacle,
           double clear_m = 0.8) {
    wire::DetectedObstacleReport detected{0, fixture.now - 20ms, "oval", obstacle, clear_m};
    publish(vehicle, wire::to_json(detected));
  }
  void publish(const FixtureVehicle& vehicle, std::string payload, bool retained = false) {
    fixture.feed(wire::InputKind::message, "cosiva/v1/detected_obstacle/" + wire::to_string(vehicle.id),
                 std::move(payload), retained);
  }
  [[nodiscard]] JsonValue::Array obstacles() const { return *fixture.snapshot().find("obstacles")->array(); }
  [[nodiscard]] JsonValue shown() const { return *fixture.bijection().find("effects")->find("shown_ms"); }

  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
};

TEST_F(DetectionFixture, an_obstacle_appears_with_its_observer_and_the_latency) {
  see(aiv, wire::DetectedObstacleReport::Obstacle{1.2, 0.0, 0.05, 0.6});
  ASSERT_THAT(obstacles(), SizeIs(1));
  const JsonValue one = obstacles()[0];
  EXPECT_EQ(one.text("id"), "S1");
  EXPECT_EQ(*one.number("x"), 1.2);
  EXPECT_EQ(*one.number("radius"), 0.05);
  EXPECT_EQ(*one.number("handle"), 49152.0);
  EXPECT_EQ(*one.find("detectedBy")->array()->front().text(), "CoSiVA/AIV1");
  EXPECT_EQ(*shown().number("count"), 1.0);
  EXPECT_NEAR(*shown().number("max"), 20.0, 1.0);
  see(aiv, wire::DetectedObstacleReport::Obstacle{1.21, 0.0, 0.05, 0.6});
  EXPECT_THAT(obstacles(), SizeIs(1));
  EXPECT_EQ(*shown().number("count"), 1.0) << "a repeated detection is not counted again";
}

TEST_F(DetectionFixture, another_vehicle_is_no_obstacle) {
  fixture.add("AIV2", {0, 1.2}).blocked = true;
  fixture.run_for(1s);
  see(aiv, wire::DetectedObstacleReport::Obstacle{1.1, 0.02, 0.05, 0.5});  // its rear end
  EXPECT_THAT(obstacles(), IsEmpty());
  see(aiv, wire::DetectedObstacleReport::Obstacle{0.96, 0.0, 0.05,
                                                  0.36});  // 0.14 m behind the rear end: radius of 5 cm, error of 10 cm
  EXPECT_THAT(obstacles(), IsEmpty());
  see(aiv, wire::DetectedObstacleReport::Obstacle{0.93, 0.0, 0.05, 0.33});  // 0.17 m behind the rear end
  EXPECT_THAT(obstacles(), SizeIs(1));
}

TEST_F(DetectionFixture, another_vehicle_is_no_obstacle_at_its_position_at_detection_time) {
  FixtureVehicle& other = fixture.add("AIV2", {0, 0.9});
  other.cruise_mps = 0.5;
  fixture.run_for(1s);
  const auto at_then = fixture.now;
  const double tail_then_m = other.pose().x_m - 0.10;
  // The report arrives half a second late, over a bad radio link: by then the vehicle has driven further than the
  // errors of two positions.
  fixture.run_for(500ms);
  ASSERT_GT(other.pose().x_m - 0.10 - tail_then_m, 0.22);
  const wire::DetectedObstacleReport::Obstacle obstacle{tail_then_m, 0.0, 0.05, 0.3};
  publish(aiv, wire::to_json(wire::DetectedObstacleReport{0, at_then, "oval", obstacle, 0.3}));
  EXPECT_THAT(obstacles(), IsEmpty());
  publish(aiv, wire::to_json(wire::DetectedObstacleReport{1, fixture.now, "oval", obstacle, 0.3}));
  EXPECT_THAT(obstacles(), SizeIs(1)) << "an obstacle detected now at the previous position is not that vehicle";
}

TEST_F(DetectionFixture, an_obstacle_disappears_when_its_observer_detects_a_free_position) {
  see(aiv, wire::DetectedObstacleReport::Obstacle{1.0, 0.0, 0.05, 0.4});
  see(aiv, std::nullopt, 0.2);
  EXPECT_THAT(obstacles(), SizeIs(1)) << "it is beyond the clear distance";
  FixtureVehicle& other = fixture.add("AIV2", {0, 0.1});
  other.blocked = true;
  fixture.run_for(1s);
  see(other, std::nullopt, 1.0);
  EXPECT_THAT(obstacles(), SizeIs(1)) << "a vehicle that never detected it may be unable to detect it now";
  see(aiv, std::nullopt, 0.8);
  EXPECT_THAT(obstacles(), IsEmpty());
}

TEST_F(DetectionFixture, an_obstacle_disappears_when_a_vehicle_drives_over_its_position) {
  see(aiv, wire::DetectedObstacleReport::Obstacle{1.0, 0.0, 0.05, 0.4});
  aiv.blocked = false;
  fixture.run_for(1s);
  EXPECT_THAT(obstacles(), SizeIs(1));
  fixture.run_for(2s);
  EXPECT_THAT(obstacles(), IsEmpty());
}

TEST_F(DetectionFixture, virtual_aivs_perceive_an_obstacle_of_a_physical_one_and_do_not_remove_it) {
  see(aiv, wire::DetectedObstacleReport::Obstacle{1.5, 1.0, 0.05,
                                                  0.6});  // on the other side; as if the sensor had that range
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"east","s":1.2}})");
  fixture.run_for(6s);
  EXPECT_THAT(obstacles(), SizeIs(1));
  EXPECT_EQ(*fixture.aiv("CoSiVA.virtual/V1").number("speed"), 0.0);
  EXPECT_GT(*fixture.aiv("CoSiVA.virtual/V1").number("x"), 1.6);
}

TEST_F(DetectionFixture, reports_that_are_late_malformed_or_of_another_map_are_ignored) {
  wire::DetectedObstacleReport elsewhere{0, fixture.now, "moon",
                                         wire::DetectedObstacleReport::Obstacle{1.0, 0.0, 0.05, 0.4}, 0.4};
  publish(aiv, wire::to_json(elsewhere));
  EXPECT_THAT(obstacles(), IsEmpty());
  wire::DetectedObstacleReport late{0, fixture.now - 1s, "oval",
                                    wire::DetectedObstacleReport::Obstacle{1.0, 0.0, 0.05, 0.4}, 0.4};
  publish(aiv, wire::to_json(late));
  EXPECT_THAT(obstacles(), IsEmpty());
  fixture.logs.clear();
  publish(aiv, "{}");
  publish(aiv, "rubbish");
  publish(aiv, std::string(20'000, ' '));
  EXPECT_THAT(fixture.logs, SizeIs(1)) << "logged once; further ones are counted";
  wire::DetectedObstacleReport retained{0, fixture.now, "oval",
                                        wire::DetectedObstacleReport::Obstacle{1.0, 0.0, 0.05, 0.4}, 0.4};
  publish(aiv, wire::to_json(retained), true);
  EXPECT_THAT(obstacles(), IsEmpty());
  const JsonValue summary = *JsonValue::parse(fixture.server->summary_json());
  EXPECT_EQ(*summary.find("aivs")->array()->front().number("refused"), 4.0);
  EXPECT_EQ(*summary.find("aivs")->array()->front().number("outdated"), 2.0);
}

TEST_F(DetectionFixture, a_report_of_an_unknown_vehicle_is_ignored) {
  fixture.feed(wire::InputKind::message, "cosiva/v1/detected_obstacle/Nobody/X1",
               wire::to_json(wire::DetectedObstacleReport{
                   0, fixture.now, "oval", wire::DetectedObstacleReport::Obstacle{1.0, 0.0, 0.05, 0.4}, 0.4}));
  EXPECT_THAT(obstacles(), IsEmpty());
  EXPECT_THAT(*fixture.snapshot().find("aivs")->array(), SizeIs(1));
}

TEST_F(DetectionFixture, obstacles_are_removed_with_their_zone) {
  see(aiv, wire::DetectedObstacleReport::Obstacle{1.2, 0.0, 0.05, 0.6});
  std::string other = oval().text;
  other.replace(other.find("length_m = 2.0"), 14, "length_m = 2.0 ");
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", other);
  EXPECT_THAT(obstacles(), SizeIs(1)) << "the same geometry, formatted differently";
  other.replace(other.find("\"oval\""), 6, "\"oval two\"");
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", other);
  fixture.run_for(100ms);
}

TEST_F(DetectionFixture, boards_power_and_ranges_are_in_the_snapshot_and_traced_when_health_changes) {
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("boards"), nullptr) << "absent where the vehicle does not report";
  wire::BoardsReport report{1, fixture.now, {{wire::Board::PILS, "ok", 0x1a2b3cU, 1200, 61'000, 1, 2, 0}}, {}, {}};
  report.power = wire::Power{12'100, 400, 240, 870};
  report.ranges = wire::Ranges{0, -50, 10, {400, wire::no_echo}};
  const auto publish_boards = [&] {
    fixture.feed(wire::InputKind::message, "cosiva/v1/boards/CoSiVA/AIV1", wire::to_json(report));
    fixture.now += 500ms;
    ++report.header_id;
    report.timestamp = fixture.now;
  };
  publish_boards();
  const JsonValue shown = fixture.aiv("CoSiVA/AIV1");
  const JsonValue& board = shown.find("boards")->array()->front();
  EXPECT_EQ(board.text("board"), "PILS");
  EXPECT_EQ(board.text("health"), "ok");
  EXPECT_EQ(board.text("firmware"), "001a2b3c");
  EXPECT_EQ(*board.number("frames"), 61'000.0);
  EXPECT_EQ(*board.number("framesBad"), 1.0);
  EXPECT_EQ(*board.number("framesMissed"), 2.0);
  EXPECT_DOUBLE_EQ(*shown.find("power")->number("voltage_v"), 12.1);
  EXPECT_DOUBLE_EQ(*shown.find("power")->number("temperature_c"), 24.0);
  EXPECT_DOUBLE_EQ(*shown.find("ranges")->number("first"), -0.5);
  EXPECT_DOUBLE_EQ(*(*shown.find("ranges")->find("m")->array())[0].number(), 0.4);
  EXPECT_TRUE((*shown.find("ranges")->find("m")->array())[1].is_null());
  publish_boards();
  report.boards[0].health = "lost";
  publish_boards();
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(1, 2000));
  std::vector<std::string> published;
  for (const JsonValue& trace : *traces.find("traces")->array())
    if (trace.text("kind") == "boards") published.push_back(*trace.text("content"));
  EXPECT_THAT(published, testing::ElementsAre("PILS ok", "PILS lost"));
}

TEST_F(DetectionFixture, an_obstacle_disappears_when_ranges_extend_beyond_its_position) {
  see(aiv, wire::DetectedObstacleReport::Obstacle{1.2, 0.0, 0.05, 0.6});
  const auto detect = [&](std::uint16_t mm) {
    wire::BoardsReport report{1, fixture.now, {}, {}, wire::Ranges{0, -84, 14, std::vector<std::uint16_t>(13, mm)}};
    fixture.feed(wire::InputKind::message, "cosiva/v1/boards/CoSiVA/AIV1", wire::to_json(report));
    fixture.now += 500ms;
  };
  for (int i = 0; i < 3; ++i) detect(550);  // from its front, at 0.6, to the near side of the obstacle
  EXPECT_THAT(obstacles(), SizeIs(1));
  for (int i = 0; i < 3; ++i) detect(wire::no_echo);
  EXPECT_THAT(obstacles(), IsEmpty());
}

TEST_F(DetectionFixture, the_reserved_path_reaches_from_the_twin_to_the_end_of_the_base) {
  aiv.blocked = false;
  fixture.run_for(3s);
  const JsonValue shown = fixture.aiv("CoSiVA/AIV1");
  const JsonValue::Array& path = *shown.find("reserved")->array();
  ASSERT_GE(path.size(), 5U);
  EXPECT_NEAR(*(*path.front().array())[0].number(), *shown.number("x"), 1e-4);
  for (std::size_t i = 1; i < path.size(); ++i) {
    const double step_m = norm(*(*path[i].array())[0].number() - *(*path[i - 1].array())[0].number(),
                               *(*path[i].array())[1].number() - *(*path[i - 1].array())[1].number());
    EXPECT_LE(step_m, 0.101);
  }
}

/// An obstacle at this point, as the vehicle reports it.
wire::DetectedObstacleReport::Obstacle obstacle_at(double x_m, double y_m) { return {x_m, y_m, 0.05, 0.4}; }

TEST_F(DetectionFixture, an_obstacle_may_be_next_to_the_vehicle_that_detects_it) {
  see(aiv, obstacle_at(0.7, 0.0));  // 10 cm in front of it
  EXPECT_THAT(obstacles(), SizeIs(1));
}

TEST_F(DetectionFixture, another_vehicle_has_a_margin_on_each_side_and_at_its_corners) {
  fixture.add("AIV2", {0, 1.2}).blocked = true;
  fixture.run_for(1s);
  // Half the width of 0.12 m, the margin of 0.10 m and the radius of 0.05 m: 0.21 m to the side.
  see(aiv, obstacle_at(1.2, 0.20));
  see(aiv, obstacle_at(1.2, -0.20));
  EXPECT_THAT(obstacles(), IsEmpty());
  see(aiv, obstacle_at(1.2, 0.22));
  EXPECT_THAT(obstacles(), SizeIs(1));
  see(aiv, obstacle_at(1.42, -0.18));  // 0.12 m beyond its front and 0.12 m beyond its side
  EXPECT_THAT(obstacles(), SizeIs(2));
}

TEST_F(DetectionFixture, another_vehicle_is_at_its_heading_at_detection_time) {
  FixtureVehicle& other = fixture.add("AIV2", {0, 0.9});
  other.cruise_mps = 0.5;
  fixture.run_for(1s);
  const auto at_then = fixture.now;
  const double x_then_m = other.pose().x_m;
  fixture.run_for(500ms);
  // 0.10 m behind its rear end and 0.10 m from its left side; turned by a radian it would be elsewhere.
  publish(aiv, wire::to_json(wire::DetectedObstacleReport{0, at_then, "oval", obstacle_at(x_then_m - 0.2, 0.16), 0.3}));
  EXPECT_THAT(obstacles(), IsEmpty());
}

TEST_F(DetectionFixture, a_virtual_aiv_is_no_reason_to_ignore_an_obstacle) {
  fixture.send_command(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"north","s":0.5}})");
  fixture.run_for(500ms);
  const JsonValue v1 = fixture.aiv("CoSiVA.virtual/V1");
  see(aiv, obstacle_at(*v1.number("x"), *v1.number("y")));
  EXPECT_THAT(obstacles(), SizeIs(1));
}

TEST_F(DetectionFixture, an_obstacle_three_metres_from_the_front_is_the_last_one_that_disappears) {
  // 0.5 m on the south side: 1.5 m to its end, 1.57 m round the east side, then the north side back from x = 2.
  see(aiv, obstacle_at(2.0, 1.0));   // 3.07 m from its centre
  see(aiv, obstacle_at(1.8, 1.0));   // 3.27 m
  see(aiv, obstacle_at(0.07, 1.0));  // 5.0 m
  ASSERT_THAT(obstacles(), SizeIs(3));
  see(aiv, std::nullopt, 10.0);
  ASSERT_THAT(obstacles(), SizeIs(2));
  EXPECT_EQ(obstacles()[0].text("id"), "S2");
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 100'000));
  const JsonValue& trace = traces.find("traces")->array()->back();
  EXPECT_EQ(trace.text("kind"), "disappear");
  EXPECT_EQ(trace.text("content"), "S1: CoSiVA/AIV1 detects no obstacle there");
}

TEST_F(DetectionFixture, an_obstacle_disappears_where_at_least_half_of_it_is_in_the_path) {
  // Half of 0.12 m and 0.05 m together: 0.085 m.
  see(aiv, obstacle_at(1.0, 0.07));
  see(aiv, obstacle_at(1.0, -0.10));
  ASSERT_THAT(obstacles(), SizeIs(2));
  see(aiv, std::nullopt, 0.8);
  ASSERT_THAT(obstacles(), SizeIs(1));
  EXPECT_EQ(obstacles()[0].number("y"), -0.10);
}

TEST_F(DetectionFixture, an_obstacle_in_front_of_a_vehicle_off_the_circuit_disappears) {
  aiv.put({1.0, 0.5, 0.0});
  fixture.run_for(1s);
  see(aiv, obstacle_at(1.4, 0.5));
  see(aiv, obstacle_at(1.4, 0.9));
  see(aiv, std::nullopt, 0.8);
  ASSERT_THAT(obstacles(), SizeIs(1));
  EXPECT_EQ(obstacles()[0].number("y"), 0.9);
}

TEST(DetectionOnABranch, follows_the_course_of_the_vehicle) {
  ServerFixture fixture{fork()};
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  aiv.blocked = true;
  fixture.send_command(R"({"command":"go","vehicle":"CoSiVA/AIV1","to":"dock"})");
  fixture.run_for(1s);
  const Pose2 dock = fixture.zone->circuit.pose_at({*fixture.zone->circuit.find("bypass3"), 0.4});
  const auto report = [&](const std::optional<wire::DetectedObstacleReport::Obstacle>& obstacle) {
    fixture.now += 100ms;
    fixture.feed(wire::InputKind::message, "cosiva/v1/detected_obstacle/CoSiVA/AIV1",
                 wire::to_json(wire::DetectedObstacleReport{0, fixture.now, "fork", obstacle, 2.0}));
    return fixture.snapshot().find("obstacles")->array()->size();
  };
  EXPECT_EQ(report(obstacle_at(dock.x_m, dock.y_m)), 1U);
  EXPECT_EQ(report(std::nullopt), 0U);
}

TEST_F(DetectionFixture, a_vehicle_without_a_position_removes_no_obstacle) {
  FixtureVehicle& lost = fixture.add("AIV2", {2, 0.5});
  lost.position_known = false;
  fixture.run_for(200ms);
  see(lost, obstacle_at(1.0, 0.0));
  ASSERT_THAT(obstacles(), SizeIs(1));
  see(lost, std::nullopt, 0.8);
  EXPECT_THAT(obstacles(), SizeIs(1));
}

/// A report of the boards, half a second after the one before.
class BoardsFixture : public DetectionFixture {
 protected:
  void send_boards(wire::BoardsReport report) {
    fixture.now += 500ms;
    report.timestamp = fixture.now;
    send_late(std::move(report));
  }
  void send_late(const wire::BoardsReport& report) {
    fixture.feed(wire::InputKind::message, "cosiva/v1/boards/CoSiVA/AIV1", wire::to_json(report));
  }
  [[nodiscard]] double outdated() const {
    const JsonValue summary = *JsonValue::parse(fixture.server->summary_json());
    return *summary.find("aivs")->array()->front().number("outdated");
  }
  const wire::BoardsReport pils{1, {}, {{wire::Board::PILS, "ok", 1, 2, 3, 4, 5, 6}}, {}, {}};
};

TEST_F(BoardsFixture, ranges_of_a_vehicle_that_has_lost_its_position_prove_nothing) {
  see(aiv, obstacle_at(1.2, 0.0));
  aiv.position_known = false;
  aiv.state_due = true;
  fixture.run_for(200ms);
  wire::BoardsReport report = pils;
  report.ranges = wire::Ranges{0, -84, 14, std::vector<std::uint16_t>(13, wire::no_echo)};
  for (int i = 0; i < 4; ++i) send_boards(report);
  EXPECT_THAT(obstacles(), SizeIs(1));
}

TEST_F(BoardsFixture, report_that_was_overtaken_is_counted_as_outdated) {
  send_boards(pils);
  EXPECT_EQ(outdated(), 0.0);
  wire::BoardsReport late = pils;
  late.timestamp = fixture.now - 1s;
  late.boards[0].health = "lost";
  send_late(late);
  EXPECT_EQ(outdated(), 1.0);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").find("boards")->array()->front().text("health"), "ok");
}

TEST_F(BoardsFixture, report_of_several_boards_is_shown_and_traced_with_each_of_them) {
  wire::BoardsReport report = pils;
  report.boards.push_back({wire::Board::DOBS, "faulty", 0xffffffffU, 20, 30, 40, 50, 60});
  send_boards(report);
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 100'000));
  EXPECT_EQ(traces.find("traces")->array()->back().text("kind"), "boards");
  EXPECT_EQ(traces.find("traces")->array()->back().text("content"), "PILS ok, DOBS faulty");
  const JsonValue shown = fixture.aiv("CoSiVA/AIV1");
  ASSERT_THAT(*shown.find("boards")->array(), SizeIs(2));
  const JsonValue& pils_shown = (*shown.find("boards")->array())[0];
  EXPECT_EQ(pils_shown.text("firmware"), "00000001");
  EXPECT_EQ(pils_shown.number("uptime_ms"), 2.0);
  EXPECT_EQ(pils_shown.number("frames"), 3.0);
  EXPECT_EQ(pils_shown.number("framesBad"), 4.0);
  EXPECT_EQ(pils_shown.number("framesMissed"), 5.0);
  EXPECT_EQ(pils_shown.number("selfTest"), 6.0);
  EXPECT_EQ((*shown.find("boards")->array())[1].text("board"), "DOBS");
  EXPECT_EQ((*shown.find("boards")->array())[1].text("firmware"), "ffffffff");
  EXPECT_EQ(shown.find("power"), nullptr);
  EXPECT_EQ(shown.find("ranges"), nullptr);
}

TEST_F(BoardsFixture, power_is_shown_and_begins_the_curve_of_the_battery) {
  send_boards(pils);
  EXPECT_FALSE(fixture.server->battery_curve_json("CoSiVA/AIV1").has_value());
  wire::BoardsReport report = pils;
  report.power = wire::Power{12'100, 400, 240, 870};
  report.ranges = wire::Ranges{0, -50, 10, {1250}};
  send_boards(report);
  ASSERT_TRUE(fixture.server->battery_curve_json("CoSiVA/AIV1").has_value());
  EXPECT_THAT(*fixture.server->battery_curve_json("CoSiVA/AIV1"), HasSubstr("12.1,24"));
  const JsonValue shown = fixture.aiv("CoSiVA/AIV1");
  EXPECT_EQ(shown.find("power")->number("current_a"), 0.4);
  EXPECT_EQ(shown.find("ranges")->number("width"), 0.1);
  EXPECT_EQ(*(*shown.find("ranges")->find("m")->array())[0].number(), 1.25);
}

/// A vehicle stopped in front of a person, P1, that only it can perceive; the test writes its acknowledgements.
class AckFixture : public DetectionFixture {
 protected:
  AckFixture() {
    fixture.send_command(R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":1.5,"y":0.5}})");
    fixture.run_for(100ms);
  }
  [[nodiscard]] std::uint32_t last_sent() const {
    const auto sent = fixture.published_on("cosiva/v1/virtual_obstacles/CoSiVA/AIV1");
    return wire::virtual_obstacles_from_json(sent.back().payload)->header_id;
  }
  void acknowledge(std::uint32_t header_id, bool braking) {
    const wire::VirtualObstaclesAck ack{header_id, fixture.now, braking, braking ? "P1" : "", {}};
    fixture.feed(wire::InputKind::message, "cosiva/v1/virtual_obstacles_ack/CoSiVA/AIV1", wire::to_json(ack));
  }
  [[nodiscard]] JsonValue shown_aiv() const { return fixture.aiv("CoSiVA/AIV1"); }
  [[nodiscard]] std::vector<std::string> perceived_by() const {
    std::vector<std::string> names;
    const JsonValue snapshot = fixture.snapshot();
    const JsonValue& person = snapshot.find("virtualObjects")->array()->front();
    for (const JsonValue& name : *person.find("perceivedBy")->array()) names.push_back(*name.text());
    return names;
  }
  [[nodiscard]] std::string last_trace() const {
    const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 100'000));
    const JsonValue& trace = traces.find("traces")->array()->back();
    return *trace.text("kind") + ": " + *trace.text("content");
  }
};

TEST_F(AckFixture, acknowledgement_shows_what_the_vehicle_brakes_for) {
  fixture.add("AIV2", {2, 0.5}).blocked = true;
  fixture.run_for(200ms);
  aiv.blocked = false;
  aiv.paused = true;
  aiv.state_due = true;
  fixture.run_for(100ms);
  const std::string id = std::to_string(last_sent());
  std::vector<PositionRecord> records;
  fixture.server->positions(fixture.now, records);
  EXPECT_FALSE(records[0].blocked);
  const ServerCore::PageRevision before = fixture.server->page_revision();
  acknowledge(last_sent(), true);
  EXPECT_NE(fixture.server->page_revision().waited_for, before.waited_for);
  EXPECT_EQ(fixture.server->page_revision().events, before.events);
  EXPECT_EQ(last_trace(), "virtual_obstacles_ack: virtual obstacles " + id + ": brakes for P1");
  EXPECT_EQ(shown_aiv().text("brakingFor"), "P1");
  EXPECT_THAT(perceived_by(), testing::ElementsAre("CoSiVA/AIV1"));
  fixture.server->positions(fixture.now, records);
  EXPECT_TRUE(records[0].blocked);
  acknowledge(last_sent(), false);
  EXPECT_EQ(last_trace(), "virtual_obstacles_ack: virtual obstacles " + id + ": nothing to brake for");
  EXPECT_TRUE(shown_aiv().find("brakingFor")->is_null());
  EXPECT_THAT(perceived_by(), IsEmpty());
}

TEST_F(AckFixture, acknowledgement_of_a_message_that_was_not_sent_is_counted_as_outdated) {
  acknowledge(last_sent() + 1, true);
  EXPECT_TRUE(shown_aiv().find("brakingFor")->is_null());
  const JsonValue summary = *JsonValue::parse(fixture.server->summary_json());
  EXPECT_EQ(summary.find("aivs")->array()->front().number("outdated"), 1.0);
}

TEST_F(AckFixture, a_new_session_of_the_vehicle_ends_what_it_perceived) {
  acknowledge(last_sent(), true);
  fixture.connection(aiv, wire::ConnectionState::connection_broken);
  EXPECT_TRUE(shown_aiv().find("brakingFor")->is_null()) << "it is lost";
  fixture.connection(aiv, wire::ConnectionState::online);
  EXPECT_TRUE(shown_aiv().find("brakingFor")->is_null());
  EXPECT_THAT(perceived_by(), IsEmpty());
}

TEST_F(DetectionFixture, detected_obstacles_have_position_records) {
  see(aiv, obstacle_at(1.2, 0.1));
  std::vector<PositionRecord> records;
  fixture.server->positions(fixture.now, records);
  ASSERT_THAT(records, SizeIs(2));
  EXPECT_EQ(records[1].handle, 49152);
  EXPECT_EQ(records[1].kind, PositionRecord::Kind::obstacle);
  EXPECT_FALSE(records[1].augmented);
  EXPECT_FALSE(records[1].blocked);
  EXPECT_EQ(records[1].x_m, 1.2F);
  EXPECT_EQ(records[1].y_m, 0.1F);
  EXPECT_EQ(records[1].heading_rad, 0.0F);
  EXPECT_EQ(records[1].speed_mps, 0.0F);
}

}  // namespace
}  // namespace cosiva::virtual_side
