#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/physical/plant/plant_fixture.h"
#include "cosiva/physical/plant/plant_options.h"
#include "cosiva/physical/plant/test_zones.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/zone/edit/edit.h"

namespace cosiva::physical {
namespace {

using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::Ge;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Le;
using ::testing::SizeIs;

constexpr wire::Drive fast{500, 800, 1000, 0};
constexpr wire::Drive still{0, 800, 1000, 0};
constexpr wire::Drive seek{300, 500, 800, 0, true};

std::vector<wire::Publish> zones(const PlantFixture& fixture) {
  std::vector<wire::Publish> found;
  for (const auto& message : fixture.published)
    if (message.topic.starts_with(wire::zone_topic_prefix)) found.push_back(message);
  return found;
}
void send_zone(PlantFixture& fixture, const std::string& text, const std::string& format = "toml") {
  fixture.feed(wire::InputKind::message, std::string(wire::zone_topic_prefix) + format, text);
}
zone::ZoneConfiguration with(const zone::ZoneConfiguration& zone, const zone::ZoneEdit& edit) {
  auto after = zone::edited(zone, edit);
  EXPECT_TRUE(after) << to_string(after.error());
  return *after;
}

TEST(Plant, publishes_its_zone_retained_when_the_broker_is_connected) {
  PlantFixture fixture{lacet4()};
  fixture.run_for(1s);
  EXPECT_THAT(fixture.published, IsEmpty());
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.run_for(290ms);
  EXPECT_THAT(zones(fixture), IsEmpty());  // it first receives what the broker retains
  fixture.run_for(10ms);
  EXPECT_THAT(zones(fixture), ElementsAre(wire::Publish{"cosiva/v1/zone/toml", lacet4().text, 1, true}));
  fixture.run_for(5s);
  EXPECT_THAT(zones(fixture), SizeIs(1));
}

TEST(Plant, subscribes_anew_whenever_its_link_is_established) {
  PlantFixture fixture{lacet4()};
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.run_for(200ms);
  fixture.feed(wire::InputKind::link, "", "down");
  fixture.run_for(1s);
  EXPECT_THAT(zones(fixture), IsEmpty());
  for (std::size_t times = 1; times <= 2; ++times) {
    fixture.feed(wire::InputKind::link, "", "up");
    fixture.run_for(300ms);
    EXPECT_THAT(zones(fixture), SizeIs(times));
  }
}

TEST(Plant, does_not_publish_what_the_broker_has) {
  PlantFixture fixture{lacet4()};
  fixture.feed(wire::InputKind::link, "", "up");
  send_zone(fixture, lacet4().text);
  fixture.run_for(1s);
  EXPECT_THAT(zones(fixture), IsEmpty());
  EXPECT_THAT(fixture.logged, IsEmpty());
}

TEST(Plant, that_restarts_adopts_the_edits_that_the_broker_retained) {
  PlantFixture fixture{lacet4()};
  const auto edited = with(lacet4(), {{{1, {0, 0.4}}}, {2}, 0.2, {{"CoSiVA/AIV1", 3}}});
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.run_for(50ms);
  send_zone(fixture, edited.text);
  fixture.run_for(1s);
  EXPECT_THAT(zones(fixture), IsEmpty());
  EXPECT_EQ(fixture.core().options().zone.text, edited.text);
  EXPECT_THAT(fixture.logged, ElementsAre(HasSubstr("11 tags")));
  // A broker that lost its retained messages is sent the edited zone.
  fixture.feed(wire::InputKind::link, "", "down");
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.run_for(1s);
  EXPECT_THAT(zones(fixture), ElementsAre(wire::Publish{"cosiva/v1/zone/toml", edited.text, 1, true}));
}

TEST(Plant, lets_its_readers_find_moved_tags_while_driving) {
  const auto zone = straight(20.0, "0.5",
                             "[[tag]]\nnumber = 1\nsection = \"line\"\ns_m = 5.0\n"
                             "[[tag]]\nnumber = 2\nsection = \"line\"\ns_m = 6.0\n");
  PlantFixture fixture{zone};
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.drive(1, fast);
  fixture.run_for(2s);
  send_zone(fixture, with(zone, {{{1, {0, 3.0}}, {3, {0, 4.0}}}, {2}, {}, {}}).text);
  std::map<std::uint32_t, double> read_at;
  for (int i = 0; i < 1500; ++i) {
    fixture.forget();
    fixture.run_for(10ms);
    for (const auto& tag : fixture.received<wire::TagRead>(1))
      read_at[tag.number] = fixture.ground_truth(1).X_MB.x_m - 0.5 * 1e-3 * tag.age_ms;
  }
  ASSERT_THAT(read_at, SizeIs(2));
  // Where the antenna's field of 2 cm begins, and up to 30 ms of reader and tick later.
  EXPECT_THAT(read_at[1], AllOf(Ge(2.98), Le(2.998)));
  EXPECT_THAT(read_at[3], AllOf(Ge(3.98), Le(3.998)));
  EXPECT_NEAR(fixture.ground_truth(1).speed_mps, 0.5, 1e-6);  // the vehicle never stopped for it
}

TEST(Plant, keeps_its_zone_when_an_invalid_or_no_zone_is_sent) {
  PlantFixture fixture{lacet4()};
  fixture.feed(wire::InputKind::link, "", "up");
  send_zone(fixture, straight(8.0).text);
  EXPECT_THAT(fixture.logged, ElementsAre(AllOf(HasSubstr("'test'"), HasSubstr("'lacet4'"))));
  fixture.logged.clear();
  send_zone(fixture, "name = ");
  send_zone(fixture, "<zone/>", "xml");
  EXPECT_THAT(fixture.logged, ElementsAre(HasSubstr("cannot be read"), HasSubstr("cannot be read")));
  fixture.logged.clear();
  send_zone(fixture, "");  // cleared, not sent
  EXPECT_THAT(fixture.logged, IsEmpty());
  fixture.run_for(1s);
  EXPECT_THAT(zones(fixture), ElementsAre(wire::Publish{"cosiva/v1/zone/toml", lacet4().text, 1, true}));
  EXPECT_EQ(fixture.core().options().zone.text, lacet4().text);
}

// --- another zone

/// A straight line eastward from (x, y), with a name of its own.
zone::ZoneConfiguration straight_from(double x_m, double y_m, double length_m, const std::string& more = "") {
  zone::ZoneConfiguration zone = straight(length_m, "", more);
  const auto put = [&](const std::string& was, const std::string& is) {
    zone.text.replace(zone.text.find(was), was.size(), is);
  };
  put("name = \"test\"", "name = \"next\"");
  put("x = 0.0, y = 0.0", "x = " + std::to_string(x_m) + ", y = " + std::to_string(y_m));
  return zone;
}
std::string switch_command(const zone::ZoneConfiguration& zone) {
  JsonWriter json;
  json.begin_object();
  zone::write_json(json.key("switch"), zone);
  json.end_object();
  return json.take();
}
PlantFixture running(zone::ZoneConfiguration zone, std::uint32_t vehicles = 1) {
  PlantFixture fixture{std::move(zone), vehicles};
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.run_for(400ms);
  fixture.published.clear();
  return fixture;
}

TEST(PlantSwitch, lets_a_vehicle_follow_its_old_path_until_it_is_stopped) {
  PlantFixture fixture = running(straight(20.0));
  fixture.drive(1, fast);
  fixture.run_for(2s);
  send_zone(fixture, straight_from(-5.0, 0.1, 20.0).text);
  EXPECT_THAT(fixture.logged, ElementsAre(AllOf(HasSubstr("'test'"), HasSubstr("'next'"))));
  fixture.run_for(2s);
  EXPECT_EQ(fixture.ground_truth(1).X_MB.y_m, 0.0);
  EXPECT_NEAR(fixture.ground_truth(1).speed_mps, 0.5, 1e-6);
  EXPECT_FALSE(fixture.received<wire::Odometry>(1).back().line_lost);

  fixture.drive(1, still);
  fixture.run_for(2s);
  const Pose2 is_stopped = fixture.ground_truth(1).X_MB;
  EXPECT_EQ(is_stopped.y_m, 0.0) << "its pose is what it was";
  EXPECT_TRUE(fixture.received<wire::Odometry>(1).back().line_lost);
  fixture.drive(1, fast);
  fixture.run_for(1s);
  EXPECT_EQ(fixture.ground_truth(1).X_MB, is_stopped) << "it has no line to follow and was not commanded to seek one";
}

TEST(PlantSwitch, brings_a_seeking_vehicle_onto_the_new_path_and_lets_it_read_the_tags_there) {
  PlantFixture fixture = running(straight(20.0, "5.0", "[[tag]]\nnumber = 1\nsection = \"line\"\ns_m = 6.0\n"));
  send_zone(fixture, straight_from(-5.0, 0.1, 20.0, "[[tag]]\nnumber = 2\nsection = \"line\"\ns_m = 11.0\n").text);
  fixture.run_for(100ms);
  const auto before = fixture.received<wire::Odometry>(1).back();
  fixture.forget();
  fixture.drive(1, seek);
  fixture.run_for(1s);
  const auto during = fixture.received<wire::Odometry>(1).back();
  ASSERT_TRUE(during.manoeuvre);
  EXPECT_EQ(during.speed_mmps, 0);
  EXPECT_EQ(during.distance_um, before.distance_um);
  EXPECT_GT(during.manoeuvre->turned_mrad, 500);
  fixture.run_for(4s);
  wire::Manoeuvre last;
  for (const auto& odometry : fixture.received<wire::Odometry>(1)) last = odometry.manoeuvre.value_or(last);
  EXPECT_NEAR(last.x_mm, 0, 1);
  EXPECT_NEAR(last.y_mm, 100, 2);
  EXPECT_NEAR(last.turned_mrad, 0, 15) << "the last report may be 20 ms before its end";
  EXPECT_FALSE(fixture.received<wire::Odometry>(1).back().line_lost);
  fixture.run_for(4s);
  EXPECT_NEAR(fixture.ground_truth(1).X_MB.y_m, 0.1, 1e-3);
  ASSERT_GT(fixture.ground_truth(1).X_MB.x_m, 6.1);
  const auto tags = fixture.received<wire::TagRead>(1);
  ASSERT_THAT(tags, SizeIs(1));
  EXPECT_EQ(tags[0].number, 2U);
}

TEST(PlantSwitch, is_refused_with_the_reason_when_the_zone_cannot_be_read) {
  PlantFixture fixture = running(straight(20.0));
  fixture.drive(1, fast);
  send_zone(fixture, "name = ");
  send_zone(fixture, "<zone/>", "xml");
  EXPECT_THAT(fixture.logged, ElementsAre(HasSubstr("cannot be read"), HasSubstr("cannot be read")));
  send_zone(fixture, "");
  EXPECT_THAT(fixture.logged, SizeIs(2));
  fixture.run_for(2s);
  EXPECT_NEAR(fixture.ground_truth(1).speed_mps, 0.5, 1e-6);
  EXPECT_EQ(fixture.core().options().zone.text, straight(20.0).text);
}

TEST(PlantSwitch, by_hand_is_published_and_its_echo_changes_nothing) {
  PlantFixture fixture = running(straight(20.0));
  const auto next = straight_from(-5.0, 0.1, 20.0);
  fixture.feed(wire::InputKind::command, "test", switch_command(next));
  EXPECT_THAT(zones(fixture), ElementsAre(wire::Publish{"cosiva/v1/zone/toml", next.text, 1, true}));
  EXPECT_EQ(fixture.core().options().zone.text, next.text);
  fixture.logged.clear();
  send_zone(fixture, next.text);
  fixture.run_for(1s);
  EXPECT_THAT(fixture.logged, IsEmpty());
  EXPECT_THAT(zones(fixture), SizeIs(1));
  EXPECT_TRUE(fixture.received<wire::Odometry>(1).back().line_lost);
}

TEST(PlantSwitch, by_hand_with_an_invalid_zone_is_refused_and_nothing_is_published) {
  PlantFixture fixture = running(straight(20.0));
  fixture.feed(wire::InputKind::command, "test", switch_command({"toml", "bad.toml", "name = 7"}));
  fixture.feed(wire::InputKind::command, "test", R"({"switch":7})");
  EXPECT_THAT(fixture.logged, ElementsAre(AllOf(HasSubstr("refused"), HasSubstr("bad.toml")), HasSubstr("refused")));
  EXPECT_THAT(zones(fixture), IsEmpty());
  EXPECT_EQ(fixture.core().options().zone.text, straight(20.0).text);
}

TEST(PlantSwitch, by_hand_without_a_broker_is_published_when_one_is_connected) {
  PlantFixture fixture{straight(20.0)};
  const auto next = straight_from(-5.0, 0.1, 20.0);
  fixture.feed(wire::InputKind::command, "test", switch_command(next));
  fixture.published.clear();
  fixture.feed(wire::InputKind::link, "", "up");
  fixture.run_for(1s);
  EXPECT_THAT(zones(fixture), ElementsAre(wire::Publish{"cosiva/v1/zone/toml", next.text, 1, true}));
}

/// A line 20 m eastward from (-5, 0.1), as a layout in another format.
zone::ZoneConfiguration layout() {
  const std::string node = R"("layoutLevelId":"","vehicleTypeNodeProperties":[{"vehicleTypeId":"cart"}])";
  zone::ZoneConfiguration zone{"lif", "line.lif.json", ""};
  zone.text = R"({"metaInformation":{"projectIdentification":"line","creator":"test",)"
              R"("exportTimestamp":"2024-01-01T00:00:00.00Z","lifVersion":"1.0.0"},"layouts":[{"layoutId":"line",)"
              R"("layoutVersion":"1","nodes":[{"nodeId":"a","nodePosition":{"x":-5,"y":0.1},)" +
              node + R"(},{"nodeId":"b","nodePosition":{"x":15,"y":0.1},)" + node +
              R"(}],"edges":[{"edgeId":"ab","startNodeId":"a","endNodeId":"b","vehicleTypeEdgeProperties":)"
              R"([{"vehicleTypeId":"cart","vehicleOrientation":0,"maxSpeed":1.0}]}],"stations":[]}]})";
  zone.sidecar = "[vehicle]\nlength_m = 0.20\nwidth_m = 0.12\n";
  return zone;
}

TEST(PlantSwitch, by_hand_to_another_format_clears_the_retained_zone_of_the_old_format) {
  PlantFixture fixture = running(straight(20.0, "5.0"));
  fixture.feed(wire::InputKind::command, "test", switch_command(layout()));
  EXPECT_THAT(fixture.logged, ElementsAre(HasSubstr("switched")));
  EXPECT_THAT(zones(fixture), ElementsAre(wire::Publish{"cosiva/v1/zone/lif", zone::to_payload(layout()), 1, true},
                                          wire::Publish{"cosiva/v1/zone/toml", "", 1, true}));
  fixture.drive(1, seek);
  fixture.run_for(8s);
  EXPECT_NEAR(fixture.ground_truth(1).X_MB.y_m, 0.1, 1e-3);
  EXPECT_EQ(fixture.core().options().zone, layout());
}

TEST(PlantSwitch, takes_a_layout_with_its_sidecar_from_the_broker) {
  PlantFixture fixture = running(straight(20.0, "5.0"));
  send_zone(fixture, zone::to_payload(layout()), "lif");
  fixture.run_for(100ms);
  EXPECT_TRUE(fixture.received<wire::Odometry>(1).back().line_lost);
  EXPECT_EQ(fixture.core().options().zone.sidecar, layout().sidecar);
  EXPECT_THAT(zones(fixture), IsEmpty()) << "its publisher clears the old one";
}

TEST(PlantSwitch, at_the_start_clears_the_zone_of_another_format_that_it_overrides) {
  PlantFixture fixture{straight(20.0, "5.0")};
  fixture.feed(wire::InputKind::link, "", "up");
  send_zone(fixture, zone::to_payload(layout()), "lif");
  send_zone(fixture, straight(20.0, "5.0").text);  // the broker has this plant's zone, too
  fixture.run_for(1s);
  EXPECT_THAT(zones(fixture), ElementsAre(wire::Publish{"cosiva/v1/zone/toml", straight(20.0, "5.0").text, 1, true},
                                          wire::Publish{"cosiva/v1/zone/lif", "", 1, true}));
}

TEST(PlantSwitch, there_and_back_leaves_the_vehicle_on_its_path) {
  PlantFixture fixture = running(straight(20.0, "5.0"));
  send_zone(fixture, straight_from(-5.0, 0.1, 20.0).text);
  fixture.run_for(100ms);
  EXPECT_TRUE(fixture.received<wire::Odometry>(1).back().line_lost);
  send_zone(fixture, straight(20.0, "5.0").text);
  fixture.run_for(100ms);
  EXPECT_FALSE(fixture.received<wire::Odometry>(1).back().line_lost);
  fixture.drive(1, fast);
  fixture.run_for(2s);
  EXPECT_GT(fixture.ground_truth(1).X_MB.x_m, 5.4);
  EXPECT_EQ(fixture.ground_truth(1).X_MB.y_m, 0.0);
}

TEST(PlantSwitch, skips_a_zone_that_was_replaced_while_the_vehicle_moved) {
  PlantFixture fixture = running(straight(20.0));
  fixture.drive(1, fast);
  fixture.run_for(1s);
  send_zone(fixture, straight_from(-5.0, 0.1, 20.0).text);
  fixture.run_for(500ms);
  send_zone(fixture, straight_from(-5.0, -0.1, 20.0).text);
  fixture.run_for(500ms);
  fixture.drive(1, still);
  fixture.run_for(2s);
  fixture.drive(1, seek);
  fixture.run_for(5s);
  EXPECT_NEAR(fixture.ground_truth(1).X_MB.y_m, -0.1, 1e-3);
}

TEST(PlantSwitch, refuses_no_zone_for_having_too_many_vehicles_and_keeps_obstacles_and_batteries) {
  PlantFixture fixture = running(straight(20.0, "0.5 2.0 4.0"), 3);
  fixture.feed(wire::InputKind::command, "test", R"({"addObstacle":{"id":"box","x":15,"y":0.5,"radius":0.1}})");
  fixture.run_for(10s);
  const double charge = fixture.ground_truth(3).charge;
  send_zone(fixture, straight_from(0.0, 0.1, 1.0).text);
  fixture.run_for(500ms);
  EXPECT_NEAR(fixture.ground_truth(3).X_MB.x_m, 4.0, 1e-12);
  EXPECT_LE(fixture.ground_truth(3).charge, charge);
  EXPECT_GT(fixture.ground_truth(3).charge, charge - 1e-3);
  fixture.logged.clear();
  fixture.feed(wire::InputKind::command, "test", R"({"removeObstacle":"box"})");
  EXPECT_THAT(fixture.logged, IsEmpty()) << "the box was still there";
  fixture.drive(1, seek);
  fixture.drive(3, seek);
  fixture.run_for(4s);
  EXPECT_NEAR(fixture.ground_truth(1).X_MB.y_m, 0.1, 1e-3);
  EXPECT_EQ(fixture.ground_truth(3).X_MB.y_m, 0.0) << "no section is near it";
}

TEST(PlantSwitch, detects_collisions_while_a_vehicle_drives_to_its_path) {
  // Bodies are 0.20 m by 0.12 m: side by side, 0.25 m apart, both may be stopped, but a vehicle that turns and drives
  // across the other's position touches it.
  PlantFixture fixture = running(straight(20.0, "5.0 5.5"), 2);
  send_zone(fixture, straight_from(-5.0, 0.25, 20.0).text);
  fixture.drive(1, seek);
  fixture.run_for(10s);
  EXPECT_THAT(fixture.core().collisions(), IsEmpty());
  fixture.drive(1, still);
  fixture.run_for(2s);
  // Now the second vehicle's path leads through a box.
  const double x_m = fixture.ground_truth(2).X_MB.x_m;
  fixture.feed(wire::InputKind::command, "test",
               R"({"addObstacle":{"id":"box","x":)" + std::to_string(x_m) + R"(,"y":0.25,"radius":0.05}})");
  fixture.drive(2, seek);
  fixture.run_for(5s);
  ASSERT_THAT(fixture.core().collisions(), SizeIs(1));
  EXPECT_EQ(fixture.core().collisions()[0].a, "AIV2");
  EXPECT_EQ(fixture.core().collisions()[0].b, "box");
}

TEST(PlantSwitch, keeps_the_laps_of_the_previous_zone) {
  PlantFixture fixture = running(lacet4());
  fixture.drive(1, fast);
  fixture.run_for(75s);  // two laps of 17.3 m, and a little
  ASSERT_EQ(fixture.ground_truth(1).laps, 2U);
  send_zone(fixture, straight_from(-5.0, 0.1, 20.0).text);
  fixture.drive(1, still);
  fixture.run_for(2s);
  EXPECT_EQ(fixture.ground_truth(1).laps, 2U);
  send_zone(fixture, lacet4().text);
  fixture.run_for(100ms);
  EXPECT_EQ(fixture.ground_truth(1).laps, 2U) << "a lap begins anew on a floor";
  fixture.drive(1, fast);
  fixture.run_for(36s);
  EXPECT_EQ(fixture.ground_truth(1).laps, 3U);
}

TEST(PlantSwitch, does_not_adopt_what_the_broker_retained_and_logs_it) {
  PlantFixture fixture{straight(20.0, "5.0")};
  fixture.feed(wire::InputKind::link, "", "up");
  send_zone(fixture, straight_from(-5.0, 0.1, 20.0).text);
  EXPECT_THAT(fixture.logged, ElementsAre(AllOf(HasSubstr("the broker retains zone 'next'"), HasSubstr("keeps its own"),
                                                HasSubstr("publishes it"))));
  fixture.run_for(1s);
  EXPECT_THAT(zones(fixture), ElementsAre(wire::Publish{"cosiva/v1/zone/toml", straight(20.0, "5.0").text, 1, true}));
  EXPECT_FALSE(fixture.received<wire::Odometry>(1).back().line_lost);
  // Sent once more while the plant runs, the zone is a switch.
  send_zone(fixture, straight_from(-5.0, 0.1, 20.0).text);
  fixture.run_for(100ms);
  EXPECT_TRUE(fixture.received<wire::Odometry>(1).back().line_lost);
}

TEST(PlantSwitch, gives_the_same_run_twice) {
  const auto run = [] {
    PlantFixture fixture{lacet4(), 4, PlantNoise{}, 5};
    fixture.feed(wire::InputKind::link, "", "up");
    for (std::uint32_t i = 1; i <= 4; ++i) fixture.drive(i, fast);
    fixture.run_for(5s);
    send_zone(fixture, straight_from(-5.0, 0.0, 20.0).text);
    for (std::uint32_t i = 1; i <= 4; ++i) fixture.drive(i, still);
    fixture.run_for(2s);
    for (std::uint32_t i = 1; i <= 4; ++i) fixture.drive(i, seek);
    fixture.run_for(5s);
    return fixture.digest();
  };
  EXPECT_EQ(run(), run());
}

}  // namespace
}  // namespace cosiva::physical
