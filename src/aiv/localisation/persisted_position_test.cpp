#include "cosiva/aiv/localisation/persisted_position.h"

#include <gtest/gtest.h>

#include <string>

#include "cosiva/base/math.h"

namespace cosiva::aiv {
namespace {

PersistedPosition whole() {
  PersistedPosition persisted;
  persisted.zone = "lacet4";
  persisted.section = "east";
  persisted.s_m = 0.375;
  persisted.odometer_um = -123'456;
  persisted.session = 77;
  persisted.paused = true;
  persisted.imposed = Profile::slow;
  persisted.pose = Pose2{1.5, -2.0, 0.5};
  persisted.off_path = true;
  persisted.manoeuvre = Pose2{0.125, 0.25, -0.5};
  persisted.next = "loop_se";
  return persisted;
}

std::string replaced(std::string json, const std::string& from, const std::string& to) {
  const std::size_t at = json.find(from);
  EXPECT_NE(at, std::string::npos) << from << " in " << json;
  return json.replace(at, from.size(), to);
}

TEST(PersistedPosition, is_written_field_by_field_and_read_back) {
  const std::string json = to_json(whole());
  EXPECT_EQ(json, R"({"zone":"lacet4","section":"east","s":0.375,"odometer_um":-123456,"session":77,"paused":true,)"
                  R"("pose":{"x":1.5,"y":-2,"theta":0.5},"off_path":true,)"
                  R"("manoeuvre":{"x":0.125,"y":0.25,"theta":-0.5},"next":"loop_se","profile":"slow"})");
  EXPECT_EQ(persisted_position_from_json(json).value(), whole());
}

TEST(PersistedPosition, leaves_out_what_there_is_not) {
  PersistedPosition persisted;
  persisted.zone = "lacet4";
  persisted.section = "east";
  const std::string json = to_json(persisted);
  EXPECT_EQ(json, R"({"zone":"lacet4","section":"east","s":0,"odometer_um":0,"session":0,"paused":false})");
  EXPECT_EQ(persisted_position_from_json(json).value(), persisted);
}

TEST(PersistedPosition, requires_zone_section_distance_odometer_and_session) {
  for (const char* key : {"zone", "section", "s", "odometer_um", "session"}) {
    const auto read =
        persisted_position_from_json(replaced(to_json(whole()), "\"" + std::string(key) + "\"", "\"other\""));
    ASSERT_FALSE(read) << key;
    EXPECT_EQ(read.error().code, "state.field") << key;
  }
  EXPECT_FALSE(persisted_position_from_json(""));
  EXPECT_FALSE(persisted_position_from_json("[]"));
}

TEST(PersistedPosition, accepts_whole_numbers_of_odometer_and_session_within_their_ranges) {
  const auto odometer = [](const char* number) {
    const auto read = persisted_position_from_json(replaced(to_json(whole()), "-123456", number));
    return read ? std::string("accepted") : read.error().location;
  };
  for (const char* good : {"0", "9007199254740992", "-9007199254740992"}) EXPECT_EQ(odometer(good), "accepted") << good;
  for (const char* bad : {"0.5", "9007199254740994", "-9007199254740994", "1e300"})
    EXPECT_EQ(odometer(bad), "odometer_um") << bad;
  const auto session = [](const char* number) {
    const auto read = persisted_position_from_json(replaced(to_json(whole()), "77", number));
    return read ? std::string("accepted") : read.error().location;
  };
  for (const char* good : {"0", "4294967295"}) EXPECT_EQ(session(good), "accepted") << good;
  for (const char* bad : {"-1", "0.5", "4294967296"}) EXPECT_EQ(session(bad), "session") << bad;
}

TEST(PersistedPosition, ignores_a_pose_that_is_incomplete_or_beyond_1000_km) {
  const auto pose = [](const std::string& text) {
    return persisted_position_from_json(replaced(to_json(whole()), R"({"x":1.5,"y":-2,"theta":0.5})", text))->pose;
  };
  EXPECT_EQ(pose(R"({"x":1000000,"y":-1000000,"theta":0})"), (Pose2{1e6, -1e6, 0.0}));
  EXPECT_EQ(pose(R"({"x":-1000000,"y":1000000,"theta":0})"), (Pose2{-1e6, 1e6, 0.0}));
  for (const char* bad :
       {R"({"y":1,"theta":0})", R"({"x":1,"theta":0})", R"({"x":1,"y":1})", "7", "null",
        R"({"x":1000001,"y":1,"theta":0})", R"({"x":1,"y":-1000001,"theta":0})", R"({"x":1,"y":1,"theta":1000001})"})
    EXPECT_EQ(pose(bad), std::nullopt) << bad;
  EXPECT_NEAR(pose(R"({"x":1,"y":1,"theta":7})")->heading_rad, 7.0 - 2.0 * pi, 1e-12);
  EXPECT_TRUE(pose(R"({"x":1,"y":1,"theta":1000000})"));
}

TEST(PersistedPosition, is_off_path_only_with_a_pose) {
  const std::string without_pose = replaced(to_json(whole()), R"("pose":)", R"("other":)");
  EXPECT_FALSE(persisted_position_from_json(without_pose)->off_path);
  EXPECT_TRUE(persisted_position_from_json(to_json(whole()))->off_path);
  EXPECT_FALSE(
      persisted_position_from_json(replaced(to_json(whole()), R"("off_path":true)", R"("off_path":false)"))->off_path);
}

TEST(PersistedPosition, contains_the_loads_on_board) {
  PersistedPosition persisted = whole();
  persisted.loads = {{"L1", "EPAL", "front", 8.5}, {"", "", "back", {}}};
  const std::string json = to_json(persisted);
  EXPECT_NE(json.find(R"("loads":[{"id":"L1","type":"EPAL","position":"front","weight_kg":8.5},)"
                      R"({"id":"","type":"","position":"back"}])"),
            std::string::npos)
      << json;
  EXPECT_EQ(persisted_position_from_json(json).value(), persisted);
  const auto damaged = persisted_position_from_json(replaced(json, R"("position":"front")", R"("device":"front")"));
  EXPECT_EQ(damaged->loads, (std::vector<wire::Load>{{"", "", "back", {}}})) << "the position is worth more";
  EXPECT_TRUE(persisted_position_from_json(replaced(json, R"("loads":[)", R"("loads":7,"more":[)"))->loads.empty());
}

TEST(PersistedPosition, has_at_most_512_kibibytes) {
  const std::string json = to_json(whole());
  EXPECT_TRUE(persisted_position_from_json(json + std::string(524288 - json.size(), ' ')));
  EXPECT_FALSE(persisted_position_from_json(json + std::string(524289 - json.size(), ' ')));
}

}  // namespace
}  // namespace cosiva::aiv
