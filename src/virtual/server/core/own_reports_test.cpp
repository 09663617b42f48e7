// The reports of CoSiVA vehicles beyond VDA 5050: detected obstacles and the state of the boards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

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

}  // namespace
}  // namespace cosiva::virtual_side
