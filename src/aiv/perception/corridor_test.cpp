#include "cosiva/aiv/perception/corridor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;

constexpr double nothing = std::numeric_limits<double>::infinity();

/// Thirteen beams of 0.14 rad from the front of the body; each measures the nearest of the given points in its sector.
wire::Ranges scan(const Pose2& X_MB, const std::vector<Point2>& virtual_objects) {
  wire::Ranges ranges{0, -84, 14, std::vector<std::uint16_t>(13, wire::no_echo)};
  const Pose2 X_BM = inverse(X_MB);
  for (const Point2& p_M : virtual_objects) {
    const Point2 p_B = X_BM * p_M;
    const double x_m = p_B.x_m - 0.1;
    const double range_m = std::hypot(x_m, p_B.y_m);
    const long beam = std::lround((std::atan2(p_B.y_m, x_m) + 0.84) / 0.14);
    if (beam < 0 || beam > 12 || range_m > 2.0) continue;
    auto& detected = ranges.range_mm[static_cast<std::size_t>(beam)];
    detected = std::min(detected, static_cast<std::uint16_t>(std::lround(range_m * 1e3)));
  }
  return ranges;
}

/// Points all over the outline of a vehicle.
std::vector<Point2> body(const Pose2& X_MB) {
  std::vector<Point2> points;
  for (int i = 0; i <= 20; ++i) {
    for (const double side : {-0.06, 0.06}) points.push_back(X_MB * Point2{-0.1 + 0.01 * i, side});
    for (const double end : {-0.1, 0.1}) points.push_back(X_MB * Point2{end, -0.06 + 0.006 * i});
  }
  return points;
}

double ahead(zone::TrackPosition here, const std::vector<Point2>& virtual_objects) {
  Corridor corridor{lacet4()};
  return corridor.obstacle_ahead_m(here, scan(lacet4().circuit.pose_at(here), virtual_objects));
}
double ahead_of_vehicle(zone::TrackPosition here, zone::TrackPosition other) {
  return ahead(here, body(lacet4().circuit.pose_at(other)));
}

TEST(Corridor, without_echoes_is_free) { EXPECT_EQ(ahead(at(lacet4(), "east", 0.1), {}), nothing); }

TEST(Corridor, detects_the_leader_on_a_straight) {
  EXPECT_NEAR(ahead_of_vehicle(at(lacet4(), "east", 0.1), at(lacet4(), "east", 0.8)), 0.5, 0.03);
}

TEST(Corridor, detects_the_leader_on_an_arc) {
  for (const double gap_m : {0.15, 0.3, 0.45, 0.6}) {
    const double detected_m =
        ahead_of_vehicle(at(lacet4(), "loop_se", 0.8), at(lacet4(), "loop_se", 0.8 + 0.2 + gap_m));
    EXPECT_NEAR(detected_m, gap_m, 0.04) << "gap " << gap_m;
  }
}

TEST(Corridor, detects_the_leader_beyond_the_joint_of_two_sections) {
  EXPECT_NEAR(ahead_of_vehicle(at(lacet4(), "east", 1.4), at(lacet4(), "loop_se", 0.4)), 0.3, 0.04);
}

TEST(Corridor, ignores_the_neighbouring_lane) {
  // Lanes of opposite directions are 0.30 m apart: y = -0.15 eastward, y = +0.15 westward.
  for (int mm = 0; mm <= 1500; mm += 20)
    EXPECT_EQ(ahead_of_vehicle(at(lacet4(), "east", 0.5), at(lacet4(), "west", 1e-3 * mm)), nothing) << mm;
}

TEST(Corridor, ignores_a_vehicle_at_the_stop_line_of_a_crossing_lane) {
  for (int mm = 300; mm <= 650; mm += 10) {
    const double detected_m = ahead_of_vehicle(at(lacet4(), "south", 1e-3 * mm), at(lacet4(), "east", 0.38));
    EXPECT_GT(detected_m, 0.4) << mm;
  }
}

TEST(Corridor, detects_a_vehicle_in_the_crossing) {
  EXPECT_NEAR(ahead_of_vehicle(at(lacet4(), "south", 0.4), at(lacet4(), "east", 0.6)), 0.34, 0.04);
}

TEST(Corridor, ignores_bodies_behind_or_beyond_its_reach) {
  EXPECT_EQ(ahead_of_vehicle(at(lacet4(), "east", 0.8), at(lacet4(), "east", 0.3)), nothing);
  EXPECT_EQ(ahead_of_vehicle(at(lacet4(), "loop_sw", 2.7), at(lacet4(), "east", 1.45)), nothing);
}

TEST(Corridor, ends_where_the_circuit_ends) {
  zone::TrafficZone dead_end = lacet4();
  dead_end.circuit = test::lay({{0.5}}, false);
  Corridor corridor{dead_end};
  EXPECT_NEAR(corridor.obstacle_ahead_m({0, 0.1}, scan({0.1, 0.0, 0.0}, {{0.45, 0.0}})), 0.25, 0.03);
  EXPECT_EQ(corridor.obstacle_ahead_m({0, 0.1}, scan({0.1, 0.0, 0.0}, {{1.0, 0.0}})), nothing);
}

TEST(Corridor, takes_a_touching_echo_as_zero_distance) {
  const wire::Ranges ranges{0, 0, 14, {0}};
  Corridor corridor{lacet4()};
  EXPECT_NEAR(corridor.obstacle_ahead_m(at(lacet4(), "east", 0.1), ranges), 0.0, 0.02);
}

// --- three frames -------------------------------------------------------------------------------------------------

TEST(ObstacleFilter, survives_one_echo_missed_and_one_too_many) {
  ObstacleFilter filter;
  for (int i = 0; i < 3; ++i) filter.add(0.5, 0.0);
  filter.add(nothing, 0.0);
  EXPECT_EQ(filter.obstacle_ahead_m(0.0), 0.5);
  filter.clear();
  filter.add(nothing, 0.0);
  filter.add(0.1, 0.0);
  EXPECT_EQ(filter.obstacle_ahead_m(0.0), nothing);
}

TEST(ObstacleFilter, accepts_the_second_frame_of_a_new_obstacle_and_of_its_disappearance) {
  ObstacleFilter filter;
  filter.add(0.5, 0.0);
  EXPECT_EQ(filter.obstacle_ahead_m(0.0), nothing);
  filter.add(0.5, 0.0);
  EXPECT_EQ(filter.obstacle_ahead_m(0.0), 0.5);
  filter.add(nothing, 0.0);
  filter.add(nothing, 0.0);
  EXPECT_EQ(filter.obstacle_ahead_m(0.0), nothing);
}

TEST(ObstacleFilter, brings_old_frames_nearer_as_the_vehicle_drives) {
  ObstacleFilter filter;
  filter.add(0.50, 1.00);
  filter.add(0.48, 1.02);
  filter.add(0.46, 1.04);
  EXPECT_NEAR(filter.obstacle_ahead_m(1.06), 0.44, 1e-12);
}

}  // namespace
}  // namespace cosiva::aiv
