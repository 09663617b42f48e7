#include "cosiva/aiv/decision/line_entry.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/base/math.h"
#include "cosiva/base/random.h"

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

/// Whether a point of a body at A, `more_m` larger on all sides, lies in a body at B: all points of a grid of 4 mm.
bool bodies_overlap(const Pose2& X_MA, const Pose2& X_MB, double more_m) {
  const Pose2 X_BA = inverse(X_MB) * X_MA;
  const double half_length_m = 0.10 + more_m;
  const double half_width_m = 0.06 + more_m;
  constexpr int count = 64;
  for (int i = 0; i <= count; ++i) {
    for (int j = 0; j <= count; ++j) {
      const Point2 p_B = X_BA * Point2{half_length_m * (2.0 * i / count - 1.0), half_width_m * (2.0 * j / count - 1.0)};
      if (std::fabs(p_B.x_m) <= 0.10 && std::fabs(p_B.y_m) <= 0.06) return true;
    }
  }
  return false;
}

TEST(LineEntry, finds_two_bodies_near_exactly_where_the_larger_one_overlaps_the_other) {
  Random random{1, "bodies"};
  int near = 0;
  for (int i = 0; i < 400; ++i) {
    const Pose2 X_MA{random.uniform() - 0.5, random.uniform() - 0.5, wrap_angle(7.0 * random.uniform())};
    const double bearing_rad = 7.0 * random.uniform();
    const double away_m = 0.3 * random.uniform();
    const Pose2 X_MB{X_MA.x_m + away_m * std::cos(bearing_rad), X_MA.y_m + away_m * std::sin(bearing_rad),
                     wrap_angle(7.0 * random.uniform())};
    const double clear_m = 0.05 * random.uniform();
    // The grid may miss an overlap of a few millimetres.
    if (bodies_overlap(X_MA, X_MB, clear_m)) {
      EXPECT_TRUE(near_bodies(shape, X_MA, X_MB, clear_m)) << i;
      ++near;
    } else if (!bodies_overlap(X_MA, X_MB, clear_m + 0.005)) {
      EXPECT_FALSE(near_bodies(shape, X_MA, X_MB, clear_m)) << i;
    }
  }
  EXPECT_GT(near, 100);
  EXPECT_LT(near, 350);
}

TEST(LineEntry, has_a_body_before_its_front_as_far_as_the_body_s_nearest_corner) {
  for (const double turned_rad : {0.0, 0.4, 1.0, 0.5 * pi, 2.5, -0.7}) {
    const double reach_m = 0.10 * std::fabs(std::cos(turned_rad)) + 0.06 * std::fabs(std::sin(turned_rad));
    const Pose2 X_MA{0.3, -0.2, 1.1};
    for (const double more_m : {-0.001, 0.001}) {
      const Pose2 X_MB = X_MA * Pose2{0.10 - reach_m + more_m, 0.4, turned_rad};
      EXPECT_EQ(lies_ahead(shape, X_MA, X_MB), more_m > 0.0) << turned_rad;
    }
  }
}

TEST(LineEntry, measures_between_the_lines_of_two_entries) {
  // Two half diagonals and the clearance: 0.2533 m.
  const double near_m = norm(0.20, 0.12) + entry_clear_m;
  const auto entry = [](Point2 from, Point2 to) { return LineEntry{{from.x_m, from.y_m, 0.3}, {to.x_m, to.y_m, 1.0}}; };
  const LineEntry base = entry({0.0, 0.0}, {1.0, 0.0});
  for (const bool inside : {true, false}) {
    const double d = near_m + (inside ? -0.001 : 0.001);
    const double s = d * std::sqrt(0.5);
    for (const LineEntry& other : {entry({0.2, d}, {0.7, d}),          // parallel
                                   entry({0.5, -d}, {0.5, -2.0}),      // at right angles, from below
                                   entry({0.5, 2.0}, {0.5, d}),        // and from above
                                   entry({1.0 + d, 0.0}, {2.0, 0.0}),  // behind the end
                                   entry({-2.0, 0.0}, {-d, 0.0}),      // before the start
                                   entry({1.0 + s, s}, {1.5, 1.5}),    // off a corner
                                   entry({0.5, d}, {0.5, d}),          // a point
                                   entry({-s, -s}, {-s, -s})}) {       // a point off a corner
      EXPECT_EQ(near_entry(base, shape, other), inside) << other.from.x_m << " " << other.from.y_m;
      EXPECT_EQ(near_entry(other, shape, base), inside) << other.from.x_m << " " << other.from.y_m;
    }
  }
  // Lines that cross far from their ends, and lines that would cross beyond an end.
  EXPECT_TRUE(near_entry(base, shape, entry({0.5, -0.5}, {0.5, 0.5})));
  EXPECT_TRUE(near_entry(base, shape, entry({0.5, 0.5}, {0.5, -0.5})));
  EXPECT_FALSE(near_entry(base, shape, entry({1.5, -0.5}, {1.5, 0.5})));
  EXPECT_FALSE(near_entry(base, shape, entry({0.5, 0.3}, {0.5, 1.0})));
}

TEST(LineEntry, turns_in_any_direction_where_its_goal_is_within_three_centimetres) {
  // Straight on without a turn, a body next to the line is 0.18 m off; a turn needs half a diagonal and the clearance.
  const double turning_m = 0.5 * norm(0.20, 0.12) + entry_clear_m;
  const auto near = [](double goal_m, const Pose2& X_MB) { return near_body({{0, 0, 0}, {goal_m, 0, 0}}, X_MB); };
  EXPECT_TRUE(near(0.029, {0.0, 0.2, quarter_rad}));
  EXPECT_FALSE(near(0.031, {0.0, 0.2, quarter_rad}));
  for (const double more_m : {-0.001, 0.001}) {
    EXPECT_EQ(near(0.0, {0.0, 0.06 + turning_m + more_m, 0.0}), more_m < 0.0) << "before its side";
    EXPECT_EQ(near(0.0, {-0.10 - turning_m - more_m, 0.0, 0.0}), more_m < 0.0) << "before its end";
    const double s = (turning_m + more_m) * std::sqrt(0.5);
    EXPECT_EQ(near(0.0, {0.10 + s, 0.06 + s, 0.0}), more_m < 0.0) << "off its corner";
  }
}

TEST(LineEntry, sweeps_over_the_floor_under_its_body) {
  // Straight on by 0.3 m.
  const LineEntry entry{{0, 0, 0}, {0.3, 0, 0}};
  EntrySweep sweep{shape};
  sweep.take(entry);
  for (const double side : {-1.0, 1.0}) {
    EXPECT_TRUE(sweep.over({0.2, side * 0.059}));
    EXPECT_FALSE(sweep.over({0.2, side * 0.061}));
  }
  EXPECT_TRUE(sweep.over({0.399, 0.0}));
  EXPECT_FALSE(sweep.over({0.401, 0.0}));
  EXPECT_TRUE(sweep.over({-0.099, 0.0}));
  EXPECT_FALSE(sweep.over({-0.101, 0.0}));
  // What is behind a body that has come as far as 0.2 m.
  sweep.take_rest(entry, {0.2, 0.0, 0.0});
  EXPECT_FALSE(sweep.over({0.08, 0.0}));
  EXPECT_TRUE(sweep.over({0.11, 0.0}));
  EXPECT_TRUE(sweep.over({0.399, 0.0}));
  sweep.take_rest(entry, {0.3, 0.0, 0.0});
  EXPECT_FALSE(sweep.over({0.19, 0.0}));
  EXPECT_TRUE(sweep.over({0.21, 0.0}));
}

}  // namespace
}  // namespace cosiva::aiv
