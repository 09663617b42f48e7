#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cosiva/zone/opendrive/test_files.h"

/// What a zone cannot express, and the diagnostics of it; the name and the origin of a network.
namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;

/// Those about the whole file: "lost: 2 objects are not taken".
std::vector<std::string> of_file(const TrafficZone& zone) {
  std::vector<std::string> all;
  for (const Diagnostic& diagnostic : zone.diagnostics) {
    if (diagnostic.location == "file") all.push_back(std::string(to_string(diagnostic.kind)) + ": " + diagnostic.text);
  }
  return all;
}
const std::string driven_line = line(0.0, 0.0, 0.0, 0.0, 20.0);

TEST(OpenDriveIgnored, is_counted_kind_by_kind) {
  const std::string more = R"(<elevationProfile><elevation a="1"/><elevation b="1"/></elevationProfile>
      <lateralProfile><superelevation a="1"/><crossfall a="1"/><shape a="1"/></lateralProfile>
      <objects><object/><object/></objects><signals><signal/></signals><railroad/>)";
  const std::string both = R"(<lane id="-1" type="driving" direction="both"><width a="3"/></lane>)";
  const TrafficZone zone =
      zone_of(file(road("1", 20.0, driven_line, section(0.0, lane(1, R"(<width a="2"/>)", "sidewalk"), both), more) +
                   "<controller/><junctionGroup/><station/>"));
  EXPECT_THAT(of_file(zone),
              ElementsAre("notice: 2 records of elevation are not taken: the zone is flat",
                          "notice: 1 records of superelevation are not taken: the zone is flat",
                          "notice: 1 records of crossfall are not taken: the zone is flat",
                          "notice: 1 records of road shape are not taken: the zone is flat",
                          "lost: 1 signals are not taken: vehicles do not stop at lights and signs",
                          "lost: 2 objects are not taken", "lost: 1 controllers of signals are not taken",
                          "lost: 1 groups of junctions are not taken", "lost: 1 railroads are not taken",
                          "lost: 1 stations of railways and buses are not taken; the sidecar file can name stations",
                          "lost: 1 lanes are driven both ways in the file; here only in their side's direction",
                          "notice: lanes that are not driven on: 1 sidewalk"));
  EXPECT_THAT(of_file(zone_of(file(road("1", 20.0, driven_line, section(0.0, "", lane(-1)))))), ElementsAre());
}

TEST(OpenDriveIgnored, lane_types_are_listed_up_to_a_readable_length) {
  // Each takes 44 characters, with its count and a comma.
  const auto types = [](int count) {
    std::string lanes;
    for (int i = 0; i < count; ++i)
      lanes += lane(i + 1, R"(<width a="1"/>)", std::string(39, 't') + static_cast<char>('a' + i));
    return lanes;
  };
  const auto listed = [](const std::string& text) { return std::count(text.begin(), text.end(), '1'); };
  const TrafficZone zone = zone_of(file(road("7", 20.0, driven_line, section(0.0, types(10), lane(-1)))));
  ASSERT_EQ(of_file(zone).size(), 1U);
  EXPECT_EQ(listed(of_file(zone)[0]), 7);  // 306 characters are more than 300
  const auto none = read(file(road("7", 20.0, driven_line, section(0.0, types(10), ""))));
  ASSERT_FALSE(none);
  EXPECT_EQ(listed(none.error().message), 5);  // 218 characters are more than 200
}

TEST(OpenDriveIgnored, every_type_of_lane_for_vehicles_is_driven_on) {
  for (const char* type : {"driving", "entry", "exit", "onRamp", "offRamp", "taxi", "bus", "HOV", "slipLane",
                           "bidirectional", "mwyEntry", "mwyExit", "connectingRamp"})
    EXPECT_TRUE(read(file(road("1", 20.0, driven_line, section(0.0, "", lane(-1, R"(<width a="3"/>)", type))))))
        << type;
  for (const char* type : {"none", "shoulder", "biking", "sidewalk", "border", "parking", "median", "tram", "rail"})
    EXPECT_FALSE(read(file(road("1", 20.0, driven_line, section(0.0, "", lane(-1, R"(<width a="3"/>)", type))))))
        << type;
}

TEST(OpenDriveOrigin, is_moved_by_whole_kilometres_from_a_hundred_on) {
  const auto start_of = [](double x, double y) {
    // The first road without a plan view does not count.
    const TrafficZone zone = zone_of(
        file(road("0", 20.0, "", section(0.0, "", lane(-1))) +
             road("1", 20.0, line(0.0, x, y, 0.0, 20.0), section(0.0, "", lane(-1, R"(<width a="2"/>)"))) +
             road("2", 20.0, line(0.0, x + 2e3, y, 0.0, 20.0), section(0.0, "", lane(-1, R"(<width a="2"/>)")))));
    const Pose2 start = section_of(zone, "1.0.-1").start();
    EXPECT_NEAR(section_of(zone, "2.0.-1").start().x_m, start.x_m + 2e3, 1e-6);
    EXPECT_EQ(logged(zone, Diagnostic::Kind::notice, "file", "moved by"), start.x_m != x);
    return Point2{start.x_m, start.y_m + 1.0};
  };
  const auto expect_start = [&](double x, double y, Point2 expected) {
    EXPECT_LT(distance(start_of(x, y), expected), 1e-6) << x << ' ' << y;
  };
  expect_start(99'999.0, -99'999.0, {99'999.0, -99'999.0});
  expect_start(100'250.0, 500.0, {250.0, 500.0});
  expect_start(-100'250.0, -500.0, {750.0, 500.0});
  expect_start(1'500.0, 100'250.0, {500.0, 250.0});
}

TEST(OpenDriveName, is_the_header_s_without_control_characters_or_one_from_the_text) {
  const auto named = [](const std::string& name) {
    return zone_of("<OpenDRIVE><header name=\"" + name + "\"/>" +
                   road("1", 20.0, driven_line, section(0.0, "", lane(-1))) + "</OpenDRIVE>")
        .name;
  };
  EXPECT_EQ(named("Lab 3"), "Lab 3");
  EXPECT_EQ(named("a&#10;b"), "ab");
  EXPECT_EQ(named(std::string(70, 'n')), std::string(64, 'n'));
  const std::string made = named("");
  EXPECT_TRUE(made.starts_with("roads-")) << made;
  EXPECT_EQ(made.size(), 12U);
  EXPECT_TRUE(named("  ").starts_with("roads-"));
  EXPECT_NE(named("  "), made);
  EXPECT_EQ(named(""), made);
}

}  // namespace
}  // namespace cosiva::zone
