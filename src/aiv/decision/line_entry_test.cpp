#include "cosiva/aiv/decision/line_entry.h"

#include <gtest/gtest.h>

#include "cosiva/base/math.h"

namespace cosiva::aiv {
namespace {

// 0.20 m by 0.12 m: a corner is 0.1166 m from the body origin.
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
  EXPECT_TRUE(near_body(entry, {0.0, 0.45, 0.0})) << "ahead of the end of the entry";
  EXPECT_FALSE(near_body(entry, {0.0, 0.55, 0.0}));
  // Next to the straight: 0.06 m of either body and the clearance; during the turn a corner reaches further.
  EXPECT_TRUE(near_body(entry, {0.12, 0.15, quarter_rad}));
  EXPECT_FALSE(near_body(entry, {0.21, 0.15, quarter_rad}));
  EXPECT_FALSE(near_body({{0, 0, quarter_rad}, {0, 0.3, quarter_rad}}, {0.145, 0.15, quarter_rad}))
      << "without turns less space is needed";
  EXPECT_TRUE(near_body({{0, 0, 0}, {0, 0.3, 0}}, {0.145, 0.0, quarter_rad}));
}

TEST(LineEntry, takes_more_space_with_more_clearance) {
  const LineEntry entry{{0, 0, quarter_rad}, {0, 0.3, quarter_rad}};
  const Pose2 other{0.15, 0.15, quarter_rad};  // 0.03 m between the sides
  EXPECT_FALSE(near_body(entry, other, 0.02));
  EXPECT_TRUE(near_body(entry, other, 0.04));
}

TEST(LineEntry, counts_both_turn_directions_where_the_path_is_behind_or_under_the_vehicle) {
  // A foot just left of straight behind: the vehicle turns left or, with a small error of the report, right.
  const Pose2 south_east{0.13, -0.13, 0.25 * pi};
  const Pose2 north_east{0.13, 0.13, -0.25 * pi};
  const LineEntry behind{{0, 0, 0}, {-0.25, 0.01, pi}};
  EXPECT_EQ(near_body(behind, south_east), near_body(behind, north_east));
  // At a stop line: 0.115 m from the body origin, within reach of a corner of a vehicle that turns here.
  const Pose2 at_stop_line{0.0, -0.215, quarter_rad};
  EXPECT_TRUE(near_body({{0, 0, 0}, {0, -0.01, 0}}, at_stop_line));
  EXPECT_FALSE(near_body({{0, 0, 0}, {0.3, 0, 0}}, at_stop_line)) << "without a turn no corner reaches there";
}

TEST(LineEntry, sweeps_over_fewer_points_the_further_it_has_come) {
  // Turns left, drives 0.3 m north, turns back.
  const LineEntry entry{{0, 0, 0}, {0, 0.3, 0}};
  EntrySweep sweep{shape};
  sweep.take(entry);
  EXPECT_TRUE(sweep.over({0.095, 0.0})) << "the front, before the turn";
  EXPECT_TRUE(sweep.over({0.05, 0.35}));
  EXPECT_FALSE(sweep.over({-0.08, 0.08})) << "behind a corner that turns away";
  EXPECT_FALSE(sweep.over({0.0, 0.42}));
  sweep.take_rest(entry, {0, 0.1, quarter_rad});
  EXPECT_FALSE(sweep.over({0.095, 0.0})) << "behind the vehicle now";
  EXPECT_TRUE(sweep.over({0.05, 0.35}));
}

TEST(LineEntry, distinguishes_bodies_before_a_front_from_bodies_next_to_it) {
  EXPECT_TRUE(lies_ahead(shape, {0, 0, 0}, {0.25, 0.5, quarter_rad})) << "from 0.19 m on, even far to the side";
  EXPECT_FALSE(lies_ahead(shape, {0, 0, 0}, {0.03, 0.2, quarter_rad}));
  EXPECT_FALSE(lies_ahead(shape, {0, 0, pi}, {0.25, 0.0, 0.0}));
  EXPECT_TRUE(near_bodies(shape, {0, 0, 0}, {0.0, 0.14, 0.0}, 0.03));
  EXPECT_FALSE(near_bodies(shape, {0, 0, 0}, {0.0, 0.14, 0.0}, 0.01));
}

TEST(LineEntry, keeps_the_paths_of_two_entries_a_diagonal_apart) {
  const LineEntry entry{{0, 0, 0}, {0, 0.3, 0}};
  EXPECT_TRUE(near_entry(entry, shape, {{0.2, 0.1, 0}, {0.2, 0.4, 0}}));
  EXPECT_TRUE(near_entry(entry, shape, {{-0.3, 0.15, 0}, {0.3, 0.15, 0}})) << "paths that cross";
  EXPECT_FALSE(near_entry(entry, shape, {{0.3, 0.1, 0}, {0.3, 0.4, 0}}));
}

}  // namespace
}  // namespace cosiva::aiv
