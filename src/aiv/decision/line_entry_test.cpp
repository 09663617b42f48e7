#include "cosiva/aiv/decision/line_entry.h"

#include <gtest/gtest.h>

#include "cosiva/base/math.h"

namespace cosiva::aiv {
namespace {

// 0.20 m by 0.12 m: a corner is 0.1166 m from the middle.
constexpr zone::VehicleShape shape{};
constexpr double quarter_rad = 0.5 * pi;

bool near_body(const LineEntry& entry, const Pose2& X_MB, double clear_m = entry_clear_m) {
  EntrySweep sweep{shape};
  sweep.take(entry);
  return sweep.near_body(X_MB, clear_m);
}

TEST(LineEntry, sweeps_a_body_wide_strip_on_its_straight_and_its_corners_where_it_turns) {
  // Turns left by 90°, drives 0.3 m north, turns back.
  const LineEntry entry{{0, 0, 0}, {0, 0.3, 0}};
  EXPECT_TRUE(near_body(entry, {0.0, 0.45, 0.0})) << "ahead of where it ends";
  EXPECT_FALSE(near_body(entry, {0.0, 0.55, 0.0}));
  // Beside the straight 0.06 m of it, 0.06 m of the other and what stays free: as it turns, a corner comes further.
  EXPECT_TRUE(near_body(entry, {0.12, 0.15, quarter_rad}));
  EXPECT_FALSE(near_body(entry, {0.21, 0.15, quarter_rad}));
  EXPECT_FALSE(near_body({{0, 0, quarter_rad}, {0, 0.3, quarter_rad}}, {0.145, 0.15, quarter_rad}))
      << "who need not turn needs less room";
  EXPECT_TRUE(near_body({{0, 0, 0}, {0, 0.3, 0}}, {0.145, 0.0, quarter_rad}));
}

TEST(LineEntry, takes_more_room_when_more_is_to_stay_free) {
  const LineEntry entry{{0, 0, quarter_rad}, {0, 0.3, quarter_rad}};
  const Pose2 other{0.15, 0.15, quarter_rad};  // 0.03 m between the sides
  EXPECT_FALSE(near_body(entry, other, 0.02));
  EXPECT_TRUE(near_body(entry, other, 0.04));
}

TEST(LineEntry, counts_both_ways_round_where_it_has_the_line_behind_it_or_under_it) {
  // A foot just left of straight behind: it turns left, or, where reports are a little wrong, right.
  const Pose2 south_east{0.13, -0.13, 0.25 * pi};
  const Pose2 north_east{0.13, 0.13, -0.25 * pi};
  const LineEntry behind{{0, 0, 0}, {-0.25, 0.01, pi}};
  EXPECT_EQ(near_body(behind, south_east), near_body(behind, north_east));
  // At a stop line: 0.115 m from the middle, which a corner of one that turns here reaches.
  const Pose2 at_stop_line{0.0, -0.215, quarter_rad};
  EXPECT_TRUE(near_body({{0, 0, 0}, {0, -0.01, 0}}, at_stop_line));
  EXPECT_FALSE(near_body({{0, 0, 0}, {0.3, 0, 0}}, at_stop_line)) << "straight ahead no corner comes there";
}

TEST(LineEntry, sweeps_over_points_and_less_of_them_the_further_it_has_come) {
  // Turns left, drives 0.3 m north, turns back.
  const LineEntry entry{{0, 0, 0}, {0, 0.3, 0}};
  EntrySweep sweep{shape};
  sweep.take(entry);
  EXPECT_TRUE(sweep.over({0.095, 0.0})) << "its front, before it has turned";
  EXPECT_TRUE(sweep.over({0.05, 0.35}));
  EXPECT_FALSE(sweep.over({-0.08, 0.08})) << "behind a corner that leaves";
  EXPECT_FALSE(sweep.over({0.0, 0.42}));
  sweep.take_rest(entry, {0, 0.1, quarter_rad});
  EXPECT_FALSE(sweep.over({0.095, 0.0})) << "that lies behind it now";
  EXPECT_TRUE(sweep.over({0.05, 0.35}));
}

TEST(LineEntry, tells_what_lies_ahead_of_a_front_from_what_lies_beside) {
  EXPECT_TRUE(lies_ahead(shape, {0, 0, 0}, {0.25, 0.5, quarter_rad})) << "from 0.19 m on, be it far to the side";
  EXPECT_FALSE(lies_ahead(shape, {0, 0, 0}, {0.03, 0.2, quarter_rad}));
  EXPECT_FALSE(lies_ahead(shape, {0, 0, pi}, {0.25, 0.0, 0.0}));
  EXPECT_TRUE(near_bodies(shape, {0, 0, 0}, {0.0, 0.14, 0.0}, 0.03));
  EXPECT_FALSE(near_bodies(shape, {0, 0, 0}, {0.0, 0.14, 0.0}, 0.01));
}

TEST(LineEntry, of_two_keeps_their_ways_a_diagonal_apart) {
  const LineEntry entry{{0, 0, 0}, {0, 0.3, 0}};
  EXPECT_TRUE(near_entry(entry, shape, {{0.2, 0.1, 0}, {0.2, 0.4, 0}}));
  EXPECT_TRUE(near_entry(entry, shape, {{-0.3, 0.15, 0}, {0.3, 0.15, 0}})) << "ways that cross";
  EXPECT_FALSE(near_entry(entry, shape, {{0.3, 0.1, 0}, {0.3, 0.4, 0}}));
}

}  // namespace
}  // namespace cosiva::aiv
