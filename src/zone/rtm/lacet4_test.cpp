// zones/lacet4.toml is the article's CircuitLacet4 as A11 fixes it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::SizeIs;
constexpr double a = 0.75;
constexpr double d = 0.15;
constexpr double r = a - d;

TEST(Lacet4, has_four_straights_and_four_loops_end_to_end) {
  const TrafficZone zone = testing::lacet4();
  ASSERT_EQ(zone.circuit.size(), 8U);
  for (SectionId id = 0; id < 8; ++id) {
    const bool straight = id % 2 == 0;
    EXPECT_EQ(zone.circuit.section(id).kind(), straight ? SectionKind::straight : SectionKind::arc);
    EXPECT_NEAR(zone.circuit.section(id).length_m(), straight ? 2.0 * a : 1.5 * pi * r, 1e-12);
    EXPECT_THAT(zone.circuit.next(id), ::testing::ElementsAre((id + 1) % 8));
  }
}

TEST(Lacet4, is_17_31_m_long) {
  const double length_m = testing::lacet4().circuit.total_length_m();
  EXPECT_NEAR(length_m, 6.0 + 4.0 * 1.5 * pi * r, 1e-12);
  EXPECT_NEAR(length_m, 17.31, 0.005);
}

TEST(Lacet4, has_its_straights_at_the_positions_fixed_for_the_article) {
  const TrafficZone zone = testing::lacet4();
  const auto expect_centre = [&](std::string_view name, const Pose2& X_MP) {
    const auto id = zone.circuit.find(name);
    ASSERT_TRUE(id);
    const Pose2 pose = zone.circuit.section(*id).pose_at(a);
    EXPECT_NEAR(pose.x_m, X_MP.x_m, 1e-12);
    EXPECT_NEAR(pose.y_m, X_MP.y_m, 1e-12);
    EXPECT_NEAR(wrap_angle(pose.heading_rad - X_MP.heading_rad), 0.0, 1e-12);
  };
  expect_centre("east", {0.0, -d, 0.0});
  expect_centre("north", {d, 0.0, pi / 2.0});
  expect_centre("west", {0.0, d, pi});
  expect_centre("south", {-d, 0.0, -pi / 2.0});
}

TEST(Lacet4, loops_turn_right_round_the_corners) {
  const TrafficZone zone = testing::lacet4();
  const std::array<std::pair<std::string_view, Point2>, 4> loops{
      {{"loop_se", {a, -a}}, {"loop_ne", {a, a}}, {"loop_nw", {-a, a}}, {"loop_sw", {-a, -a}}}};
  for (const auto& [name, centre] : loops) {
    const Section& loop = zone.circuit.section(zone.circuit.find(name).value());
    EXPECT_NEAR(loop.curvature_at(0.0), -1.0 / r, 1e-12);
    for (const double part : {0.0, 0.31, 0.5, 1.0})
      EXPECT_NEAR(distance(position(loop.pose_at(part * loop.length_m())), centre), r, 1e-12);
  }
}

TEST(Lacet4, closes_within_a_picometre) {
  const TrafficZone zone = testing::lacet4();
  const Pose2& start = zone.circuit.section(0).start();
  const Pose2& end = zone.circuit.section(7).end();
  EXPECT_NEAR(end.x_m, start.x_m, 1e-12);
  EXPECT_NEAR(end.y_m, start.y_m, 1e-12);
  EXPECT_NEAR(wrap_angle(end.heading_rad - start.heading_rad), 0.0, 1e-12);
}

TEST(Lacet4, has_its_four_crossings) {
  const TrafficZone zone = testing::lacet4();
  ASSERT_THAT(zone.crossings, SizeIs(4));
  const std::array<Point2, 4> expected{{{-d, -d}, {d, -d}, {d, d}, {-d, d}}};
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(zone.crossings[i].name, "X" + std::to_string(i + 1));
    EXPECT_NEAR(zone.crossings[i].centre.x_m, expected[i].x_m, 1e-3);
    EXPECT_NEAR(zone.crossings[i].centre.y_m, expected[i].y_m, 1e-3);
    EXPECT_THAT(zone.crossings[i].spans, SizeIs(2));
  }
}

TEST(Lacet4, has_twelve_tags_three_per_quadrant) {
  const TrafficZone zone = testing::lacet4();
  ASSERT_THAT(zone.tags, SizeIs(12));
  std::array<int, 4> per_quadrant{};
  for (const Tag& tag : zone.tags) {
    const Pose2 pose = zone.circuit.pose_at(tag.position);
    ++per_quadrant[(pose.x_m > 0.0 ? 1U : 0U) + (pose.y_m > 0.0 ? 2U : 0U)];
    // A tag at a joint would lie on two sections at once.
    EXPECT_GT(tag.position.s_m, 0.02);
    EXPECT_LT(tag.position.s_m, zone.circuit.section(tag.position.section).length_m() - 0.02);
  }
  EXPECT_THAT(per_quadrant, ::testing::Each(3));
}

TEST(Lacet4, has_no_unnecessarily_long_stretch_without_tag) {
  const TrafficZone zone = testing::lacet4();
  for (std::size_t i = 0; i < 12; ++i) {
    const auto stretch_m = zone.circuit.distance_ahead(zone.tags[i].position, zone.tags[(i + 1) % 12].position, 100.0);
    EXPECT_NEAR(stretch_m.value(), zone.circuit.total_length_m() / 12.0, 0.002);
  }
}

TEST(Lacet4, has_a_beacon_under_each_straight_at_every_pitch) {
  const TrafficZone zone = testing::lacet4();
  for (const char* name : {"east", "north", "west", "south"}) {
    const Section& straight = zone.circuit.section(zone.circuit.find(name).value());
    for (int i = 0; i <= 5; ++i) {
      const Point2 p = position(straight.pose_at(0.30 * i));
      const auto beacon = zone.beacons->nearest(p);
      ASSERT_TRUE(beacon) << name;
      EXPECT_LT(distance(beacon->position, p), 1e-9) << name << " " << i;
    }
  }
}

TEST(Lacet4, has_beacons_over_the_whole_zone) {
  const TrafficZone zone = testing::lacet4();
  ASSERT_TRUE(zone.beacons);
  EXPECT_EQ(zone.beacons->pitch_m, 0.30);
  for (SectionId id = 0; id < 8; ++id) {
    for (double s = 0.0; s < zone.circuit.section(id).length_m(); s += 0.1)
      EXPECT_TRUE(zone.beacons->nearest(position(zone.circuit.pose_at({id, s}))));
  }
}

TEST(Lacet4, begins_with_four_vehicles_one_per_loop_and_has_room_for_twelve) {
  const TrafficZone zone = testing::lacet4();
  EXPECT_THAT(zone.starts, SizeIs(4));
  for (const TrackPosition& track_position : zone.starts)
    EXPECT_EQ(zone.circuit.section(track_position.section).kind(), SectionKind::arc);
  EXPECT_THAT(zone.start_positions(12), SizeIs(12));
}

TEST(Lacet4, lays_no_waypoint_between_its_crossings) {
  // Straights cross two others 0.3 m apart: a vehicle of 0.2 m cannot stop between.
  const TrafficZone zone = testing::lacet4();
  for (const Waypoint& waypoint : zone.waypoints) {
    if (zone.circuit.section(waypoint.position.section).kind() != SectionKind::straight) continue;
    EXPECT_TRUE(waypoint.position.s_m < a - d - 0.2 || waypoint.position.s_m > a + d + 0.2) << waypoint.id;
  }
}

}  // namespace
}  // namespace cosiva::zone
