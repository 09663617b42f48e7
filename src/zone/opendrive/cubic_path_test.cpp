#include "cosiva/zone/opendrive/cubic_path.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace cosiva::zone::opendrive {
namespace {

using PRange = Cubics::Range;

void expect_jet(const Jet& jet, Point2 p, Point2 d, Point2 dd) {
  EXPECT_NEAR(jet.p.x_m, p.x_m, 1e-9);
  EXPECT_NEAR(jet.p.y_m, p.y_m, 1e-9);
  EXPECT_NEAR(jet.d.x_m, d.x_m, 1e-9);
  EXPECT_NEAR(jet.d.y_m, d.y_m, 1e-9);
  EXPECT_NEAR(jet.dd.x_m, dd.x_m, 1e-9);
  EXPECT_NEAR(jet.dd.y_m, dd.y_m, 1e-9);
}

TEST(CubicPath, has_p_from_0_to_1_where_it_is_normalized_whatever_its_length_in_the_file) {
  const auto path = CubicPath::make({1.0, 2.0, 0.5 * pi}, {{0.0, 0.0, 40.0}, {}, PRange::normalized}, 17.0);
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->length(), 40.0, 1e-12);
  for (const double arc : {0.0, 0.3, 10.0, 39.9, 40.0}) expect_jet(path->at(arc), {1.0, 2.0 + arc}, {0.0, 1.0}, {});
  expect_jet(path->at(-1.0), {1.0, 2.0}, {0.0, 1.0}, {});
  expect_jet(path->at(41.0), {1.0, 42.0}, {0.0, 1.0}, {});
}

TEST(CubicPath, has_p_up_to_its_length_in_the_file_where_p_is_the_arc_length) {
  const auto path = CubicPath::make({}, {{0.0, 0.0, 2.0}, {}, PRange::arc_length}, 25.0);
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->length(), 50.0, 1e-12);
  expect_jet(path->at(30.0), {30.0, 0.0}, {1.0, 0.0}, {});
}

TEST(CubicPath, along_u_ends_where_it_is_as_long_as_in_the_file) {
  // 1.25 m for each metre of u: 25 m end at u = 20 m.
  const auto path = CubicPath::make({}, {{0.0, 0.0, 1.0}, {0.0, 0.0, 0.75}, PRange::along_u}, 25.0);
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->length(), 25.0, 1e-9);
  expect_jet(path->at(12.5), {10.0, 7.5}, {0.8, 0.6}, {});
  expect_jet(path->at(25.0), {20.0, 15.0}, {0.8, 0.6}, {});
}

TEST(CubicPath, runs_by_arc_length_even_where_p_does_not) {
  // From 0 to 2 m with a speed from 1 to 3.
  const auto path = CubicPath::make({}, {{0.0, 0.0, 1.0, 1.0}, {}, PRange::normalized}, 1.0);
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->length(), 2.0, 1e-12);
  for (const double arc : {0.01, 0.3, 1.0, 1.7, 1.99}) expect_jet(path->at(arc), {arc, 0.0}, {1.0, 0.0}, {});
}

TEST(CubicPath, that_begins_without_speed_leads_along_its_start) {
  const auto path = CubicPath::make({0.0, 0.0, 0.3}, {{0.0, 0.0, 0.0, 3.0}, {}, PRange::normalized}, 1.0);
  ASSERT_TRUE(path);
  EXPECT_NEAR(path->length(), 3.0, 1e-12);
  const Point2 along{std::cos(0.3), std::sin(0.3)};
  for (const double arc : {0.0, 1e-3, 1.5, 3.0})
    expect_jet(path->at(arc), {arc * along.x_m, arc * along.y_m}, along, {});
}

// u = 2p, v = p²: the speed is 2·√(1 + p²), so that p·√(1 + p²) + asinh p are passed up to p; the curvature is
// (u'v'' − v'u'')/speed³ = ½·(1 + p²)^−1.5.
TEST(CubicPath, of_a_parabola_has_its_arc_length_its_direction_and_its_curvature) {
  const Pose2 start{5.0, -3.0, 0.7};
  for (const double side : {1.0, -1.0}) {
    const auto path = CubicPath::make(start, {{0.0, 0.0, 2.0}, {0.0, 0.0, 0.0, side}, PRange::arc_length}, 3.0);
    ASSERT_TRUE(path);
    const auto arc_to = [](double p) { return p * std::sqrt(1.0 + p * p) + std::asinh(p); };
    EXPECT_NEAR(path->length(), arc_to(3.0), 1e-9);
    for (const double p : {0.0, 0.1, 0.5, 1.0, 1.7, 2.9, 3.0}) {
      const double speed = std::sqrt(1.0 + p * p);
      const double heading = 0.7 + side * std::atan(p);
      const double bend = side * 0.5 / (speed * speed * speed);
      expect_jet(path->at(arc_to(p)), start * Point2{2.0 * p, side * p * p}, {std::cos(heading), std::sin(heading)},
                 {-bend * std::sin(heading), bend * std::cos(heading)});
    }
  }
}

TEST(CubicPath, turns_by_the_second_derivative_of_both_coordinates) {
  // u = p + p², v = p + ½p² at p = ½: u' = 2, v' = 1.5, u'' = 2, v'' = 1: speed 2.5, curvature (2·1 − 1.5·2)/2.5³.
  const Cubics cubics{{0.0, 0.0, 1.0, 1.0}, {0.0, 0.0, 1.0, 0.5}, PRange::normalized};
  const auto path = CubicPath::make({}, cubics, 1.0);
  ASSERT_TRUE(path);
  // The arc length up to there, by bisection on the point itself.
  double low = 0.0;
  double high = path->length();
  for (int i = 0; i < 60; ++i) (path->at(0.5 * (low + high)).p.x_m < 0.75 ? low : high) = 0.5 * (low + high);
  const double bend = -1.0 / 15.625;
  expect_jet(path->at(low), {0.75, 0.625}, {0.8, 0.6}, {-bend * 0.6, bend * 0.8});
}

TEST(CubicPath, moves_by_a_micrometre_to_a_hundred_kilometres) {
  const auto made = [](double length_m) {
    return CubicPath::make({}, {{0.0, 0.0, length_m}, {}, PRange::normalized}, 1.0).has_value();
  };
  EXPECT_FALSE(made(0.0));
  EXPECT_FALSE(made(0.99e-6));
  EXPECT_TRUE(made(1.01e-6));
  EXPECT_TRUE(made(0.999e5));
  EXPECT_FALSE(made(1.001e5));
  EXPECT_FALSE(made(std::numeric_limits<double>::infinity()));
  EXPECT_FALSE(made(std::numeric_limits<double>::quiet_NaN()));
}

}  // namespace
}  // namespace cosiva::zone::opendrive
