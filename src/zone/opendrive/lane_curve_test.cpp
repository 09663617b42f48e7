#include "cosiva/zone/opendrive/lane_curve.h"

#include <gmock/gmock.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "cosiva/zone/opendrive/report.h"

namespace cosiva::zone::opendrive {
namespace {

using ::testing::ElementsAre;

/// At an offset to the left of a road of 40 m that begins straight along x and turns left round 100 m after 20 m.
LaneCurve lane_curve(double offset_m, bool forward, double from = 5.0, double to = 35.0) {
  Road road;
  road.id = "1";
  road.length = 40.0;
  road.plan = {{0.0, {}, 20.0, Clothoid{}, ""}, {20.0, {20.0, 0.0, 0.0}, 20.0, Clothoid{0.01, 0.01}, ""}};
  Report report;
  auto line = ReferenceLine::make(road, report);
  EXPECT_TRUE(line);
  return {std::make_shared<const ReferenceLine>(std::move(*line)), *Lateral::make({{0.0, offset_m}}, 40.0), from, to,
          forward};
}
void expect_near(const Pose2& found, const Pose2& expected) {
  EXPECT_NEAR(found.x_m, expected.x_m, 1e-9);
  EXPECT_NEAR(found.y_m, expected.y_m, 1e-9);
  EXPECT_NEAR(wrap_angle(found.heading_rad - expected.heading_rad), 0.0, 1e-9);
}

TEST(LaneCurve, keeps_its_offset_from_its_road_in_the_direction_of_travel) {
  const Pose2 begin{5.0, 2.0, 0.0};
  const Pose2 end{20.0 + 98.0 * std::sin(0.15), 100.0 - 98.0 * std::cos(0.15), 0.15};
  const LaneCurve forward = lane_curve(2.0, true);
  expect_near(forward.entry(), begin);
  expect_near(forward.exit(), end);
  const LaneCurve back = lane_curve(2.0, false);
  expect_near(back.entry(), {end.x_m, end.y_m, end.heading_rad + pi});
  expect_near(back.exit(), {begin.x_m, begin.y_m, pi});
}

TEST(LaneCurve, whose_end_is_moved_eases_back_within_the_reach_and_stays_smooth) {
  for (const bool forward : {true, false}) {
    for (const bool entry : {true, false}) {
      const LaneCurve before = lane_curve(-1.0, forward);
      LaneCurve moved = before;
      const Pose2 old = entry ? before.entry() : before.exit();
      const Pose2 target{old.x_m + 0.2, old.y_m - 0.1, wrap_angle(old.heading_rad + 0.03)};
      moved.move_end(entry, target, 8.0);
      expect_near(entry ? moved.entry() : moved.exit(), target);
      expect_near(entry ? moved.exit() : moved.entry(), entry ? before.exit() : before.entry());
      const bool at_from = entry == forward;
      for (double s = 5.01; s < 35.0; s += 0.5) {
        const Pose2 here = moved.pose_at(s);
        const double from_end = at_from ? s - 5.0 : 35.0 - s;
        EXPECT_EQ(distance(here, before.pose_at(s)) < 1e-12, from_end >= 8.0) << s;
        const Point2 one = position(moved.pose_at(s - 1e-5));
        const Point2 two = position(moved.pose_at(s + 1e-5));
        const double sign = forward ? 1.0 : -1.0;
        const double along = std::atan2(sign * (two.y_m - one.y_m), sign * (two.x_m - one.x_m));
        EXPECT_NEAR(wrap_angle(here.heading_rad - along), 0.0, 1e-6) << s;
      }
    }
  }
  // No further than the lane is long.
  LaneCurve moved = lane_curve(0.0, true);
  moved.move_end(true, {5.0, 0.1, 0.0}, 100.0);
  expect_near(moved.exit(), lane_curve(0.0, true).exit());
  EXPECT_GT(moved.pose_at(20.0).y_m, 0.04);  // half of the shift, halfway
}

TEST(LaneCurve, gives_its_breaks_and_scaled_positions_along_the_direction_of_travel) {
  for (const bool forward : {true, false}) {
    LaneCurve lane = lane_curve(0.0, forward);
    const std::vector<double> more{0.0, 5.0, 12.0, 35.0, 39.0};
    const PlaneCurve plain = lane.curve(0.5, more);
    EXPECT_EQ(plain.from, forward ? 5.0 : -35.0);
    EXPECT_EQ(plain.to, forward ? 35.0 : -5.0);
    if (forward)
      EXPECT_THAT(plain.breaks, ElementsAre(12.0, 20.0));
    else
      EXPECT_THAT(plain.breaks, ElementsAre(-20.0, -12.0));
    const Pose2 entry = plain.at(plain.from);
    expect_near(entry, {0.5 * lane.entry().x_m, 0.5 * lane.entry().y_m, lane.entry().heading_rad});
    const Pose2 exit = plain.at(plain.to);
    expect_near(exit, {0.5 * lane.exit().x_m, 0.5 * lane.exit().y_m, lane.exit().heading_rad});
    // Corrections begin and end at breaks.
    const Pose2 first = lane.pose_at(5.0);
    lane.move_end(forward, {first.x_m, first.y_m + 0.1, first.heading_rad}, 6.0);
    const Pose2 last = lane.pose_at(35.0);
    lane.move_end(!forward, {last.x_m, last.y_m + 0.1, last.heading_rad}, 4.0);
    const PlaneCurve moved = lane.curve(1.0, {});
    if (forward)
      EXPECT_THAT(moved.breaks, ElementsAre(11.0, 20.0, 31.0));
    else
      EXPECT_THAT(moved.breaks, ElementsAre(-31.0, -20.0, -11.0));
  }
}

}  // namespace
}  // namespace cosiva::zone::opendrive
