#include "cosiva/zone/geometry/curve_shape.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "cosiva/zone/testing/test_shapes.h"

namespace cosiva::zone {
namespace {

using ::testing::HasSubstr;

std::string fault_of(CurveFormulas curve) {
  const auto made = CurveShape::make("test", {}, std::move(curve));
  return made ? "none" : made.error().code + ": " + made.error().message;
}

/// Simpson's rule with many steps: independent of the table.
double arc_length(const CurveFormulas& curve, double t) {
  constexpr int steps = 20'000;
  const auto speed = [&](double at) {
    const auto v = curve.at(at).velocity;
    return std::hypot(v.x_m, v.y_m);
  };
  double sum = speed(0.0) + speed(t);
  for (int i = 1; i < steps; ++i) sum += (i % 2 == 0 ? 2.0 : 4.0) * speed(t * i / steps);
  return sum * t / steps / 3.0;
}

TEST(CurveShape, has_the_arc_length_of_a_sine) {
  const CurveFormulas curve = test::sine(0.25, 1.5, 2.0);
  const auto shape = test::sine_shape(0.25, 1.5, 2.0);
  ASSERT_NE(shape, nullptr);
  EXPECT_NEAR(shape->length_m(), arc_length(curve, 3.0), 1e-8);
  EXPECT_EQ(shape->kind(), "sine");
}

TEST(CurveShape, gives_position_heading_and_curvature_of_the_formulas_at_each_arc_length) {
  EXPECT_TRUE(rc::check("a sine of any amplitude, wavelength and number of waves", [] {
    const double amplitude_m = 0.01 * *rc::gen::inRange(-40, 41);
    const double wavelength_m = 0.1 * *rc::gen::inRange(5, 40);
    const double waves = 0.1 * *rc::gen::inRange(1, 30);
    const CurveFormulas curve = test::sine(amplitude_m, wavelength_m, waves);
    const auto shape = test::sine_shape(amplitude_m, wavelength_m, waves);
    RC_ASSERT(shape != nullptr);
    const auto start = curve.at(0.0);
    const Pose2 X_SM =
        inverse(Pose2{start.position.x_m, start.position.y_m, std::atan2(start.velocity.y_m, start.velocity.x_m)});
    const double t = curve.t_max * 0.01 * *rc::gen::inRange(0, 101);
    const double s_m = t == 0.0 ? 0.0 : arc_length(curve, t);
    const auto at = curve.at(t);
    const Pose2 expected = X_SM * Pose2{at.position.x_m, at.position.y_m, std::atan2(at.velocity.y_m, at.velocity.x_m)};
    const Pose2 pose = shape->pose_at(s_m);
    RC_ASSERT(distance(pose, expected) < 1e-8 * (1.0 + shape->length_m()));
    RC_ASSERT(std::fabs(wrap_angle(pose.heading_rad - expected.heading_rad)) < 1e-6);
    const double speed = std::hypot(at.velocity.x_m, at.velocity.y_m);
    const double curvature =
        (at.velocity.x_m * at.acceleration.y_m - at.velocity.y_m * at.acceleration.x_m) / (speed * speed * speed);
    RC_ASSERT(std::fabs(shape->curvature_at(s_m) - curvature) < 1e-5);
    RC_ASSERT(std::fabs(curvature) <= shape->curvature_max_per_m());
  }));
}

TEST(CurveShape, follows_an_ellipse_whose_parameter_is_no_length) {
  const CurveFormulas ellipse{
      [](double t) {
        const SinCos at = sincos(t);
        return CurveFormulas::At{{3.0 * at.cos, at.sin}, {-3.0 * at.sin, at.cos}, {-3.0 * at.cos, -at.sin}};
      },
      2.0 * pi};
  const auto shape = CurveShape::make("ellipse", {}, ellipse);
  ASSERT_TRUE(shape) << shape.error().message;
  EXPECT_NEAR((*shape)->length_m(), 13.364893220555258, 1e-8) << "12 E(8/9), by tables";
  const Pose2 end = (*shape)->pose_at((*shape)->length_m());
  EXPECT_NEAR(end.x_m, 0.0, 1e-8);
  EXPECT_NEAR(end.y_m, 0.0, 1e-8);
  EXPECT_GE((*shape)->curvature_max_per_m(), 3.0);
  EXPECT_LT((*shape)->curvature_max_per_m(), 3.1);
}

TEST(CurveShape, is_refused_where_its_formulas_have_no_direction_or_no_end) {
  const auto still = [](double t) { return CurveFormulas::At{{t * t * t, 0.0}, {3.0 * t * t, 0.0}, {6.0 * t, 0.0}}; };
  EXPECT_THAT(fault_of({still, 1.0}), HasSubstr("its velocity vanishes"));
  const auto pole = [](double t) {
    return CurveFormulas::At{{t, 1.0 / (t - 1.0)}, {1.0, -1.0 / ((t - 1.0) * (t - 1.0))}, {}};
  };
  EXPECT_THAT(fault_of({pole, 2.0}), HasSubstr("section.invalid"));
  const auto line = [](double t) { return CurveFormulas::At{{t, 0.0}, {1.0, 0.0}, {}}; };
  EXPECT_EQ(fault_of({line, 1.0}), "none");
  EXPECT_THAT(fault_of({line, 0.0}), HasSubstr("empty range"));
  EXPECT_THAT(fault_of({line, -1.0}), HasSubstr("empty range"));
  EXPECT_THAT(fault_of({line, 1e6}), HasSubstr("must have a length"));
}

TEST(CurveShape, is_refused_where_its_derivatives_are_not_those_of_its_position) {
  const auto wrong_velocity = [](double t) { return CurveFormulas::At{{t, t * t}, {1.0, t}, {0.0, 1.0}}; };
  EXPECT_THAT(fault_of({wrong_velocity, 1.0}), HasSubstr("section.invalid"));
  const auto wrong_acceleration = [](double t) { return CurveFormulas::At{{t, t * t}, {1.0, 2.0 * t}, {0.0, 1.0}}; };
  EXPECT_THAT(fault_of({wrong_acceleration, 1.0}), HasSubstr("curvature"));
  const auto right = [](double t) { return CurveFormulas::At{{t, t * t}, {1.0, 2.0 * t}, {0.0, 2.0}}; };
  EXPECT_EQ(fault_of({right, 1.0}), "none");
}

}  // namespace
}  // namespace cosiva::zone
