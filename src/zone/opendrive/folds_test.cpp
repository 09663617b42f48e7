#include "cosiva/zone/opendrive/folds.h"

#include <gmock/gmock.h>

#include <cmath>

#include "cosiva/zone/opendrive/report.h"

namespace cosiva::zone::opendrive {
namespace {

using ::testing::IsEmpty;
using ::testing::SizeIs;

ReferenceLine line_along(std::vector<Geometry> plan, double length_m) {
  Road road;
  road.id = "1";
  road.length = length_m;
  road.plan = std::move(plan);
  Report report;
  auto line = ReferenceLine::make(road, report);
  EXPECT_TRUE(line);
  return *line;
}

TEST(LanePoint, next_to_a_straight_line_runs_along_it_and_has_all_room) {
  const ReferenceLine line = line_along({{0.0, {1.0, 2.0, 0.5 * pi}, 20.0, Clothoid{}, ""}}, 20.0);
  const LanePoint point = lane_point(line, *Lateral::make({{0.0, 3.0, 0.25}}, 20.0), 4.0);
  // North from (1, 2); left is west: 3 m, and a quarter of the 4 m.
  EXPECT_NEAR(point.p.x_m, 1.0 - 4.0, 1e-12);
  EXPECT_NEAR(point.p.y_m, 6.0, 1e-12);
  EXPECT_NEAR(point.d.x_m, -0.25, 1e-12);
  EXPECT_NEAR(point.d.y_m, 1.0, 1e-12);
  EXPECT_NEAR(point.room, 1.0, 1e-12);
  EXPECT_NEAR(point.along, 1.0, 1e-12);
  EXPECT_FALSE(point.folds());
}

// To the left of a left bend of 10 m the lane's circle is smaller by the offset: (10 − t)/10 of the length remains.
TEST(LanePoint, inside_a_bend_has_room_up_to_its_centre) {
  const ReferenceLine line = line_along({{0.0, {}, 15.0, Clothoid{0.1, 0.1}, ""}}, 15.0);
  for (const double t : {-5.0, 0.0, 3.0, 7.9, 8.1, 10.0, 12.0}) {
    const LanePoint point = lane_point(line, *Lateral::make({{0.0, t}}, 15.0), 6.0);
    EXPECT_NEAR(point.room, 1.0 - 0.1 * t, 1e-9) << t;
    EXPECT_NEAR(point.along, 1.0 - 0.1 * t, 1e-9) << t;
    EXPECT_NEAR(norm(point.d.x_m, point.d.y_m), std::fabs(1.0 - 0.1 * t), 1e-9) << t;
    EXPECT_NEAR(distance(point.p, {0.0, 10.0}), std::fabs(10.0 - t), 1e-9) << t;
    EXPECT_EQ(point.folds(), t > 8.0) << t;  // nearer to the centre than a fifth of the radius
  }
}

TEST(LanePoint, that_leads_across_its_road_folds) {
  const ReferenceLine line = line_along({{0.0, {}, 20.0, Clothoid{}, ""}}, 20.0);
  // Along is 0.3 of the length at a slope of 3.18.
  EXPECT_FALSE(lane_point(line, *Lateral::make({{0.0, 0.0, 3.1}}, 20.0), 1.0).folds());
  EXPECT_TRUE(lane_point(line, *Lateral::make({{0.0, 0.0, 3.3}}, 20.0), 1.0).folds());
}

TEST(Bridge, begins_and_ends_with_its_positions_and_derivatives) {
  const Bridge bridge{2.0, 6.0, {1.0, 2.0}, {4.0, 1.0}, {5.0, 3.0}, {2.0, -3.0}};
  EXPECT_EQ(bridge.at(2.0), (Point2{1.0, 2.0}));
  EXPECT_EQ(bridge.at(6.0), (Point2{5.0, 3.0}));
  // Derivatives are by u = 0 … 1; slopes by s, over 4 m.
  EXPECT_NEAR(bridge.slope_at(2.0).x_m, 1.0, 1e-12);
  EXPECT_NEAR(bridge.slope_at(2.0).y_m, 0.25, 1e-12);
  EXPECT_NEAR(bridge.slope_at(6.0).x_m, 0.5, 1e-12);
  EXPECT_NEAR(bridge.slope_at(6.0).y_m, -0.75, 1e-12);
  for (double s = 2.1; s < 6.0; s += 0.3) {
    EXPECT_NEAR((bridge.at(s + 1e-5).x_m - bridge.at(s - 1e-5).x_m) / 2e-5, bridge.slope_at(s).x_m, 1e-8) << s;
    EXPECT_NEAR((bridge.at(s + 1e-5).y_m - bridge.at(s - 1e-5).y_m) / 2e-5, bridge.slope_at(s).y_m, 1e-8) << s;
  }
  // At the centre: the mean of the ends, and an eighth of the derivatives' difference.
  EXPECT_NEAR(bridge.at(4.0).x_m, 3.0 + 0.125 * (4.0 - 2.0), 1e-12);
  EXPECT_NEAR(bridge.at(4.0).y_m, 2.5 + 0.125 * (1.0 + 3.0), 1e-12);
}

// A quarter of a circle of 2 m, as a cubic with the handles of Hermite's form.
TEST(Bridge, that_is_nearly_an_arc_is_as_tight_as_the_arc) {
  const double handle_m = 2.0 * 3.0 * 0.5522847498;
  const Bridge arc{0.0, pi, {0.0, 0.0}, {handle_m, 0.0}, {2.0, 2.0}, {0.0, handle_m}};
  EXPECT_NEAR(arc.tightest_m(), 2.0, 0.06);
  const Bridge straight{0.0, 5.0, {0.0, 0.0}, {5.0, 0.0}, {5.0, 0.0}, {5.0, 0.0}};
  EXPECT_EQ(straight.tightest_m(), 1e9);
}

TEST(BridgeFolds, are_none_where_no_lane_folds) {
  const ReferenceLine line = line_along({{0.0, {}, 20.0, Clothoid{0.1, 0.1}, ""}}, 20.0);
  std::size_t work = 10'000;
  EXPECT_THAT(bridge_folds(line, *Lateral::make({{0.0, 5.0}}, 20.0), 0.0, 20.0, work), IsEmpty());
  EXPECT_LT(work, 10'000U);
  EXPECT_GT(work, 9'800U);  // a sample at each quarter of a metre
}

// Straight on, a quarter to the right round 1 m, straight on: the right lane lies 1.5 m off, beyond the centre.
TEST(BridgeFolds, lead_over_the_bend_from_straight_to_straight) {
  const double quarter_m = 0.5 * pi;
  const ReferenceLine line = line_along({{0.0, {}, 20.0, Clothoid{}, ""},
                                         {20.0, {20.0, 0.0, 0.0}, quarter_m, Clothoid{-1.0, -1.0}, ""},
                                         {20.0 + quarter_m, {21.0, -1.0, -0.5 * pi}, 20.0, Clothoid{}, ""}},
                                        40.0 + quarter_m);
  const auto lateral = *Lateral::make({{0.0, -1.5}}, 40.0 + quarter_m);
  std::size_t work = 100'000;
  const auto bridges = bridge_folds(line, lateral, 0.0, 40.0 + quarter_m, work);
  ASSERT_THAT(bridges, SizeIs(1));
  const Bridge& bridge = bridges[0];
  EXPECT_LT(bridge.from, 20.0);
  EXPECT_GT(bridge.to, 20.0 + quarter_m);
  EXPECT_GT(bridge.from, 10.0);
  EXPECT_LT(bridge.to, 30.0 + quarter_m);
  EXPECT_GE(bridge.tightest_m(), 1.5);  // as gentle as the lane is far off
  // It leaves and meets the lane along it.
  EXPECT_NEAR(bridge.start.y_m, -1.5, 1e-9);
  EXPECT_NEAR(bridge.start.x_m, bridge.from, 1e-9);
  EXPECT_NEAR(bridge.start_d.y_m, 0.0, 1e-9);
  EXPECT_GT(bridge.start_d.x_m, 0.0);
  EXPECT_NEAR(bridge.end.x_m, 19.5, 1e-9);
  EXPECT_NEAR(bridge.end_d.x_m, 0.0, 1e-9);
  EXPECT_LT(bridge.end_d.y_m, 0.0);
  EXPECT_NEAR(bridge.start_d.x_m, -bridge.end_d.y_m, 1e-9);

  std::size_t none = 0;
  EXPECT_THAT(bridge_folds(line, lateral, 0.0, 40.0 + quarter_m, none), IsEmpty());
}

/// Straight on for 20 m, a quarter to the right round 1 m, straight on for 20 m.
ReferenceLine line_round_a_corner() {
  const double quarter_m = 0.5 * pi;
  return line_along({{0.0, {}, 20.0, Clothoid{}, ""},
                     {20.0, {20.0, 0.0, 0.0}, quarter_m, Clothoid{-1.0, -1.0}, ""},
                     {20.0 + quarter_m, {21.0, -1.0, -0.5 * pi}, 20.0, Clothoid{}, ""}},
                    40.0 + quarter_m);
}

// The lane folds along the bend. A bridge that reaches r beyond it to each side is nearly an arc of radius r + 1 less
// the lane's offset; r begins with a quarter of a metre and grows by a quarter, until the radius is as large as the
// offset, or 2 m.
TEST(BridgeFolds, reach_as_far_as_a_gentle_bend_needs) {
  const double quarter_m = 0.5 * pi;
  const ReferenceLine line = line_round_a_corner();
  const auto bridge_at = [&](double offset_m) {
    std::size_t work = 100'000;
    const auto bridges =
        bridge_folds(line, *Lateral::make({{0.0, -offset_m}}, 40.0 + quarter_m), 0.0, 40.0 + quarter_m, work);
    EXPECT_THAT(bridges, SizeIs(1));
    // Every 25 cm from 0 to 41.5 m, at the end, and on both sides of both ends of the bend.
    EXPECT_EQ(work, 100'000U - 172U);
    return bridges.front();
  };
  // 1.36 m with the ninth reach, 1.83 m with the tenth.
  const Bridge near = bridge_at(1.5);
  const double near_m = 0.25 * std::pow(1.25, 10);
  EXPECT_NEAR(near.from, 20.0 - near_m, 1e-6);
  EXPECT_NEAR(near.to, 20.0 + quarter_m + near_m, 1e-6);
  // The handles of a cubic that is nearly an arc: the chord over cos²(a quarter of the turn).
  const double handle_m = std::sqrt(2.0) * (near_m - 0.5) / std::pow(std::cos(pi / 8.0), 2);
  EXPECT_NEAR(near.start_d.x_m, handle_m, 1e-6);
  EXPECT_NEAR(near.end_d.y_m, -handle_m, 1e-6);
  // 1.64 m with the twelfth reach, 2.55 m with the thirteenth; 3 m are not needed.
  const Bridge far = bridge_at(3.0);
  EXPECT_NEAR(far.from, 20.0 - 0.25 * std::pow(1.25, 13), 1e-6);
  EXPECT_NEAR(far.to, 20.0 + quarter_m + 0.25 * std::pow(1.25, 13), 1e-6);
}

TEST(BridgeFolds, are_searched_at_four_thousand_positions_of_a_long_lane) {
  const ReferenceLine line = line_along({{0.0, {}, 2000.0, Clothoid{}, ""}}, 2000.0);
  std::size_t work = 10'000;
  EXPECT_THAT(bridge_folds(line, *Lateral::make({{0.0, 3.0}}, 2000.0), 0.0, 2000.0, work), IsEmpty());
  EXPECT_EQ(work, 10'000U - 4'001U);
  EXPECT_THAT(bridge_folds(line, *Lateral::make({{0.0, 3.0}}, 2000.0), 0.0, 2000.0, work), IsEmpty());
  EXPECT_THAT(bridge_folds(line, *Lateral::make({{0.0, 3.0}}, 2000.0), 0.0, 2000.0, work), IsEmpty());
  EXPECT_EQ(work, 0U) << "never less than nothing";
}

// Where the road begins to bend, a lane that leads across it kinks: at a slope of b and an offset of t on a bend of
// curvature 1/R its direction turns from atan b to atan(b/(1 − t/R)).
TEST(BridgeFolds, lead_over_a_kink_of_more_than_a_tenth_of_a_radian) {
  const auto bridges = [](double offset_m, double slope) {
    const ReferenceLine line =
        line_along({{0.0, {}, 20.0, Clothoid{}, ""}, {20.0, {20.0, 0.0, 0.0}, 15.0, Clothoid{0.1, 0.1}, ""}}, 35.0);
    std::size_t work = 10'000;
    return bridge_folds(line, *Lateral::make({{0.0, offset_m - 20.0 * slope, slope}}, 35.0), 0.0, 35.0, work).size();
  };
  // From 0.0997 rad to 0.1974 rad, and to 0.2054 rad.
  EXPECT_EQ(bridges(5.0, 0.1), 0U);
  EXPECT_EQ(bridges(5.2, 0.1), 1U);
}

}  // namespace
}  // namespace cosiva::zone::opendrive
