#include "cosiva/wire/own/control_areas.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/limits_fixture.h"

namespace cosiva::wire {
namespace {

using ::testing::HasSubstr;

TEST(ServerTopics, are_the_fixed_ones_for_the_only_server_of_a_broker) {
  const ServerTopics topics = server_topics("");
  EXPECT_EQ(topics.zone_prefix, zone_topic_prefix);
  EXPECT_EQ(topics.connection, server_connection_topic);
  EXPECT_EQ(topics.heartbeat, server_heartbeat_topic);
}

TEST(ServerTopics, are_below_the_name_of_a_control_area) {
  const ServerTopics topics = server_topics("north");
  EXPECT_EQ(topics.zone_prefix, "cosiva/v1/area/north/zone/");
  EXPECT_EQ(topics.connection, "cosiva/v1/area/north/server/connection");
  EXPECT_EQ(topics.heartbeat, "cosiva/v1/area/north/server/heartbeat");
  for (const std::string& topic : {topics.zone_prefix + "toml", topics.connection, topics.heartbeat}) {
    const auto parsed = parse_area_topic(topic);
    ASSERT_TRUE(parsed) << topic;
    EXPECT_EQ(parsed->area, "north");
  }
  EXPECT_EQ(parse_area_topic(topics.zone_prefix + "lif.json")->rest, "zone/lif.json");
}

TEST(AreaTopic, has_an_area_and_at_least_one_level_below) {
  for (const char* text : {"", "cosiva/v1/area/", "cosiva/v1/area/north", "cosiva/v1/area/north/",
                           "cosiva/v1/area//zone", "cosiva/v1/areas/north/zone", "cosiva/v1/area/no rth/zone"})
    EXPECT_FALSE(parse_area_topic(text)) << text;
  EXPECT_FALSE(valid_area_name(std::string(33, 'x')));
  EXPECT_TRUE(valid_area_name(std::string(32, 'x')));
}

TEST(Owner, is_read_back_from_its_json_with_all_or_only_required_fields) {
  Owner owner{"north", 7, virtual_epoch + std::chrono::milliseconds{1500}, std::nullopt, std::nullopt};
  EXPECT_EQ(*owner_from_json(to_json(owner)), owner);
  owner.pose = Pose2{1.25, -0.5, 1.5};
  owner.mission = Owner::Mission{"go", "dock"};
  EXPECT_EQ(*owner_from_json(to_json(owner)), owner);
  EXPECT_EQ(to_json(owner), R"({"area":"north","sequence":7,"timestamp":")" + to_iso8601(owner.timestamp) +
                                R"(",)"
                                R"("pose":{"x":1.25,"y":-0.5,"theta":1.5},"mission":{"kind":"go","name":"dock"}})");
}

TEST(Owner, is_refused_naming_the_missing_or_wrong_field) {
  const auto fault = [](const std::string& text) {
    const auto read = owner_from_json(text);
    return read ? std::string("read") : read.error().location;
  };
  const std::string rest = R"("sequence":1,"timestamp":"2026-01-01T00:00:00.000Z")";
  EXPECT_EQ(fault(R"({"area":"a",)" + rest + "}"), "read");
  EXPECT_EQ(fault("{" + rest + "}"), "area");
  EXPECT_EQ(fault(R"({"area":"a/b",)" + rest + "}"), "area");
  EXPECT_EQ(fault(R"({"area":"",)" + rest + "}"), "area");
  EXPECT_EQ(fault(R"({"area":"a","sequence":-1,"timestamp":"2026-01-01T00:00:00.000Z"})"), "sequence");
  EXPECT_EQ(fault(R"({"area":"a","sequence":1,"timestamp":"noon"})"), "timestamp");
  EXPECT_EQ(fault(R"({"area":"a",)" + rest + R"(,"pose":{"x":1,"y":1e9,"theta":0}})"), "pose.y");
  EXPECT_EQ(fault(R"({"area":"a",)" + rest + R"(,"mission":{"kind":"dance","name":""}})"), "mission.kind");
}

TEST(Owner, has_a_mission_to_go_or_to_circulate) {
  for (const char* kind : {"go", "circulate"}) {
    const Owner owner{"north", 7, virtual_epoch, Pose2{1.25, -0.5, 1.5}, Owner::Mission{kind, ""}};
    EXPECT_EQ(owner_from_json(to_json(owner)).value(), owner);
  }
}

TEST(Owner, is_accepted_with_each_number_within_its_range_only) {
  const Owner owner{"north", 7, virtual_epoch, Pose2{1.25, -0.5, 1.5}, Owner::Mission{"go", "dock"}};
  test::expect_ranges(
      to_json(owner), owner_from_json,
      {{"sequence", 0, 4294967295, 1}, {"pose.x", -1e5, 1e5}, {"pose.y", -1e5, 1e5}, {"pose.theta", -100, 100}});
  test::expect_required(
      to_json(owner), owner_from_json,
      {"area", "sequence", "timestamp", "pose.x", "pose.y", "pose.theta", "mission.kind", "mission.name"});
}

}  // namespace
}  // namespace cosiva::wire
