#include "cosiva/physical/plant/plant_core.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/battery/type.h"
#include "cosiva/battery/type_json.h"
#include "cosiva/physical/plant/plant_fixture.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/physical/plant/test_zones.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/actual_position.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::physical {
namespace {

using ::testing::AllOf;
using ::testing::Contains;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::SizeIs;

constexpr wire::Drive fast{500, 800, 1000, 0};

TEST(Plant, moves_a_vehicle_by_the_drive_frames_it_receives) {
  PlantFixture fixture{straight(20.0)};
  fixture.drive(1, fast);
  fixture.run_for(10s);
  // v·t less half the ramp (v²/2a) and the motor's lag (v·τ).
  const double expected_m = 0.5 * 10.0 - 0.5 * 0.5 / (2.0 * 0.8) - 0.5 * 0.05;
  EXPECT_NEAR(fixture.ground_truth(1).distance_m, expected_m, 0.01);
  EXPECT_NEAR(fixture.ground_truth(1).X_MB.x_m, 0.5 + expected_m, 0.01);
  EXPECT_TRUE(fixture.ground_truth(1).powered);
  // Without noise the odometer gives it, as of its last report.
  const auto odometry = fixture.received<wire::Odometry>(1);
  EXPECT_THAT(odometry, SizeIs(AllOf(Ge(499U), Le(501U))));
  EXPECT_NEAR(static_cast<double>(odometry.back().distance_um) * 1e-6, fixture.ground_truth(1).distance_m, 0.5 * 0.021);
  EXPECT_EQ(odometry.back().speed_mmps, 500);
}

TEST(Plant, lets_no_vehicle_drive_blind_while_it_is_held_up) {
  PlantFixture fixture{straight(20.0)};
  fixture.drive(1, fast);
  fixture.run_for(3s);
  const double before_m = fixture.ground_truth(1).distance_m;
  fixture.hold_up_for(250ms);
  EXPECT_NEAR(fixture.ground_truth(1).distance_m, before_m + 0.5 * 0.05, 1e-6);
  EXPECT_TRUE(fixture.logged.empty());
  // Frames sent meanwhile are received before the vehicle drives on.
  fixture.drive(1, wire::Drive{0, 800, 1000, 0});
  fixture.run_for(2s);
  EXPECT_LT(fixture.ground_truth(1).distance_m, before_m + 0.5 * 0.05 + 0.5 * 0.5 / (2.0 * 0.8) + 0.5 * 0.1);
  EXPECT_EQ(fixture.ground_truth(1).speed_mps, 0.0);
}

TEST(Plant, stays_where_it_is_without_a_command) {
  PlantFixture fixture{straight(20.0)};
  fixture.run_for(5s);
  EXPECT_EQ(fixture.ground_truth(1).distance_m, 0.0);
  EXPECT_FALSE(fixture.ground_truth(1).powered);
}

TEST(Plant, stops_by_itself_300_ms_after_the_last_command) {
  PlantFixture fixture{straight(20.0)};
  fixture.drive(1, fast);
  fixture.run_for(3s);
  fixture.fall_unresponsive(1);
  const double before_m = fixture.ground_truth(1).distance_m;
  fixture.run_for(200ms);
  EXPECT_NEAR(fixture.ground_truth(1).speed_mps, 0.5, 1e-3);  // not yet: the last command is 250 ms old
  fixture.run_for(3s);
  EXPECT_EQ(fixture.ground_truth(1).speed_mps, 0.0);
  EXPECT_FALSE(fixture.ground_truth(1).powered);
  // The last command is 40 ms old at first; then braking at 1 m/s², behind the motor's lag.
  const double distance_m = fixture.ground_truth(1).distance_m - before_m;
  EXPECT_NEAR(distance_m, 0.5 * 0.26 + 0.5 * 0.5 / 2.0 + 0.5 * 0.05, 0.5 * 0.021);
}

TEST(Plant, stops_within_the_room_of_the_last_command_when_no_other_follows) {
  PlantFixture fixture{straight(20.0)};
  fixture.drive(1, fast);
  fixture.run_for(3s);
  wire::Drive last = fast;
  last.room_mm = 160;
  fixture.drive(1, last);
  fixture.run_for(10ms);
  const double before_m = fixture.ground_truth(1).distance_m;
  fixture.fall_unresponsive(1);
  fixture.run_for(3s);
  EXPECT_EQ(fixture.ground_truth(1).speed_mps, 0.0);
  // Silence alone would stop it after 0.28 m.
  const double distance_m = fixture.ground_truth(1).distance_m - before_m;
  EXPECT_LE(distance_m, 0.16);
  EXPECT_GE(distance_m, 0.14);
}

TEST(Plant, takes_no_command_from_damaged_frames) {
  PlantFixture fixture{straight(20.0)};
  for (int i = 0; i < 200; ++i) {
    std::string bytes = wire::module_link::encode(fast, static_cast<std::uint8_t>(i));
    bytes[5] = static_cast<char>(bytes[5] ^ 0x10);
    fixture.feed(wire::InputKind::bytes, "1/PILS", bytes);
    fixture.run_for(10ms);
  }
  EXPECT_EQ(fixture.ground_truth(1).distance_m, 0.0);
  EXPECT_EQ(fixture.received<wire::Heartbeat>(1).back().frames_bad,
            0);  // RALI's own heartbeat: it received nothing bad
  EXPECT_THAT(fixture.received<wire::Heartbeat>(1), Contains(testing::Field(&wire::Heartbeat::frames_bad, Ge(150))));
}

TEST(Plant, keeps_every_vehicle_on_its_path_over_a_lap) {
  PlantFixture fixture{lacet4(), 4, PlantNoise{}};
  const auto rtm = zone::Rtm::initialise(lacet4());
  ASSERT_TRUE(rtm);
  for (std::uint32_t i = 1; i <= 4; ++i) fixture.drive(i, fast);
  for (int i = 0; i < 370; ++i) {
    fixture.run_for(100ms);
    for (std::uint32_t v = 1; v <= 4; ++v) {
      const Pose2 pose = fixture.ground_truth(v).X_MB;
      ASSERT_LT(rtm->zone().circuit.locate(position(pose), pose.heading_rad).distance_m, 0.003);
    }
  }
  for (const auto& odometry : fixture.received<wire::Odometry>(1)) ASSERT_FALSE(odometry.line_lost);
  EXPECT_EQ(fixture.ground_truth(1).laps, 1U);
  const auto odometry = fixture.received<wire::Odometry>(2).back();
  const double off = static_cast<double>(odometry.distance_um) * 1e-6 / fixture.ground_truth(2).distance_m - 1.0;
  EXPECT_NE(off, 0.0);
  EXPECT_LT(std::fabs(off), 4.0 * (0.005 + 0.003 / std::sqrt(18.0)) + 0.01);
}

TEST(Plant, reads_the_twelve_tags_of_the_clover_and_the_beacons_it_passes) {
  PlantFixture fixture{lacet4_with_beacons_every(0.07)};
  fixture.drive(1, fast);
  fixture.run_for(36s);  // one lap and a bit
  std::map<std::uint32_t, int> read;
  for (const auto& tag : fixture.received<wire::TagRead>(1)) {
    ++read[tag.number];
    EXPECT_LE(tag.age_ms, 10);
  }
  for (std::uint32_t number = 1; number <= 12; ++number) EXPECT_GE(read[number], 1) << number;
  EXPECT_GT(read.size(), 12U);
}

TEST(Plant, reads_a_tag_where_its_field_begins_after_the_readers_latency) {
  PlantFixture fixture{straight(8.0, "0.5", "[[tag]]\nnumber = 7\nsection = \"line\"\ns_m = 4.0\n")};
  fixture.drive(1, fast);
  for (int i = 0; i < 2000 && fixture.received<wire::TagRead>(1).empty(); ++i) fixture.run_for(10ms);
  ASSERT_THAT(fixture.received<wire::TagRead>(1), SizeIs(1));
  const double sent_at_m = fixture.ground_truth(1).X_MB.x_m;
  const double read_at_m = sent_at_m - 0.5 * 1e-3 * fixture.received<wire::TagRead>(1)[0].age_ms;
  EXPECT_GE(read_at_m, 4.0 - 0.02 + 0.5 * 0.008 - 0.001);
  EXPECT_LE(read_at_m, 4.0 - 0.02 + 0.5 * 0.030 + 0.001);  // latency, and up to one tick before the field is noticed
}

TEST(Plant, ranges_the_vehicle_ahead_and_not_the_one_behind) {
  PlantNoise noise = unresponsive();
  noise.range_sd_m = 0.005;
  PlantFixture fixture{straight(8.0, "2.0 3.0"), 2, noise};
  fixture.run_for(6s);
  const auto behind = fixture.received<wire::Ranges>(1);
  ASSERT_THAT(behind, SizeIs(AllOf(Ge(99U), Le(101U))));
  double sum = 0.0;
  for (const auto& ranges : behind) {
    EXPECT_NEAR(ranges.range_mm[6], 800.0, 5.0 * 5.0 + 1.0);
    sum += ranges.range_mm[6];
  }
  EXPECT_NEAR(sum / static_cast<double>(behind.size()), 800.0, 3.0 * 5.0 / 10.0);
  for (const auto& ranges : fixture.received<wire::Ranges>(2))
    EXPECT_THAT(ranges.range_mm, testing::Each(wire::no_echo));
}

TEST(Plant, adds_and_removes_obstacles_as_commanded) {
  PlantFixture fixture{straight(8.0)};
  fixture.feed(wire::InputKind::message, std::string(wire::plant_command_topic),
               R"({"addObstacle":{"id":"box","x":1.6,"y":0.0,"radius":0.1}})");
  fixture.run_for(200ms);
  EXPECT_EQ(fixture.received<wire::Ranges>(1).back().range_mm[6], 900);
  fixture.feed(wire::InputKind::command, "test", R"({"addObstacle":{"id":"box","x":1.4,"y":0.0,"radius":0.1}})");
  fixture.run_for(200ms);
  EXPECT_EQ(fixture.received<wire::Ranges>(1).back().range_mm[6], 700);  // the same box, moved
  fixture.feed(wire::InputKind::command, "test", R"({"removeObstacle":"box"})");
  fixture.run_for(200ms);
  EXPECT_EQ(fixture.received<wire::Ranges>(1).back().range_mm[6], wire::no_echo);
  EXPECT_THAT(fixture.logged, IsEmpty());
}

TEST(Plant, refuses_bad_commands_with_a_sentence) {
  PlantFixture fixture{straight(8.0)};
  const auto refusal = [&](const std::string& command) {
    fixture.logged.clear();
    fixture.feed(wire::InputKind::command, "test", command);
    EXPECT_THAT(fixture.logged, ElementsAre(HasSubstr("plant command refused"))) << command;
    return fixture.logged.empty() ? "" : fixture.logged.front();
  };
  const auto obstacle = [](const std::string& id, const std::string& x, const std::string& y,
                           const std::string& radius) {
    return R"({"addObstacle":{"id":)" + id + R"(,"x":)" + x + R"(,"y":)" + y + R"(,"radius":)" + radius + "}}";
  };
  for (const char* bad : {"", "{", "[]", "{}", R"({"addObstacle":{}})", R"({"removeObstacle":7})"}) refusal(bad);
  EXPECT_THAT(refusal(obstacle("\"\"", "2", "0", "0.1")), HasSubstr("'id'"));
  EXPECT_THAT(refusal(obstacle("7", "2", "0", "0.1")), HasSubstr("'id'"));
  EXPECT_THAT(refusal(obstacle("\"a\"", "\"2\"", "0", "0.1")), HasSubstr("'x' and 'y'"));
  for (const char* radius : {"0", "-1", "0.0099", "2.01", "1e300"})
    EXPECT_THAT(refusal(obstacle("\"a\"", "2", "0", radius)), HasSubstr("0.01 m to 2 m")) << radius;
  EXPECT_THAT(refusal(obstacle("\"a\"", "2", "0", "\"1\"")), HasSubstr("'radius'"));
  // The road is 0.18 m wide and ends at 8 m; the floor ends a metre off the path.
  EXPECT_THAT(refusal(obstacle("\"a\"", "1e300", "0", "0.1")), HasSubstr("off the floor"));
  EXPECT_THAT(refusal(obstacle("\"a\"", "4", "1.1", "0.1")), HasSubstr("to (9.09, 1.09) m; choose one inside"));
  EXPECT_THAT(refusal(R"({"removeObstacle":"nobody"})"), HasSubstr("none at all"));
  fixture.logged.clear();
  fixture.feed(wire::InputKind::command, "test", obstacle("\"box\"", "4", "1.0", "2"));
  EXPECT_THAT(fixture.logged, IsEmpty());
  EXPECT_THAT(refusal(R"({"removeObstacle":"bux"})"), HasSubstr("there is box"));
}

TEST(Plant, puts_no_obstacle_on_a_vehicle) {
  PlantFixture fixture{straight(8.0, "0.5 5.0"), 2};
  fixture.run_for(100ms);
  // The front is at 5.1 m: 1 cm before it is too near for a box of 2 cm, 3 cm is not.
  fixture.feed(wire::InputKind::command, "test", R"({"addObstacle":{"id":"box","x":5.11,"y":0,"radius":0.02}})");
  EXPECT_THAT(fixture.logged, ElementsAre(AllOf(HasSubstr("box: AIV2 is at this position"), HasSubstr("next to it"))));
  fixture.logged.clear();
  fixture.feed(wire::InputKind::command, "test", R"({"addObstacle":{"id":"box","x":5.13,"y":0,"radius":0.02}})");
  EXPECT_THAT(fixture.logged, IsEmpty());
  // Nor is an obstacle moved onto a vehicle; it stays at its old position.
  fixture.feed(wire::InputKind::command, "test", R"({"addObstacle":{"id":"box","x":0.5,"y":0,"radius":0.02}})");
  EXPECT_THAT(fixture.logged, ElementsAre(HasSubstr("AIV1 is at this position")));
  fixture.run_for(200ms);
  EXPECT_THAT(fixture.core().collisions(), IsEmpty());
  EXPECT_EQ(fixture.received<wire::Ranges>(2).back().range_mm[6], 10);
}

TEST(Plant, counts_a_collision_once_per_contact) {
  PlantFixture fixture{straight(8.0, "0.5 2.0"), 2};
  fixture.drive(1, fast);
  fixture.run_for(4s);
  ASSERT_THAT(fixture.core().collisions(), SizeIs(1));
  const Collision& hit = fixture.core().collisions().front();
  EXPECT_EQ(hit.a, "AIV1");
  EXPECT_EQ(hit.b, "AIV2");
  // Bumper to bumper after 1.3 m.
  EXPECT_NEAR(to_seconds(hit.at - virtual_epoch), (1.3 + 0.5 * 0.5 / 1.6 + 0.025) / 0.5, 0.03);
}

TEST(Plant, counts_a_collision_with_an_obstacle_by_its_name) {
  PlantFixture fixture{straight(8.0)};
  fixture.feed(wire::InputKind::command, "test", R"({"addObstacle":{"id":"box","x":1.5,"y":0.1,"radius":0.1}})");
  fixture.drive(1, fast);
  fixture.run_for(4s);
  ASSERT_THAT(fixture.core().collisions(), SizeIs(1));
  EXPECT_EQ(fixture.core().collisions().front().a, "AIV1");
  EXPECT_EQ(fixture.core().collisions().front().b, "box");
}

TEST(Plant, gives_each_vehicle_the_frames_of_its_own_ports) {
  PlantFixture fixture{straight(20.0, "0.5 5.0"), 2};
  fixture.drive(2, fast);
  fixture.run_for(2s);
  EXPECT_EQ(fixture.ground_truth(1).distance_m, 0.0);
  EXPECT_GT(fixture.ground_truth(2).distance_m, 0.5);
  fixture.feed(wire::InputKind::bytes, "2/PRAV", wire::module_link::encode(wire::Display{"hello"}, 0));
  EXPECT_EQ(fixture.ground_truth(1).display, "");
  EXPECT_EQ(fixture.ground_truth(2).display, "hello");
}

TEST(Plant, warns_of_ports_that_no_vehicle_has) {
  PlantFixture fixture{straight(20.0)};
  for (const char* port : {"0/PILS", "2/PILS", "1/PULS", "PILS", "1", "1/", "-1/PILS", "99999999999/PILS", ""}) {
    fixture.logged.clear();
    fixture.feed(wire::InputKind::port, port, "up");
    fixture.feed(wire::InputKind::bytes, port, "x");
    EXPECT_THAT(fixture.logged, SizeIs(2)) << port;
  }
}

TEST(Plant, sends_hello_on_every_port_and_keeps_odometer_and_session_over_a_crash_on_board) {
  PlantFixture fixture{straight(20.0)};
  fixture.drive(1, fast);
  fixture.run_for(2s);
  const auto first = fixture.received<wire::Hello>(1);
  ASSERT_THAT(first, SizeIs(4));
  const auto before_um = fixture.received<wire::Odometry>(1).back().distance_um;
  fixture.forget();
  for (const auto& port : fixture.core().ports()) fixture.feed(wire::InputKind::port, port, "down");
  fixture.run_for(1s);
  EXPECT_THAT(fixture.received<wire::Odometry>(1), IsEmpty());
  for (const auto& port : fixture.core().ports()) fixture.feed(wire::InputKind::port, port, "up");
  fixture.run_for(1s);
  EXPECT_EQ(fixture.received<wire::Hello>(1), first);
  EXPECT_GT(fixture.received<wire::Odometry>(1).front().distance_um, before_um);
}

TEST(Plant, that_starts_later_has_other_sessions) {
  PlantFixture fixture{straight(20.0)};
  fixture.run_for(20ms);
  auto later = PlantCore::make({straight(20.0), 1, 1, unresponsive(), true, true});
  ASSERT_TRUE(later);
  wire::Effects effects;
  (*later)->handle({virtual_epoch + 1h, wire::InputKind::port, "1/PILS", "up"}, effects);
  (*later)->handle({virtual_epoch + 1h, wire::InputKind::tick, "", ""}, effects);
  std::vector<wire::BoardMessage> received;
  for (const auto& effect : effects)
    if (const auto* bytes = std::get_if<wire::SendBytes>(&effect))
      wire::module_link::Decoder{}.feed(bytes->bytes, received);
  ASSERT_FALSE(received.empty());
  EXPECT_NE(std::get<wire::Hello>(received.front()).session, fixture.received<wire::Hello>(1).front().session);
}

TEST(Plant, drains_its_battery_by_its_work) {
  PlantFixture fixture{lacet4(), 2};
  fixture.drive(1, fast);
  fixture.run_for(60s);
  const double idle = 1.0 - fixture.ground_truth(2).charge;
  const double driving = 1.0 - fixture.ground_truth(1).charge;
  // 2.2 Ah at about 8.2 V hold 65 kJ at the top of the charge: 3 W for 60 s take 0.277 % of it.
  EXPECT_NEAR(idle, 180.0 / (2.2 * 3600.0 * 8.15), 2e-4);
  const double work_j = (0.6 * fixture.ground_truth(1).distance_m + 0.5 * 1.2 * 0.25) / 0.6;
  EXPECT_NEAR((driving - idle) / idle, work_j / 180.0, 0.02);
  EXPECT_NEAR(fixture.received<wire::Power>(1).back().charge_permille, 1000.0 * fixture.ground_truth(1).charge, 2.0);
  EXPECT_NEAR(fixture.received<wire::Power>(1).back().voltage_mv, 8150.0, 100.0);
}

// `cosiva battery fleet --live` sends the whole type along.
TEST(Plant, accepts_every_shipped_battery_type_over_the_broker) {
  PlantFixture fixture{straight(8.0)};
  fixture.feed(wire::InputKind::link, "", "up");
  for (const std::string& name : battery::shipped_types()) {
    JsonWriter json;
    json.begin_object().key("changeBattery").begin_object().field("vehicle", 1).field("id", "B-" + name);
    json.field("type", battery::to_json(*battery::shipped_type(name))).end_object().end_object();
    fixture.published.clear();
    const double before_v = fixture.ground_truth(1).power.voltage_v;
    fixture.feed(wire::InputKind::message, std::string(wire::plant_command_topic), json.take());
    EXPECT_TRUE(fixture.logged.empty()) << name;
    EXPECT_NE(fixture.ground_truth(1).power.voltage_v, before_v) << name;
    EXPECT_TRUE(fixture.published.empty()) << "the plant confirms no battery: " << name;
  }
}

TEST(Plant, publishes_reference_poses_once_a_second) {
  PlantFixture fixture{lacet4(), 2};
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.drive(1, fast);
  fixture.run_for(2900ms);
  std::erase_if(fixture.published, [](const auto& message) { return message.topic != wire::reference_poses_topic; });
  ASSERT_THAT(fixture.published, SizeIs(3));
  const auto poses = wire::gvs_detections_from_json(fixture.published.back().payload);
  ASSERT_TRUE(poses) << to_string(poses.error());
  ASSERT_THAT(poses->detections, SizeIs(2));
  EXPECT_EQ(poses->detections[0].vehicle, "CoSiVA/AIV1");
  EXPECT_EQ(poses->detections[0].at, poses->timestamp);
  // At 0.5 m/s, since the message.
  EXPECT_LT(distance(poses->detections[0].pose, fixture.ground_truth(1).X_MB), 0.5 * 1.0);
  EXPECT_LT(distance(poses->detections[1].pose, fixture.ground_truth(2).X_MB), 1e-5);
}

// actualAIVposition of figures 16 and 17, where no GVS runs.
TEST(Plant, responds_to_a_request_for_a_vehicle_s_actual_position) {
  PlantFixture fixture{lacet4(), 2};
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.drive(1, fast);
  fixture.run_for(2s);
  fixture.published.clear();
  const std::string topic = "cosiva/v1/plant/actual_position/request/CoSiVA/AIV";
  fixture.feed(wire::InputKind::message, topic + "1", R"({"session":"q/1","sequence":7})");
  ASSERT_THAT(fixture.published, SizeIs(1));
  EXPECT_EQ(fixture.published[0].topic, "cosiva/v1/plant/actual_position/response/CoSiVA/AIV1");
  const auto position = wire::actual_position_from_json(fixture.published[0].payload);
  ASSERT_TRUE(position) << to_string(position.error());
  EXPECT_EQ(position->session, "q/1");
  EXPECT_EQ(position->sequence, 7U);
  EXPECT_LT(distance(position->X_MB, fixture.ground_truth(1).X_MB), 1e-5);
  fixture.published.clear();
  fixture.feed(wire::InputKind::message, topic + "9", R"({"session":"q/1","sequence":7})");
  fixture.feed(wire::InputKind::message, topic + "1", "{");
  EXPECT_THAT(fixture.published, SizeIs(0)) << "an unknown vehicle, and a request that cannot be read";
}

TEST(Plant, publishes_the_ground_truth_ten_times_a_second) {
  PlantFixture fixture{straight(8.0, "0.5 5.0"), 2};
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.feed(wire::InputKind::command, "test", R"({"addObstacle":{"id":"box","x":7.5,"y":0.25,"radius":0.1}})");
  fixture.run_for(500ms);  // the zone goes first
  fixture.published.clear();
  fixture.drive(1, fast);
  fixture.run_for(2s);
  std::erase_if(fixture.published, [](const auto& message) { return message.topic != wire::ground_truth_topic; });
  ASSERT_THAT(fixture.published, SizeIs(AllOf(Ge(19U), Le(21U))));
  EXPECT_FALSE(fixture.published.back().retained);
  const auto json = JsonValue::parse(fixture.published.back().payload);
  ASSERT_TRUE(json);
  EXPECT_TRUE(json->text("timestamp"));
  ASSERT_THAT(*json->find("vehicles")->array(), SizeIs(2));
  const auto& first = (*json->find("vehicles")->array())[0];
  EXPECT_EQ(first.number("number"), 1.0);
  EXPECT_NEAR(first.number("x").value(), fixture.ground_truth(1).X_MB.x_m, 0.05);
  EXPECT_NEAR(first.number("speed").value(), 0.5, 1e-3);
  EXPECT_EQ(first.number("heading"), 0.0);
  EXPECT_EQ((*json->find("obstacles")->array())[0].text("id"), "box");
  EXPECT_EQ(json->number("collisions"), 0.0);
  fixture.feed(wire::InputKind::link, "", "down");
  fixture.published.clear();
  fixture.run_for(1s);
  EXPECT_THAT(fixture.published, IsEmpty());
}

TEST(Plant, summarises_the_run) {
  PlantFixture fixture{straight(8.0, "0.5 2.0"), 2};
  fixture.drive(1, fast);
  fixture.run_for(4s);
  fixture.fall_unresponsive(1);
  fixture.run_for(10s);
  const auto json = JsonValue::parse(fixture.core().summary_json());
  ASSERT_TRUE(json);
  ASSERT_THAT(*json->find("vehicles")->array(), SizeIs(2));
  EXPECT_NEAR((*json->find("vehicles")->array())[0].number("distance").value(), fixture.ground_truth(1).distance_m,
              1e-12);
  ASSERT_THAT(*json->find("collisions")->array(), SizeIs(1));
  EXPECT_EQ((*json->find("collisions")->array())[0].text("b"), "AIV2");
  EXPECT_EQ(json->number("laps"), 0.0);  // no loop
  // Stopped since 0.25 s + 0.5 s of braking + the lag; the second vehicle never moved, so it does not wait.
  EXPECT_NEAR(json->number("longest_wait_s").value(), 10.0 - 0.25 - 0.7, 0.2);
  EXPECT_EQ((*json->find("vehicles")->array())[1].number("longest_wait_s"), 0.0);
}

TEST(Plant, is_stopped_during_a_gap_in_its_ticks) {
  PlantFixture fixture{straight(20.0)};
  fixture.drive(1, fast);
  fixture.run_for(2s);
  const double before_m = fixture.ground_truth(1).distance_m;
  wire::Effects effects;
  fixture.core().handle({fixture.now() + 1h, wire::InputKind::tick, "", ""}, effects);
  EXPECT_EQ(fixture.ground_truth(1).distance_m, before_m);
  ASSERT_FALSE(effects.empty());
  EXPECT_TRUE(std::holds_alternative<wire::Log>(effects.front()));
}

TEST(Plant, gives_equal_runs_equal_digests_and_other_seeds_other_digests) {
  const auto run = [](std::uint64_t seed) {
    PlantFixture fixture{lacet4(), 4, PlantNoise{}, seed};
    fixture.feed(wire::InputKind::link, "", "up");
    for (std::uint32_t i = 1; i <= 4; ++i) fixture.drive(i, fast);
    fixture.run_for(20s);
    return fixture.digest();
  };
  EXPECT_EQ(run(1), run(1));
  EXPECT_NE(run(1), run(2));
}

TEST(Plant, keeps_the_noise_of_other_vehicles_when_one_vehicle_changes) {
  PlantFixture two{straight(20.0, "0.5 8.0"), 2, PlantNoise{}};
  PlantFixture one{straight(20.0, "0.5 8.0"), 2, PlantNoise{}};
  two.drive(1, fast);
  two.drive(2, fast);
  one.drive(2, fast);
  two.run_for(5s);
  one.run_for(5s);
  EXPECT_EQ(one.received<wire::Odometry>(2), two.received<wire::Odometry>(2));
}

TEST(Plant, refuses_more_vehicles_than_its_zone_holds) {
  const auto made = PlantCore::make({straight(1.0, "0.5"), 50, 1, {}, true, true});
  ASSERT_FALSE(made);
  EXPECT_EQ(made.error().code, "plant.vehicles");
  EXPECT_FALSE(PlantCore::make({straight(1.0, "0.5"), 0, 1, {}, true, true}));
}

TEST(Plant, refuses_a_bad_zone_with_the_factory_s_own_error) {
  const auto made = PlantCore::make({{"toml", "bad.toml", "name = 7"}, 1, 1, {}, true, true});
  ASSERT_FALSE(made);
  EXPECT_THAT(to_string(made.error()), HasSubstr("bad.toml"));
  EXPECT_FALSE(PlantCore::make({{"cad", "x", ""}, 1, 1, {}, true, true}));
}

}  // namespace
}  // namespace cosiva::physical
