#include "cosiva/aiv/perception/corridor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
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

double gap(zone::TrackPosition here, const std::vector<Point2>& virtual_objects) {
  Corridor corridor{lacet4()};
  return corridor.obstacle_ahead_m(here, scan(lacet4().circuit.pose_at(here), virtual_objects));
}
double gap_to_vehicle(zone::TrackPosition here, zone::TrackPosition other) {
  return gap(here, body(lacet4().circuit.pose_at(other)));
}

TEST(Corridor, without_echoes_is_free) { EXPECT_EQ(gap(at(lacet4(), "east", 0.1), {}), nothing); }

TEST(Corridor, detects_the_leader_on_a_straight) {
  EXPECT_NEAR(gap_to_vehicle(at(lacet4(), "east", 0.1), at(lacet4(), "east", 0.8)), 0.5, 0.03);
}

TEST(Corridor, detects_the_leader_on_an_arc) {
  for (const double gap_m : {0.15, 0.3, 0.45, 0.6}) {
    const double detected_m = gap_to_vehicle(at(lacet4(), "loop_se", 0.8), at(lacet4(), "loop_se", 0.8 + 0.2 + gap_m));
    EXPECT_NEAR(detected_m, gap_m, 0.04) << "gap " << gap_m;
  }
}

TEST(Corridor, detects_the_leader_beyond_the_joint_of_two_sections) {
  EXPECT_NEAR(gap_to_vehicle(at(lacet4(), "east", 1.4), at(lacet4(), "loop_se", 0.4)), 0.3, 0.04);
}

TEST(Corridor, ignores_the_neighbouring_lane) {
  // Lanes of opposite directions are 0.30 m apart: y = -0.15 eastward, y = +0.15 westward.
  for (int mm = 0; mm <= 1500; mm += 20)
    EXPECT_EQ(gap_to_vehicle(at(lacet4(), "east", 0.5), at(lacet4(), "west", 1e-3 * mm)), nothing) << mm;
}

TEST(Corridor, ignores_a_vehicle_at_the_stop_line_of_a_crossing_lane) {
  for (int mm = 300; mm <= 650; mm += 10) {
    const double detected_m = gap_to_vehicle(at(lacet4(), "south", 1e-3 * mm), at(lacet4(), "east", 0.38));
    EXPECT_GT(detected_m, 0.4) << mm;
  }
}

TEST(Corridor, detects_a_vehicle_in_the_crossing) {
  EXPECT_NEAR(gap_to_vehicle(at(lacet4(), "south", 0.4), at(lacet4(), "east", 0.6)), 0.34, 0.04);
}

TEST(Corridor, ignores_bodies_behind_or_beyond_its_reach) {
  EXPECT_EQ(gap_to_vehicle(at(lacet4(), "east", 0.8), at(lacet4(), "east", 0.3)), nothing);
  EXPECT_EQ(gap_to_vehicle(at(lacet4(), "loop_sw", 2.7), at(lacet4(), "east", 1.45)), nothing);
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

/// One beam of 0.3 rad in a zone with a straight along x.
wire::Ranges one_beam(double range_m, double bearing_rad) {
  return {0,
          static_cast<std::int16_t>(std::lround(100.0 * bearing_rad)),
          30,
          {static_cast<std::uint16_t>(std::lround(1000.0 * range_m))}};
}

TEST(Corridor, is_as_wide_as_the_body_and_its_margins_less_half_a_step_and_an_echo_lies_within_a_third_of_its_beam) {
  zone::TrafficZone zone = lacet4();
  zone.circuit = test::lay({{5.0}}, false);
  // Samples are 1 mm apart, so that the corridor is 0.08 m to each side; the sensor is 0.1 m ahead of the body origin.
  Corridor corridor{zone, {.sample_m = 0.001}};
  EXPECT_NEAR(corridor.reach_m(), 1.2, 1e-12);
  const auto gap_m = [&](double range_m, double bearing_rad) {
    return corridor.obstacle_ahead_m(Outlook{0, 1.0}, one_beam(range_m, bearing_rad));
  };
  EXPECT_NEAR(gap_m(0.5, 0.0), 0.5 * std::cos(0.1), 1e-3) << "on the side of the beam";
  // The side of the beam that is nearer to the path: 0.1 rad less than the bearing.
  const double inside_rad = std::asin(0.079 / 0.5);
  const double outside_rad = std::asin(0.082 / 0.5);
  const double step_rad = 0.01;  // bearings are hundredths
  for (const double side : {-1.0, 1.0}) {
    const double in_rad = std::floor((0.1 + inside_rad) / step_rad) * step_rad;
    const double out_rad = std::ceil((0.1 + outside_rad) / step_rad) * step_rad;
    EXPECT_NEAR(gap_m(0.5, side * in_rad), 0.5 * std::cos(in_rad - 0.1), 1e-3) << side;
    EXPECT_EQ(gap_m(0.5, side * out_rad), nothing) << side;
  }
  EXPECT_LT(gap_m(1.199, 0.0), 1.2);
  EXPECT_EQ(gap_m(1.201, 0.0), nothing);
}

TEST(Corridor, names_the_beam_of_the_nearest_echo_on_the_path) {
  zone::TrafficZone zone = lacet4();
  zone.circuit = test::lay({{5.0}}, false);
  Corridor corridor{zone};
  wire::Ranges ranges{0, -14, 14, {700, wire::no_echo, 650}};
  ranges.range_mm[1] = 600;
  EXPECT_EQ(corridor.scan(Outlook{0, 1.0}, ranges).beam, 1U);
  ranges.range_mm[1] = wire::no_echo;
  // The others lie 0.14 rad aside, the nearer sides of their beams 0.093 rad.
  const Corridor::Scan aside = corridor.scan(Outlook{0, 1.0}, ranges);
  EXPECT_EQ(aside.beam, 2U);
  EXPECT_NEAR(aside.ahead_m, 0.65 * std::cos(0.14 - 0.14 / 3.0), 0.005);
  ranges.range_mm = {wire::no_echo, wire::no_echo, wire::no_echo};
  EXPECT_EQ(corridor.scan(Outlook{0, 1.0}, ranges).ahead_m, nothing);
  EXPECT_EQ(corridor.scan(Outlook{0, 1.0}, ranges).beam, 0U);
}

TEST(Corridor, measures_from_the_body_origin_to_the_nearest_echo_in_any_direction) {
  const Corridor corridor{lacet4()};
  wire::Ranges ranges{0, -100, 50, {300, wire::no_echo, 400, 450, 310}};
  // At −1, 0, 0.5 and 1 rad from the sensor, 0.1 m before the body origin.
  const auto from_origin_m = [](double range_m, double bearing_rad) {
    return std::hypot(0.1 + range_m * std::cos(bearing_rad), range_m * std::sin(bearing_rad));
  };
  EXPECT_NEAR(corridor.nearest_m(ranges), from_origin_m(0.3, -1.0), 1e-9);
  ranges.range_mm[0] = wire::no_echo;
  EXPECT_NEAR(corridor.nearest_m(ranges), from_origin_m(0.31, 1.0), 1e-9);
  ranges.range_mm = {wire::no_echo, wire::no_echo, wire::no_echo};
  EXPECT_EQ(corridor.nearest_m(ranges), nothing);
  std::vector<Point2> echoes;
  ranges.range_mm = {300, wire::no_echo, 400};
  EXPECT_FALSE(corridor.any_echo(ranges, [&](Point2 p_B) {
    echoes.push_back(p_B);
    return false;
  }));
  ASSERT_EQ(echoes.size(), 2U);
  EXPECT_NEAR(echoes[0].x_m, 0.1 + 0.3 * std::cos(1.0), 1e-9);
  EXPECT_NEAR(echoes[0].y_m, -0.3 * std::sin(1.0), 1e-9);
  EXPECT_NEAR(echoes[1].x_m, 0.5, 1e-9);
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

TEST(CorridorDeathTest, is_no_narrower_than_the_body_and_an_echo_lies_within_its_beam) {
  const Corridor widest{lacet4(), {.margin_m = 0.0, .beam_ratio = 0.5}};
  const Corridor narrowest{lacet4(), {.margin_m = 0.0, .beam_ratio = 0.0}};
  EXPECT_DEATH(static_cast<void>(Corridor{lacet4(), {.margin_m = -0.01}}), "margin_m >= 0.0");
  EXPECT_DEATH(static_cast<void>(Corridor{lacet4(), {.beam_ratio = -0.01}}), "beam_ratio >= 0.0");
  EXPECT_DEATH(static_cast<void>(Corridor{lacet4(), {.beam_ratio = 0.51}}), "beam_ratio <= 0.5");
}

}  // namespace
}  // namespace cosiva::aiv
