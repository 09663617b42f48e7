#include "cosiva/zone/opendrive/joints.h"

#include <gmock/gmock.h>

#include <cmath>
#include <string>
#include <vector>

#include "cosiva/zone/opendrive/test_tracks.h"

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

std::string width(double from_m, double to_m, double length_m) {
  return "<width a=\"" + std::to_string(from_m) + "\" b=\"" + std::to_string((to_m - from_m) / length_m) + "\"/>";
}

/// A road along x with its lane's centre on y = 0 at its end, and one that follows it, with its lane's centre on its
/// reference line at its begin. Both lanes are joined.
struct JoinedPair {
  double length_m{20.0};
  double width_m{3.0};  ///< at the end
  Pose2 second{20.0, 0.0, 0.0};
  double second_length_m{20.0};
  double second_width_m{3.0};  ///< at the begin

  [[nodiscard]] FoundTracks joined() const {
    const auto lanes = [](double offset, double slope, const std::string& lane_widths) {
      return "<laneOffset a=\"" + std::to_string(offset) + "\" b=\"" + std::to_string(slope) + "\"/>" +
             section(0.0, "", lane_to(-1, R"(<successor id="-1"/>)", lane_widths));
    };
    // Lanes are 3 m wide at the other ends; half the width is the offset from the lane's left border.
    const double offset_slope = 0.5 * (width_m - 3.0) / length_m;
    const double second_slope = 0.5 * (3.0 - second_width_m) / second_length_m;
    FoundTracks found = linked(
        file(road("1", length_m, line(0.0, 20.0 - length_m, 0.0, 0.0, length_m),
                  lanes(1.5, offset_slope, width(3.0, width_m, length_m)), road_link("successor", "2", "start")) +
             road("2", second_length_m, line(0.0, second.x_m, second.y_m, second.heading_rad, second_length_m),
                  lanes(0.5 * second_width_m, second_slope, width(second_width_m, 3.0, second_length_m)))));
    EXPECT_THAT(found.diagnostics(), IsEmpty());
    join_tracks(found.network, found.tracks, found.report);
    return found;
  }
};

void expect_pose(const Pose2& found, const Pose2& expected) {
  EXPECT_NEAR(found.x_m, expected.x_m, 1e-9);
  EXPECT_NEAR(found.y_m, expected.y_m, 1e-9);
  EXPECT_NEAR(found.heading_rad, expected.heading_rad, 1e-9);
}

/// Where the ends meet; both must.
Pose2 meeting(const FoundTracks& found) {
  expect_pose(found.track("2.0.-1").curve.entry(), found.track("1.0.-1").curve.exit());
  EXPECT_THAT(found.next("1.0.-1"), ElementsAre("2.0.-1"));
  return found.track("1.0.-1").curve.exit();
}

TEST(JoinTracks, meet_halfway_between_lanes_of_one_width) {
  const FoundTracks found = JoinedPair{.second = {20.04, 0.08, 0.05}}.joined();
  expect_pose(meeting(found), {20.02, 0.04, 0.025});
  // The other ends stay.
  expect_pose(found.track("1.0.-1").curve.entry(), {0.0, 0.0, 0.0});
  expect_pose(found.track("2.0.-1").curve.exit(), {20.04 + 20.0 * std::cos(0.05), 0.08 + 20.0 * std::sin(0.05), 0.05});
  // Half the distance is 44.7 mm. Half the kink needs 160 m a radian.
  EXPECT_THAT(
      found.diagnostics(),
      ElementsAre("mended|lane '1.0.-1'|its end is moved by 44.72 mm and 0.025000 rad, over 4.00 m, to meet the "
                  "lanes linked to it",
                  "mended|lane '2.0.-1'|its beginning is moved by 44.72 mm and -0.025000 rad, over 4.00 m, to "
                  "meet the lanes linked to it"));
}

TEST(JoinTracks, meet_nearer_to_the_wider_lane_by_the_square_of_the_widths) {
  expect_pose(meeting(JoinedPair{.width_m = 2.0, .second = {20.1, -0.2, -0.05}, .second_width_m = 4.0}.joined()),
              {20.08, -0.16, -0.04});
  expect_pose(meeting(JoinedPair{.width_m = 4.0, .second = {20.1, -0.2, -0.05}, .second_width_m = 2.0}.joined()),
              {20.02, -0.04, -0.01});
  // A lane that begins without width begins at its neighbour's edge, and two such ends meet halfway.
  expect_pose(meeting(JoinedPair{.second = {20.0, 0.5, 0.0}, .second_width_m = 0.0}.joined()), {20.0, 0.0, 0.0});
  expect_pose(meeting(JoinedPair{.width_m = 0.0, .second = {20.0, 0.5, 0.0}, .second_width_m = 0.0}.joined()),
              {20.0, 0.25, 0.0});
}

TEST(JoinTracks, meet_at_a_lane_of_less_than_a_metre_as_if_it_were_ten_times_as_wide) {
  expect_pose(meeting(JoinedPair{.second = {20.0, 0.101, 0.0}, .second_length_m = 0.99}.joined()), {20.0, 0.1, 0.0});
  expect_pose(meeting(JoinedPair{.second = {20.0, 0.101, 0.0}, .second_length_m = 1.0}.joined()), {20.0, 0.0505, 0.0});
  expect_pose(meeting(JoinedPair{.length_m = 0.99, .second = {20.0, 0.101, 0.0}}.joined()), {20.0, 0.001, 0.0});
}

TEST(JoinTracks, correct_a_gap_or_a_kink_alone) {
  const FoundTracks gap = JoinedPair{.second = {20.0, 0.2, 0.0}}.joined();
  expect_pose(meeting(gap), {20.0, 0.1, 0.0});
  EXPECT_THAT(
      gap.diagnostics(),
      ElementsAre("mended|lane '1.0.-1'|its end is moved by 0.10 m and 0.000000 rad, over 5.00 m, to meet the "
                  "lanes linked to it",
                  "mended|lane '2.0.-1'|its beginning is moved by 0.10 m and 0.000000 rad, over 5.00 m, to meet "
                  "the lanes linked to it"));
  const FoundTracks kink = JoinedPair{.second = {20.0, 0.0, -0.04}}.joined();
  expect_pose(meeting(kink), {20.0, 0.0, -0.02});
  EXPECT_EQ(kink.diagnostics().size(), 2U);
  // No further than the lane is long.
  const FoundTracks far = JoinedPair{.length_m = 10.0, .second = {20.0, 1.0, 0.0}}.joined();
  EXPECT_THAT(
      far.diagnostics(),
      ElementsAre("mended|lane '1.0.-1'|its end is moved by 0.50 m and 0.000000 rad, over 10.00 m, to meet the "
                  "lanes linked to it",
                  "mended|lane '2.0.-1'|its beginning is moved by 0.50 m and 0.000000 rad, over 15.00 m, to meet "
                  "the lanes linked to it"));
  // A small correction needs no diagnostic.
  const FoundTracks small = JoinedPair{.second = {20.0, 0.0018, 0.0018}}.joined();
  expect_pose(meeting(small), {20.0, 0.0009, 0.0009});
  EXPECT_THAT(small.diagnostics(), IsEmpty());
}

TEST(JoinTracks, leave_ends_that_nearly_meet) {
  const FoundTracks near = JoinedPair{.second = {20.0, 4e-6, 1e-5}}.joined();
  expect_pose(near.track("1.0.-1").curve.exit(), {20.0, 0.0, 0.0});
  expect_pose(near.track("2.0.-1").curve.entry(), {20.0, 4e-6, 1e-5});
  expect_pose(meeting(JoinedPair{.second = {20.0, 6e-6, 0.0}}.joined()), {20.0, 3e-6, 0.0});
  expect_pose(meeting(JoinedPair{.second = {20.0, 0.0, 3e-5}}.joined()), {20.0, 0.0, 1.5e-5});
}

TEST(JoinTracks, part_ends_more_than_two_metres_or_a_quarter_of_the_moved_lane_or_0_8_rad_apart) {
  const auto parted = [](const JoinedPair& pair) {
    const FoundTracks found = pair.joined();
    return found.next("1.0.-1").empty();
  };
  EXPECT_FALSE(parted({.second = {21.999, 0.0, 0.0}}));
  EXPECT_TRUE(parted({.second = {22.001, 0.0, 0.0}}));
  EXPECT_FALSE(parted({.second = {20.0, 0.0, 0.79}}));
  EXPECT_FALSE(parted({.second = {20.0, 0.0, -0.79}}));
  EXPECT_TRUE(parted({.second = {20.0, 0.0, 0.81}}));
  EXPECT_TRUE(parted({.second = {20.0, 0.0, -0.81}}));
  // The second lane is moved, unless the first is narrower.
  EXPECT_FALSE(parted({.second = {20.0, 0.99, 0.0}, .second_length_m = 4.0}));
  EXPECT_TRUE(parted({.second = {20.0, 1.01, 0.0}, .second_length_m = 4.0}));
  EXPECT_FALSE(parted({.length_m = 4.0, .second = {20.0, 1.01, 0.0}}));
  EXPECT_TRUE(parted({.length_m = 4.0, .width_m = 2.0, .second = {20.0, 1.01, 0.0}}));
  EXPECT_FALSE(parted({.length_m = 4.0, .width_m = 2.0, .second = {20.0, 0.99, 0.0}}));
  EXPECT_FALSE(parted({.width_m = 2.0, .second = {20.0, 1.01, 0.0}, .second_length_m = 4.0}));
  const FoundTracks found = JoinedPair{.second = {20.0, 3.0, 0.25}}.joined();
  EXPECT_THAT(
      found.diagnostics(),
      ElementsAre("lost|lane '1.0.-1'|its successor '2.0.-1' begins 3.00 m and 0.250000 rad from where it ends, "
                  "too much to bend: they are not joined"));
  expect_pose(found.track("1.0.-1").curve.exit(), {20.0, 0.0, 0.0});
  expect_pose(found.track("2.0.-1").curve.entry(), {20.0, 3.0, 0.25});
}

// Two lanes part: all three ends move to one position, each weighing the same.
TEST(JoinTracks, meet_all_at_once_where_lanes_part) {
  const std::string lanes = "<laneOffset a=\"1.5\"/>" + section(0.0, "", lane_to(-1, R"(<successor id="-1"/>)"));
  const std::string begin = "<laneOffset a=\"1.5\"/>" + section(0.0, "", lane_to(-1, R"(<predecessor id="-1"/>)"));
  FoundTracks found =
      linked(file(road("1", 20.0, line(0.0, 0.0, 0.0, 0.0, 20.0), lanes, road_link("successor", "2", "start")) +
                  road("2", 20.0, line(0.0, 20.0, 0.3, 0.06, 20.0), begin) +
                  road("3", 20.0, line(0.0, 20.3, 0.0, -0.03, 20.0), begin, road_link("predecessor", "1", "end"))));
  join_tracks(found.network, found.tracks, found.report);
  for (const Pose2& pose :
       {found.track("1.0.-1").curve.exit(), found.track("2.0.-1").curve.entry(), found.track("3.0.-1").curve.entry()})
    expect_pose(pose, {20.1, 0.1, 0.01});
}

}  // namespace
}  // namespace cosiva::zone::opendrive
