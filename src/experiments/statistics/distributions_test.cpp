#include "cosiva/experiments/statistics/distributions.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/base/math.h"

namespace cosiva::statistics {
namespace {

// From published tables, and closed forms where available.
TEST(Distributions, quantiles_equal_the_tables) {
  EXPECT_NEAR(normal_quantile(0.975), 1.959963984540054, 1e-12);
  EXPECT_NEAR(normal_quantile(0.001), -3.090232306167814, 1e-12);
  EXPECT_NEAR(chi_squared_quantile(0.95, 1.0), 3.841458820694124, 1e-10);
  EXPECT_NEAR(chi_squared_quantile(0.95, 2.0), -2.0 * std::log(0.05), 1e-10);
  EXPECT_NEAR(chi_squared_quantile(0.95, 10.0), 18.307038053275146, 1e-9);
  EXPECT_NEAR(chi_squared_quantile(0.025, 100.0), 74.22192747492373, 1e-8);
  EXPECT_NEAR(student_quantile(0.975, 9.0), 2.2621571628540993, 1e-10);
  EXPECT_NEAR(student_quantile(0.975, 1.0), std::tan(0.475 * 3.14159265358979323846), 1e-9);
}

TEST(Distributions, a_quantile_is_the_inverse_of_its_distribution) {
  for (const double p : {1e-4, 0.03, 0.5, 0.8, 0.9999}) {
    EXPECT_NEAR(normal_cdf(normal_quantile(p)), p, 1e-12);
    for (const double degrees : {1.0, 2.5, 30.0, 20000.0}) {
      EXPECT_NEAR(chi_squared_cdf(chi_squared_quantile(p, degrees), degrees), p, 1e-9) << degrees;
      EXPECT_NEAR(student_cdf(student_quantile(p, degrees), degrees), p, 1e-9) << degrees;
    }
  }
}

TEST(Distributions, agree_with_the_library_where_available) {
  for (double z = -8.0; z < 8.0; z += 0.13) EXPECT_NEAR(normal_cdf(z), 0.5 * std::erfc(-z / std::sqrt(2.0)), 1e-15);
  // Two degrees of freedom: 1 − e^(−x/2).
  for (double x = 0.01; x < 60.0; x += 0.7) EXPECT_NEAR(chi_squared_cdf(x, 2.0), -std::expm1(-0.5 * x), 1e-13);
  EXPECT_EQ(chi_squared_cdf(0.0, 3.0), 0.0);
}

// Reference values from mpmath with 30 digits.
TEST(Distributions, log_gamma_equals_the_reference_for_small_and_large_arguments) {
  EXPECT_NEAR(log_gamma(0.1), 2.2527126517342, 1e-12);
  EXPECT_NEAR(log_gamma(0.5), 0.5 * std::log(3.14159265358979323846), 1e-13);
  EXPECT_NEAR(log_gamma(1.0), 0.0, 1e-13);
  EXPECT_NEAR(log_gamma(3.7), 1.4280723266654, 1e-12);
  EXPECT_NEAR(log_gamma(5.0), std::log(24.0), 1e-13);
  EXPECT_NEAR(log_gamma(11.9), 17.258477450596, 1e-11);
  EXPECT_NEAR(log_gamma(12.0), std::log(39916800.0), 3e-14);  // the last of the five terms is 2e-13
  EXPECT_NEAR(log_gamma(12.5), 18.734347511936, 1e-11);
  EXPECT_NEAR(log_gamma(100.25), 360.28455963776, 1e-10);
}

TEST(Distributions, the_incomplete_beta_function_equals_the_reference) {
  EXPECT_NEAR(incomplete_beta(2.5, 3.5, 0.3), 0.29675298929567, 1e-12);
  EXPECT_NEAR(incomplete_beta(2.5, 3.5, 0.7), 0.92281906547792, 1e-12);
  EXPECT_NEAR(incomplete_beta(0.5, 0.5, 0.1), 0.20483276469913, 1e-12);
  EXPECT_NEAR(incomplete_beta(10.0, 0.5, 0.9), 0.15164090963471, 1e-12);
  EXPECT_NEAR(incomplete_beta(30.0, 40.0, 0.45), 0.64474800855857, 1e-12);
  EXPECT_NEAR(incomplete_beta(0.75, 20.0, 0.02), 0.4653756842019, 1e-12);
  EXPECT_NEAR(incomplete_beta(200.0, 300.0, 0.41), 0.67762816477218, 1e-11);
  // I_x(a, 1) = x^a, I_x(1, b) = 1 − (1 − x)^b.
  for (const double x : {0.01, 0.3, 0.5, 0.8, 0.99}) {
    EXPECT_NEAR(incomplete_beta(3.0, 1.0, x), x * x * x, 1e-13) << x;
    EXPECT_NEAR(incomplete_beta(1.0, 2.0, x), 1.0 - (1.0 - x) * (1.0 - x), 1e-13) << x;
  }
  EXPECT_EQ(incomplete_beta(2.0, 3.0, 0.0), 0.0);
  EXPECT_EQ(incomplete_beta(2.0, 3.0, -1.0), 0.0);
  EXPECT_EQ(incomplete_beta(2.0, 3.0, 1.0), 1.0);
  EXPECT_EQ(incomplete_beta(2.0, 3.0, 2.0), 1.0);
}

TEST(Distributions, chi_squared_equals_the_reference_and_the_closed_forms) {
  EXPECT_NEAR(chi_squared_cdf(0.3, 1.0), 0.41611757922963, 1e-12);
  EXPECT_NEAR(chi_squared_cdf(2.0, 5.0), 0.15085496391539, 1e-12);
  EXPECT_NEAR(chi_squared_cdf(9.0, 5.0), 0.89093584205023, 1e-12);
  EXPECT_NEAR(chi_squared_cdf(11.0, 9.5), 0.68413055532168, 1e-12);
  EXPECT_NEAR(chi_squared_cdf(160.0, 200.0), 0.017108313035133, 1e-12);
  EXPECT_NEAR(chi_squared_cdf(250.0, 200.0), 0.99062086833117, 1e-12);
  for (double x = 0.05; x < 40.0; x += 0.37) {
    const double h = 0.5 * x;
    EXPECT_NEAR(chi_squared_cdf(x, 1.0), std::erf(std::sqrt(h)), 1e-13) << x;
    EXPECT_NEAR(chi_squared_cdf(x, 4.0), 1.0 - (1.0 + h) * std::exp(-h), 1e-13) << x;
    EXPECT_NEAR(chi_squared_cdf(x, 6.0), 1.0 - (1.0 + h + 0.5 * h * h) * std::exp(-h), 1e-13) << x;
  }
  EXPECT_EQ(chi_squared_cdf(-1.0, 3.0), 0.0);
  EXPECT_EQ(chi_squared_cdf(1e5, 3.0), 1.0);
  EXPECT_EQ(chi_squared_cdf(1e-5, 10'000.0), 0.0);
  // A quantile far above the degrees of freedom plus ten.
  EXPECT_NEAR(chi_squared_quantile(0.999999, 2.0), -2.0 * std::log(1e-6), 1e-8);
}

TEST(Distributions, student_s_equals_the_closed_forms_of_one_two_and_four_degrees) {
  for (double t = -30.0; t <= 30.0; t += 0.37) {
    EXPECT_NEAR(student_cdf(t, 1.0), 0.5 + std::atan(t) / 3.14159265358979323846, 1e-13) << t;
    EXPECT_NEAR(student_cdf(t, 2.0), 0.5 + t / (2.0 * std::sqrt(2.0 + t * t)), 1e-13) << t;
    const double r = t / std::sqrt(4.0 + t * t);
    EXPECT_NEAR(student_cdf(t, 4.0), 0.5 + 0.75 * (r - r * r * r / 3.0), 1e-13) << t;
  }
  EXPECT_DOUBLE_EQ(student_cdf(0.0, 7.0), 0.5);
  // A quantile far beyond ten, and one on each side of the centre.
  EXPECT_NEAR(student_quantile(1e-4, 1.0) / -std::tan(0.4999 * 3.14159265358979323846), 1.0, 1e-9);
  for (const double p : {0.01, 0.3, 0.7, 0.99})
    EXPECT_NEAR(student_quantile(p, 2.0), (2.0 * p - 1.0) / std::sqrt(2.0 * p * (1.0 - p)), 1e-10) << p;
  EXPECT_NEAR(student_quantile(0.5, 3.0), 0.0, 1e-7);  // its square is below the last bit of 1
  EXPECT_NEAR(normal_quantile(0.5), 0.0, 1e-12);
}

// The fractions take thousands of steps about the centre of a narrow distribution. With a = d/2: P(a, a) is
// 1/2 + 1/(3√(2πa)), and the density next to it 1/√(2πa), both but for terms of 1/a (NIST DLMF 8.11.12).
TEST(Distributions, of_a_million_degrees_of_freedom_are_computed_to_the_end) {
  constexpr double a = 500'000.0;
  const double density = 1.0 / std::sqrt(2.0 * 3.14159265358979323846 * a);
  EXPECT_NEAR(chi_squared_cdf(2.0 * a, 2.0 * a), 0.5 + density / 3.0, 1e-8);
  EXPECT_NEAR(chi_squared_cdf(2.0 * (a + 2.0), 2.0 * a), 0.5 + density / 3.0 + 2.0 * density, 1e-8);
  EXPECT_NEAR(incomplete_beta(a, a, 0.5), 0.5, 1e-8);
  EXPECT_NEAR(incomplete_beta(a, a, 0.5 - 1e-6) + incomplete_beta(a, a, 0.5 + 1e-6), 1.0, 1e-8);
}

TEST(Distributions, have_no_quantile_of_what_is_no_probability) {
  for (const double p : {0.0, 1.0, -0.5, 1.5}) {
    EXPECT_DEATH(static_cast<void>(normal_quantile(p)), "p > 0.0 && p < 1.0") << p;
    EXPECT_DEATH(static_cast<void>(chi_squared_quantile(p, 3.0)), "p > 0.0 && p < 1.0 && degrees > 0.0") << p;
    EXPECT_DEATH(static_cast<void>(student_quantile(p, 3.0)), "p > 0.0 && p < 1.0 && degrees > 0.0") << p;
  }
  EXPECT_DEATH(static_cast<void>(chi_squared_quantile(0.5, 0.0)), "degrees > 0.0");
  EXPECT_DEATH(static_cast<void>(student_quantile(0.5, 0.0)), "degrees > 0.0");
  // Less than one degree of freedom is possible: Welch's test may have it, and F with a half each is symmetric.
  EXPECT_NEAR(chi_squared_cdf(chi_squared_quantile(0.3, 0.5), 0.5), 0.3, 1e-9);
  EXPECT_NEAR(student_cdf(student_quantile(0.3, 0.5), 0.5), 0.3, 1e-9);
}

// Where the probability is tiny, or one only but for the last digits, only one of the two series converges.
TEST(Distributions, are_relatively_exact_far_out_in_their_tails) {
  EXPECT_NEAR(student_cdf(-1e6, 1.0) / (std::atan(1e-6) / pi), 1.0, 1e-11);
  EXPECT_NEAR(incomplete_beta(1.0, 20.0, 1e-13) / -std::expm1(20.0 * std::log1p(-1e-13)), 1.0, 1e-11);
  EXPECT_NEAR(incomplete_beta(3.0, 1.0, 1e-5) / 1e-15, 1.0, 1e-11);
  EXPECT_NEAR(incomplete_beta(0.5, 0.5, 1e-12) / (2.0 / pi * std::asin(1e-6)), 1.0, 1e-11);
  EXPECT_NEAR(chi_squared_cdf(1e-14, 1.0) / std::erf(std::sqrt(5e-15)), 1.0, 1e-11);
  EXPECT_NEAR(chi_squared_cdf(1e-6, 2.0) / -std::expm1(-5e-7), 1.0, 1e-11);
}

TEST(Distributions, are_exact_close_to_the_centre_of_student_s) {
  for (const double t : {-1e-5, 1e-5}) {
    EXPECT_NEAR(student_cdf(t, 1.0), 0.5 + std::atan(t) / pi, 2e-11) << t;
    EXPECT_NEAR(student_cdf(t, 2.0), 0.5 + t / (2.0 * std::sqrt(2.0 + t * t)), 2e-11) << t;
  }
}

TEST(Distributions, are_zero_below_the_smallest_normal_number) {
  // ln of the first factor is 100·ln 0.0271 − 0.0271 − ln Γ(100) = −720, and e^−720 is less than 2.2e-308.
  EXPECT_EQ(chi_squared_cdf(0.0542, 200.0), 0.0);
}

}  // namespace
}  // namespace cosiva::statistics
