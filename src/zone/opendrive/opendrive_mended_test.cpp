#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/zone/opendrive/test_files.h"

/// Typical faults of real files, or shapes that no vehicle could follow, and their repair.
namespace cosiva::zone {
namespace {

/// All sections of a lane, by their names: "1.0.-1", "1.0.-1.2", …
std::vector<const Section*> sections_of(const TrafficZone& zone, const std::string& lane) {
  std::vector<const Section*> all;
  for (SectionId id = 0; id < zone.circuit.size(); ++id) {
    const std::string& name = zone.circuit.part(id).name;
    if (name == lane || name.starts_with(lane + '.')) all.push_back(&zone.circuit.section(id));
  }
  return all;
}
double tightest_m(const std::vector<const Section*>& sections) {
  double bend = 0.0;
  for (const Section* section : sections) bend = std::max(bend, section->curvature_max_per_m());
  return 1.0 / bend;
}
double length_m(const std::vector<const Section*>& sections) {
  double total = 0.0;
  for (const Section* section : sections) total += section->length_m();
  return total;
}

TEST(OpenDriveMended, a_road_drawn_as_a_polygon_is_driven_round_its_corners) {
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 20.0) + line(20.0, 20.0, 0.0, -1.0, 20.0);
  const TrafficZone zone = zone_of(file(road("1", 40.0, plan, section(0.0, lane(1), lane(-1)))));
  for (const char* name : {"1.0.-1", "1.0.1"}) {
    const auto sections = sections_of(zone, name);
    ASSERT_FALSE(sections.empty()) << name;
    EXPECT_GT(tightest_m(sections), 1.0) << name;
    EXPECT_NEAR(length_m(sections), 40.0, 3.0) << name;
  }
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::mended, "road 1, planView/geometry[2]", "smoothed"));
}

TEST(OpenDriveMended, a_lane_inside_too_tight_a_bend_is_cut_short_instead_of_folding) {
  // The road turns right by a quarter, round 1 m; its right lane lies 1.5 m further in.
  const std::string bend = line(20.0, 20.0, 0.0, 0.0, 0.5 * pi, "<arc curvature=\"-1\"/>");
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 20.0) + bend + line(20.0 + 0.5 * pi, 21.0, -1.0, -0.5 * pi, 20.0);
  const TrafficZone zone = zone_of(file(road("1", 40.0 + 0.5 * pi, plan, section(0.0, lane(1), lane(-1)))));
  const auto inner = sections_of(zone, "1.0.-1");
  ASSERT_FALSE(inner.empty());
  EXPECT_GT(tightest_m(inner), 1.0);
  EXPECT_NEAR(inner.front()->start().y_m, -1.5, 1e-6);
  EXPECT_NEAR(inner.back()->end().x_m, 19.5, 1e-6);
  EXPECT_NEAR(inner.back()->end().y_m, -21.0, 1e-5);
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::mended, "lane -1", "run backwards"));
  // The outer lane has room enough, and stays an arc.
  EXPECT_NEAR(length_m(sections_of(zone, "1.0.1")), 40.0 + 2.5 * 0.5 * pi, 0.02);
  EXPECT_FALSE(logged(zone, Diagnostic::Kind::mended, "lane 1", "run backwards"));
}

TEST(OpenDriveMended, a_lane_at_an_angle_to_its_road_has_no_corner_where_the_road_begins_to_bend) {
  // The lane widens by a fifth of its length, and lies at four fifths of the bend's radius.
  const std::string bend = line(20.0, 20.0, 0.0, 0.0, 5.0 * pi, "<arc curvature=\"0.1\"/>");
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 20.0) + bend;
  const std::string lanes = section(0.0, lane(1, R"(<width a="12" b="0.2"/>)"), "");
  const TrafficZone zone = zone_of(file(road("1", 20.0 + 5.0 * pi, plan, lanes)));
  const auto sections = sections_of(zone, "1.0.1");
  ASSERT_FALSE(sections.empty());
  EXPECT_GT(tightest_m(sections), 0.15);
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::mended, "lane 1", "would kink or run backwards"));
}

TEST(OpenDriveMended, a_link_to_the_wrong_end_of_a_road_is_corrected) {
  // Road 2 runs towards road 1, and its end lies there; the link names its start.
  const std::string one = road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0),
                               section(0.0, "", lane(-1, R"(<link><successor id="1"/></link><width a="3"/>)")),
                               R"(<link><successor elementType="road" elementId="2" contactPoint="start"/></link>)");
  const std::string two = road("2", 20.0, line(0.0, 40.0, 0.0, pi, 20.0), section(0.0, lane(1), ""));
  const TrafficZone zone = zone_of(file(one + two));
  EXPECT_TRUE(leads(zone, "1.0.-1", "2.0.1"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::mended, "road 1, link/successor", "its other end is only"));
}

TEST(OpenDriveMended, a_lane_lies_on_the_side_of_its_id_wherever_it_is_written) {
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 20.0);
  const TrafficZone zone = zone_of(file(road("5", 20.0, plan, section(0.0, lane(-1), lane(0) + lane(1)))));
  EXPECT_NEAR(section_of(zone, "5.0.-1").start().y_m, -1.5, 1e-12);
  EXPECT_NEAR(section_of(zone, "5.0.1").start().y_m, 1.5, 1e-12);
  EXPECT_TRUE(
      logged(zone, Diagnostic::Kind::mended, "road 5, lanes/laneSection/left/lane[-1]", "right of the reference line"));
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::lost, "road 5, lanes/laneSection/right/lane[0]", "centre line"));
  EXPECT_EQ(zone.circuit.size(), 2U);
}

TEST(OpenDriveMended, a_width_that_jumps_in_a_tiny_record_is_smoothed_next_to_it) {
  const std::string widths =
      R"(<width sOffset="0" a="3"/><width sOffset="20" a="3.1"/><width sOffset="20.08" a="3.2"/>)";
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 40.0);
  const TrafficZone zone = zone_of(file(road("1", 40.0, plan, section(0.0, "", lane(-1, widths)))));
  const auto sections = sections_of(zone, "1.0.-1");
  ASSERT_FALSE(sections.empty());
  EXPECT_GT(tightest_m(sections), 2.0);
  EXPECT_NEAR(sections.back()->end().y_m, -1.6, 1e-6);
}

TEST(OpenDriveMended, a_very_short_lane_stays_and_its_neighbours_come_to_it) {
  const std::string lanes = section(0.0, "", lane(-1, R"(<link><successor id="-1"/></link><width a="3"/>)"));
  const auto to = [](const char* road) {
    return std::string(R"(<link><successor elementType="road" elementId=")") + road +
           R"(" contactPoint="start"/></link>)";
  };
  const TrafficZone zone = zone_of(file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), lanes, to("2")) +
                                        road("2", 0.4, line(0.0, 20.0, 0.08, 0.0, 0.4), lanes, to("3")) +
                                        road("3", 20.0, line(0.0, 20.4, 0.16, 0.0, 20.0), section(0.0, "", lane(-1)))));
  EXPECT_TRUE(leads(zone, "2.0.-1", "3.0.-1") || zone.circuit.find("2.0.-1.2"));
  EXPECT_NEAR(section_of(zone, "2.0.-1").start().y_m, 0.08 - 1.5, 2e-3);
  EXPECT_GT(tightest_m(sections_of(zone, "2.0.-1")), 1.0);
}

TEST(OpenDriveMended, lanes_that_meet_at_an_angle_are_bent_to_each_other) {
  const std::string lanes = section(0.0, "", lane(-1, R"(<link><successor id="-1"/></link><width a="3"/>)"));
  const std::string one = road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), lanes,
                               R"(<link><successor elementType="road" elementId="2" contactPoint="start"/></link>)");
  const std::string two = road("2", 20.0, line(0.0, 20.0, 0.0, 0.5, 20.0), section(0.0, "", lane(-1)));
  const TrafficZone zone = zone_of(file(one + two));
  const auto first = sections_of(zone, "1.0.-1");
  EXPECT_FALSE(zone.circuit.next(*zone.circuit.find("1.0.-1")).empty());
  EXPECT_GT(tightest_m(first), 2.0);
  const auto second = sections_of(zone, "2.0.-1");
  EXPECT_LT(distance(first.back()->end(), second.front()->start()), 1e-6);
  EXPECT_TRUE(logged(zone, Diagnostic::Kind::mended, "lane '1.0.-1'", "to meet the lanes linked to it"));
}

TEST(OpenDriveMended, a_byte_order_mark_and_the_line_ends_of_another_system_are_no_fault) {
  std::string text = file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), section(0.0, "", lane(-1))));
  std::string crlf = "\xEF\xBB\xBF";
  std::string wide = "\xFF\xFE";
  for (const char c : text) {
    crlf += c == '\n' ? std::string("\r\n") : std::string(1, c);
    wide += {c, '\0'};
  }
  EXPECT_EQ(zone_of(crlf).circuit.size(), 1U);
  EXPECT_EQ(zone_of(wide).circuit.size(), 1U);
  // The location is still reported, by line where lines can be counted.
  EXPECT_THAT(to_string(read(crlf + "<a").error()), ::testing::HasSubstr("test.xodr:4"));
}

}  // namespace
}  // namespace cosiva::zone
