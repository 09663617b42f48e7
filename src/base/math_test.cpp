#include "cosiva/base/math.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/base/random.h"

namespace cosiva {
namespace {

/// The accuracy stated in base/math.h, with a margin for the reference's own rounding: 1 ulp + 1e-16, doubled.
double allowed(double reference) {
  const double next = std::nextafter(std::fabs(reference), std::numeric_limits<double>::infinity());
  return 2.0 * (next - std::fabs(reference)) + 2e-16;
}

template <typename Own, typename Reference>
void expect_close_over(double low, double high, const Own& own, const Reference& reference) {
  Random random{1, "math_test"};
  for (int i = 0; i < 200'000; ++i) {
    const double x = random.uniform(low, high);
    // The reference in long double, so that only the tested function's error is measured.
    const auto wanted = static_cast<double>(reference(static_cast<long double>(x)));
    ASSERT_NEAR(own(x), wanted, allowed(wanted)) << "at x = " << x;
  }
}

long double sine(long double x) { return std::sin(x); }
long double cosine(long double x) { return std::cos(x); }

TEST(Math, sine_and_cosine_agree_with_the_library_near_zero_and_far_away) {
  for (const double reach : {1e-3, 0.8, 7.0, 1e3, 1e6}) {
    expect_close_over(
        -reach, reach, [](double x) { return det_sin(x); }, sine);
    expect_close_over(
        -reach, reach, [](double x) { return det_cos(x); }, cosine);
  }
}

TEST(Math, error_function_agrees_with_the_library_also_for_large_arguments) {
  for (double x = -6.0; x <= 6.0; x += 0.0037) {
    ASSERT_NEAR(det_erf(x), std::erf(x), 2e-15) << x;
    ASSERT_NEAR(det_erfc(x) / std::erfc(x), 1.0, x < 2.0 ? 1e-12 : 1e-13) << x;
  }
  EXPECT_EQ(det_erf(0.0), 0.0);
  EXPECT_NEAR(det_erfc(20.0) / std::erfc(20.0), 1.0, 1e-13);
  EXPECT_EQ(det_erfc(30.0), 0.0);
  EXPECT_EQ(det_erf(-1.3), -det_erf(1.3));
}

TEST(Math, sincos_gives_both_values) {
  for (const double x : {-3.0, -0.1, 0.0, 2.0, 1e5}) {
    EXPECT_EQ(sincos(x).sin, det_sin(x));
    EXPECT_EQ(sincos(x).cos, det_cos(x));
  }
}

TEST(Math, sine_is_odd_and_cosine_even_to_the_last_bit) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "math_test"};
    const double x = random.uniform(-100.0, 100.0);
    RC_ASSERT(det_sin(-x) == -det_sin(x));
    RC_ASSERT(det_cos(-x) == det_cos(x));
  }));
}

TEST(Math, sine_of_zero_is_zero_and_cosine_one) {
  EXPECT_EQ(det_sin(0.0), 0.0);
  EXPECT_EQ(det_cos(0.0), 1.0);
  EXPECT_EQ(det_sin(pi / 2.0), 1.0);
  EXPECT_NEAR(det_cos(pi / 2.0), 6.123e-17, 1e-19);  // the rounding error of pi / 2 as a double
}

TEST(Math, atan2_agrees_with_the_library_in_all_quadrants) {
  Random random{2, "math_test"};
  for (int i = 0; i < 200'000; ++i) {
    const double scale = det_exp(random.uniform(-20.0, 20.0));
    const double y = scale * random.uniform(-1.0, 1.0);
    const double x = random.uniform(-1.0, 1.0);
    const double wanted = std::atan2(y, x);
    ASSERT_NEAR(det_atan2(y, x), wanted, 2.0 * allowed(wanted)) << y << ", " << x;
  }
}

TEST(Math, atan2_is_exact_on_the_axes_and_respects_signed_zeros) {
  EXPECT_EQ(det_atan2(0.0, 1.0), 0.0);
  EXPECT_EQ(det_atan2(1.0, 0.0), pi / 2.0);
  EXPECT_EQ(det_atan2(-1.0, 0.0), -pi / 2.0);
  EXPECT_EQ(det_atan2(0.0, -1.0), pi);
  EXPECT_EQ(det_atan2(-0.0, -1.0), -pi);
  EXPECT_EQ(det_atan2(0.0, 0.0), 0.0);
  EXPECT_EQ(det_atan2(0.0, -0.0), pi);
  EXPECT_EQ(det_atan2(-0.0, -0.0), -pi);
  EXPECT_TRUE(std::signbit(det_atan2(-0.0, 0.0)));
  EXPECT_NEAR(det_atan2(1.0, 1.0), pi / 4.0, 2e-16);
}

TEST(Math, atan2_accepts_the_smallest_and_the_largest_numbers) {
  constexpr double tiny = std::numeric_limits<double>::denorm_min();
  constexpr double huge = std::numeric_limits<double>::max();
  for (const double y : {tiny, 1.0, huge}) {
    for (const double x : {tiny, 1.0, huge, -tiny, -1.0, -huge}) {
      EXPECT_NEAR(det_atan2(y, x), std::atan2(y, x), 1e-15) << y << ", " << x;
      EXPECT_NEAR(det_atan2(-y, x), std::atan2(-y, x), 1e-15) << -y << ", " << x;
    }
  }
}

TEST(Math, logarithm_agrees_with_the_library) {
  Random random{3, "math_test"};
  for (int i = 0; i < 200'000; ++i) {
    const double x = std::ldexp(random.uniform(0.5, 1.0), static_cast<int>(random.below(2000)) - 1000);
    const double wanted = std::log(x);
    ASSERT_NEAR(det_log(x), wanted, allowed(wanted)) << x;
  }
  expect_close_over(
      0.5, 2.0, [](double x) { return det_log(x); }, [](long double x) { return std::log(x); });
  EXPECT_EQ(det_log(1.0), 0.0);
}

TEST(Math, exponential_agrees_with_the_library) {
  Random random{4, "math_test"};
  for (int i = 0; i < 200'000; ++i) {
    const double x = random.uniform(-700.0, 700.0);
    const double wanted = std::exp(x);
    ASSERT_NEAR(det_exp(x) / wanted, 1.0, 4e-16) << x;
  }
  EXPECT_EQ(det_exp(0.0), 1.0);
}

TEST(Math, logarithm_inverts_exponential) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "math_test"};
    const double x = random.uniform(-600.0, 600.0);
    RC_ASSERT(std::fabs(det_log(det_exp(x)) - x) < 1e-15 + 4e-16 * std::fabs(x));
  }));
}

TEST(Math, norm_is_the_euclidean_length) {
  EXPECT_EQ(norm(3.0, -4.0), 5.0);
  EXPECT_EQ(norm(0.0, 0.0), 0.0);
}

TEST(Math, wraps_angles_into_one_turn_open_at_minus_pi) {
  EXPECT_EQ(wrap_angle(0.5), 0.5);
  EXPECT_EQ(wrap_angle(pi), pi);
  EXPECT_EQ(wrap_angle(-pi), pi);
  EXPECT_NEAR(wrap_angle(3.0 * pi), pi, 1e-15);
  EXPECT_NEAR(wrap_angle(1.5 * pi), -0.5 * pi, 1e-15);
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "math_test"};
    const double angle = random.uniform(-1e5, 1e5);
    const double wrapped = wrap_angle(angle);
    RC_ASSERT(wrapped > -pi && wrapped <= pi);
    RC_ASSERT(std::fabs(det_sin(wrapped) - det_sin(angle)) < 1e-10);
    RC_ASSERT(std::fabs(det_cos(wrapped) - det_cos(angle)) < 1e-10);
  }));
}

TEST(Math, wraps_angles_at_the_limit_into_the_interval) {
  for (const double turns : {-3.0, -1.0, 1.0, 2.0, 1000.0}) {
    for (const double edge : {-pi, pi}) {
      double angle = edge + turns * 2.0 * pi;
      for (int i = 0; i < 5; ++i) angle = std::nextafter(angle, -1e9);
      for (int i = 0; i < 10; ++i, angle = std::nextafter(angle, 1e9)) {
        EXPECT_GT(wrap_angle(angle), -pi);
        EXPECT_LE(wrap_angle(angle), pi);
      }
    }
  }
}

}  // namespace
}  // namespace cosiva
