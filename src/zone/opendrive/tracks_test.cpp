#include "cosiva/zone/opendrive/tracks.h"

#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

#include "cosiva/zone/opendrive/test_tracks.h"

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

FoundTracks on_straight_road(const std::string& lanes, double length = 40.0, const std::string& attributes = {},
                             const std::string& more = {}) {
  return tracks_of(file(road("1", length, line(0.0, 0.0, 0.0, 0.0, length), lanes, more, attributes)));
}
std::vector<std::string> names_of(const FoundTracks& found) {
  std::vector<std::string> names;
  for (const Track& track : found.tracks.tracks) names.push_back(track.name(found.network));
  return names;
}
void expect_track_pose(const Pose2& found, const Pose2& expected) {
  EXPECT_NEAR(found.x_m, expected.x_m, 1e-9);
  EXPECT_NEAR(found.y_m, expected.y_m, 1e-9);
  EXPECT_NEAR(wrap_angle(found.heading_rad - expected.heading_rad), 0.0, 1e-9);
}

TEST(FindTracks, lie_side_by_side_in_the_order_of_road_section_and_lane) {
  const std::string lanes =
      section(0.0, lane(2, R"(<width a="2"/>)") + lane(1), lane(-1) + lane(-2, R"(<width a="1"/>)")) +
      section(10.0, "", lane(-1));
  const FoundTracks found =
      tracks_of(file(road("1", 40.0, line(0.0, 0.0, 0.0, 0.0, 40.0), lanes) +
                     road("0", 40.0, line(0.0, 0.0, 50.0, 0.0, 40.0), section(0.0, "", lane(-1)))));
  EXPECT_THAT(names_of(found), ElementsAre("1.0.-2", "1.0.-1", "1.0.1", "1.0.2", "1.1.-1", "0.0.-1"));
  const struct {
    const char* name;
    double y_m;
    double from_m;
    double to_m;
    double width_m;
  } all[] = {{"1.0.-2", -3.5, 0.0, 10.0, 1.0}, {"1.0.-1", -1.5, 0.0, 10.0, 3.0},  {"1.0.1", 1.5, 0.0, 10.0, 3.0},
             {"1.0.2", 4.0, 0.0, 10.0, 2.0},   {"1.1.-1", -1.5, 10.0, 40.0, 3.0}, {"0.0.-1", 48.5, 0.0, 40.0, 3.0}};
  for (const auto& [name, y_m, from_m, to_m, width_m] : all) {
    const Track& track = found.track(name);
    const bool forward = track.lane < 0;
    EXPECT_EQ(track.curve.forward(), forward) << name;
    EXPECT_EQ(track.curve.from(), from_m) << name;
    EXPECT_EQ(track.curve.to(), to_m) << name;
    EXPECT_EQ(track.curve.span(), to_m - from_m) << name;
    expect_track_pose(track.curve.entry(), {forward ? from_m : to_m, y_m, forward ? 0.0 : pi});
    expect_track_pose(track.curve.exit(), {forward ? to_m : from_m, y_m, forward ? 0.0 : pi});
    EXPECT_NEAR(track.width_entry, width_m, 1e-12) << name;
    EXPECT_NEAR(track.width_exit, width_m, 1e-12) << name;
    const TrackId id = found.tracks.find({track.road, track.section, track.lane, true});
    ASSERT_NE(id, no_track);
    EXPECT_EQ(found.tracks.tracks[id].name(found.network), name);
  }
  EXPECT_EQ(found.tracks.find({0, 0, -3, true}), no_track);
  EXPECT_EQ(found.tracks.find({0, 1, 1, true}), no_track);
  EXPECT_EQ(found.tracks.find({1, 0, -2, true}), no_track);
  EXPECT_EQ(found.tracks.find({7, 0, -1, true}), no_track);
  EXPECT_THAT(found.diagnostics(), IsEmpty());
}

// On the right side lanes run with s, on the left side against it; traffic that keeps left swaps that, and so does a
// reversed lane.
TEST(FindTracks, run_with_the_traffic) {
  const std::string reversed = R"(<lane id="-1" type="driving" direction="reversed"><width a="3"/></lane>)";
  for (const bool left_hand : {false, true}) {
    const std::string rule = left_hand ? "rule=\"LHT\"" : "";
    const FoundTracks plain = on_straight_road(section(0.0, lane(1), lane(-1)), 40.0, rule);
    EXPECT_EQ(plain.track("1.0.-1").curve.forward(), !left_hand);
    EXPECT_EQ(plain.track("1.0.1").curve.forward(), left_hand);
    EXPECT_EQ(on_straight_road(section(0.0, "", reversed), 40.0, rule).track("1.0.-1").curve.forward(), left_hand);
  }
}

TEST(FindTracks, have_the_widths_where_vehicles_enter_and_leave_them) {
  // From 2 m to 4 m over 40 m.
  const std::string widening = R"(<width a="2" b="0.05"/>)";
  const FoundTracks found = on_straight_road(section(0.0, lane(1, widening), lane(-1, widening)));
  EXPECT_NEAR(found.track("1.0.-1").width_entry, 2.0, 1e-12);
  EXPECT_NEAR(found.track("1.0.-1").width_exit, 4.0, 1e-12);
  EXPECT_NEAR(found.track("1.0.1").width_entry, 4.0, 1e-12);
  EXPECT_NEAR(found.track("1.0.1").width_exit, 2.0, 1e-12);
  expect_track_pose(found.track("1.0.-1").curve.pose_at(20.0), {20.0, -1.5, std::atan(-0.025)});
  expect_track_pose(found.track("1.0.1").curve.pose_at(20.0), {20.0, 1.5, std::atan(0.025) + pi});
}

TEST(FindTracks, take_a_border_from_the_centre_lane_whatever_its_sign) {
  // The second lane's border is measured from lane 0, not from the first lane. The offset moves all of them.
  const std::string lanes =
      R"(<laneOffset a="0.5"/>)" + section(0.0, lane(1, R"(<border a="2"/>)") + lane(2, R"(<border a="-5"/>)"),
                                           lane(-1, R"(<border a="2"/>)") + lane(-2, R"(<border a="-6"/>)"));
  const FoundTracks found = on_straight_road(lanes);
  const std::pair<const char*, double> all[] = {
      {"1.0.1", 0.5 + 1.0}, {"1.0.2", 0.5 + 3.5}, {"1.0.-1", 0.5 - 1.0}, {"1.0.-2", 0.5 - 4.0}};
  for (const auto& [name, y_m] : all) EXPECT_NEAR(found.track(name).curve.entry().y_m, y_m, 1e-12) << name;
  EXPECT_NEAR(found.track("1.0.2").width_entry, 3.0, 1e-12);
  EXPECT_NEAR(found.track("1.0.-2").width_exit, 4.0, 1e-12);
  // Without an offset before its first record, with widths as with borders.
  for (const char* inside : {R"(<border a="2"/>)", R"(<width a="2"/>)"}) {
    const FoundTracks late = on_straight_road(R"(<laneOffset s="20" a="0.5"/>)" + section(0.0, "", lane(-1, inside)));
    EXPECT_NEAR(late.track("1.0.-1").curve.entry().y_m, -1.0, 1e-12) << inside;
    EXPECT_NEAR(late.track("1.0.-1").curve.exit().y_m, -0.5, 1e-12) << inside;
  }
  // Widths take precedence over borders.
  EXPECT_NEAR(
      on_straight_road(section(0.0, "", lane(-1, R"(<width a="3"/><border a="-9"/>)"))).track("1.0.-1").width_exit, 3.0,
      1e-12);
  // The sign is that in the centre of the lane section: this border begins on the other side.
  const FoundTracks crossing = on_straight_road(section(0.0, "", lane(-1, R"(<border a="1" b="-0.2"/>)")));
  EXPECT_NEAR(crossing.track("1.0.-1").curve.exit().y_m, 0.5 * (1.0 - 8.0), 1e-12);
}

TEST(FindTracks, count_records_from_their_lane_section) {
  const std::string lanes =
      section(0.0, "", lane(-1)) +
      section(10.0, "", lane(-1, R"(<width sOffset="0" a="3"/><width sOffset="20" a="3" b="0.01"/>)"));
  const FoundTracks found = on_straight_road(lanes);
  EXPECT_NEAR(found.track("1.1.-1").width_entry, 3.0, 1e-12);
  EXPECT_NEAR(found.track("1.1.-1").width_exit, 3.1, 1e-12);
  EXPECT_NEAR(found.track("1.1.-1").curve.pose_at(10.0).y_m, -1.5, 1e-12);
  EXPECT_THAT(found.diagnostics(), IsEmpty());
  const std::string here = "road 1, laneSection[1], lane -1|";
  EXPECT_THAT(on_straight_road(section(0.0, "", lane(-1, R"(<width sOffset="0.04" a="3"/>)"))).diagnostics(),
              IsEmpty());
  EXPECT_THAT(
      on_straight_road(section(0.0, "", lane(-1, R"(<width sOffset="0.06" a="3"/>)"))).diagnostics(),
      ElementsAre("mended|" + here + "has no width in its first 60.00 mm; the first width after that is used there"));
  // The first record is the one with the least offset.
  EXPECT_THAT(
      on_straight_road(section(0.0, "", lane(-1, R"(<width sOffset="9" a="3"/><width sOffset="0.5" a="3"/>)")))
          .diagnostics(),
      ElementsAre("mended|" + here + "has no width in its first 0.50 m; the first width after that is used there"));
}

TEST(FindTracks, are_at_least_a_centimetre_wide_somewhere) {
  const auto is_found = [](const std::string& widths) {
    const FoundTracks found = on_straight_road(section(0.0, "", lane(-1, widths)));
    if (found.tracks.tracks.empty()) {
      EXPECT_THAT(found.diagnostics(),
                  ElementsAre("lost|road 1, laneSection[1], lane -1|has no width, and is not taken"));
    }
    return !found.tracks.tracks.empty();
  };
  EXPECT_TRUE(is_found(R"(<width a="0.011"/>)"));
  EXPECT_FALSE(is_found(R"(<width a="0.009"/>)"));
  EXPECT_FALSE(is_found(R"(<width a="-3"/>)"));
  EXPECT_FALSE(is_found(""));
  EXPECT_TRUE(is_found(R"(<width a="0" b="0.001"/>)"));  // 4 cm at the end
  EXPECT_TRUE(is_found(R"(<width a="0.04" b="-0.001"/>)"));
  EXPECT_TRUE(is_found(R"(<width sOffset="0" a="0"/><width sOffset="35" a="0" b="0.01"/>)"));
  // A bump of 10 m at a quarter of the lane.
  EXPECT_TRUE(is_found(R"(<width a="0"/><width sOffset="6" b="0.4" c="-0.04"/><width sOffset="16" a="0"/>)"));
}

TEST(FindTracks, of_other_lane_types_are_counted) {
  const FoundTracks found = on_straight_road(
      section(0.0, lane(1, R"(<width a="2"/>)", "sidewalk"),
              lane(-1, R"(<width a="1"/>)", "border") + lane(-2) + lane(-3, R"(<width a="1"/>)", "border")));
  EXPECT_THAT(names_of(found), ElementsAre("1.0.-2"));
  EXPECT_NEAR(found.track("1.0.-2").curve.entry().y_m, -2.5, 1e-12);
  EXPECT_EQ(found.report.counted("lane type border"), 2U);
  EXPECT_EQ(found.report.counted("lane type sidewalk"), 1U);
  EXPECT_EQ(found.report.counted("lane type driving"), 0U);
  EXPECT_THAT(
      on_straight_road(section(0.0, "", lane(-1, R"(<width a="3"/>)", "bidirectional"))).diagnostics(),
      ElementsAre("lost|road 1, laneSection[1], lane -1|is driven both ways in the file; here only in the direction of "
                  "its side"));
}

TEST(FindTracks, are_smoothed_where_widths_jump_or_kink_and_lost_where_they_jump_far) {
  const std::string here = "road 1, laneSection[1], lane -1|";
  const auto found = [](const std::string& second) {
    return on_straight_road(section(0.0, "", lane(-1, R"(<width a="3"/><width sOffset="20" )" + second + "/>")));
  };
  EXPECT_THAT(
      found(R"(a="3.5")").diagnostics(),
      ElementsAre("mended|" + here +
                  "its centre line jumps sideways by up to 0.25 m and kinks by up to 0.000000 rad where records "
                  "of width or offset meet; smoothed"));
  EXPECT_THAT(found(R"(a="3" b="0.03")").diagnostics(),
              ElementsAre("mended|" + here +
                          "its centre line jumps sideways by up to 0.0000 mm and kinks by up to 0.015000 rad where "
                          "records of width or offset meet; smoothed"));
  EXPECT_THAT(found(R"(a="3.00018" b="0.018")").diagnostics(), IsEmpty());
  const FoundTracks far = found(R"(a="8")");
  EXPECT_THAT(far.tracks.tracks, IsEmpty());
  EXPECT_THAT(far.diagnostics(),
              ElementsAre("lost|" + here + "jumps sideways further than can be smoothed, and is not taken"));
}

TEST(FindTracks, of_lane_sections_out_of_order_or_without_length_are_left_out) {
  const FoundTracks found =
      on_straight_road(section(0.0, "", lane(-1)) + section(20.0, "", lane(-1)) + section(10.0, "", lane(-1)));
  EXPECT_THAT(names_of(found), ElementsAre("1.0.-1", "1.2.-1"));
  EXPECT_EQ(found.track("1.2.-1").curve.from(), 10.0);
  EXPECT_EQ(found.track("1.2.-1").curve.to(), 40.0);
  EXPECT_THAT(found.diagnostics(),
              ElementsAre("mended|road 1, laneSection[2], lane 0|has no length here, and its lanes are not taken",
                          "mended|road 1|its lane sections do not follow each other; the one that begins too early is "
                          "left out"));
  // Beyond the end of the road.
  const FoundTracks beyond = on_straight_road(section(0.0, "", lane(-1)) + section(41.0, "", lane(-1)));
  EXPECT_THAT(names_of(beyond), ElementsAre("1.0.-1"));
  EXPECT_EQ(beyond.track("1.0.-1").curve.to(), 40.0);
  EXPECT_THAT(beyond.diagnostics(),
              ElementsAre("mended|road 1, laneSection[2], lane 0|has no length here, and its lanes are not taken"));
}

TEST(FindTracks, begin_with_the_plan_view_if_the_first_lane_section_nearly_does) {
  const auto from = [](double section_s) {
    const FoundTracks found =
        tracks_of(file(road("1", 40.0, line(5.0, 0.0, 0.0, 0.0, 35.0), section(section_s, "", lane(-1)))));
    return found.track("1.0.-1").curve.from();
  };
  EXPECT_EQ(from(5.0), 5.0);
  EXPECT_EQ(from(5.009), 5.0);
  EXPECT_EQ(from(0.0), 5.0);
  EXPECT_EQ(from(5.02), 5.02);
}

TEST(FindTracks, have_the_lane_s_limits_instead_of_the_road_s_from_where_these_begin) {
  const std::string types = R"(<type s="30"><speed max="9"/></type><type s="0"><speed max="20"/></type>
                               <type s="5"><speed max="15"/></type><type s="12"><speed max="11"/></type>)";
  const std::string limits = R"(<width a="3"/><speed sOffset="8" max="no limit"/><speed sOffset="2" max="7"/>)";
  const FoundTracks found =
      on_straight_road(section(0.0, lane(1), "") + section(10.0, "", lane(-1, limits)), 40.0, {}, types);
  const auto speeds = [&](const char* name) {
    std::vector<std::pair<double, double>> all;
    for (const SpeedFrom& from : found.track(name).speeds) all.emplace_back(from.s, from.mps.value_or(0.0));
    return all;
  };
  using ::testing::Pair;
  EXPECT_THAT(speeds("1.0.1"), ElementsAre(Pair(0.0, 20.0), Pair(5.0, 15.0), Pair(12.0, 11.0), Pair(30.0, 9.0)));
  EXPECT_THAT(speeds("1.1.-1"), ElementsAre(Pair(0.0, 20.0), Pair(5.0, 15.0), Pair(12.0, 7.0), Pair(18.0, 0.0)));
}

TEST(FindTracks, of_roads_without_lanes_or_without_a_plan_view_are_none) {
  const FoundTracks found = tracks_of(
      file(road("1", 40.0, line(0.0, 0.0, 0.0, 0.0, 40.0), "") + road("2", 40.0, "", section(0.0, "", lane(-1))) +
           road("3", 40.0, line(0.0, 0.0, 0.0, 0.0, 40.0), section(0.0, "", lane(-1)))));
  EXPECT_THAT(names_of(found), ElementsAre("3.0.-1"));
  ASSERT_EQ(found.tracks.lines.size(), 3U);
  EXPECT_FALSE(found.tracks.lines[0] || found.tracks.lines[1]);
  EXPECT_TRUE(found.tracks.lines[2]);
  EXPECT_THAT(found.diagnostics(),
              ElementsAre("lost|road 1|has no lane section", "lost|road 2|has no plan view of any length"));
}

TEST(FindTracks, report_how_much_of_a_folding_lane_is_cut) {
  const std::string bend = line(20.0, 20.0, 0.0, 0.0, 0.5 * pi, "<arc curvature=\"-1\"/>");
  const std::string plan = line(0.0, 0.0, 0.0, 0.0, 20.0) + bend + line(20.0 + 0.5 * pi, 21.0, -1.0, -0.5 * pi, 20.0);
  FoundTracks found = tracks_of(file(road("1", 40.0 + 0.5 * pi, plan, section(0.0, lane(1), lane(-1)))));
  const auto all = found.diagnostics();
  ASSERT_EQ(all.size(), 1U);
  EXPECT_THAT(all[0], ::testing::StartsWith("mended|road 1, laneSection[1], lane -1|lies so far inside a bend"));
  // Both sides of the bend alike, and the bend itself: as much as the lane is redrawn for.
  const double cut_m = std::stod(all[0].substr(all[0].find("over ") + 5));
  EXPECT_GT(cut_m, 0.5 * pi + 2.0);
  EXPECT_LT(cut_m, 12.0);
}

}  // namespace
}  // namespace cosiva::zone::opendrive
