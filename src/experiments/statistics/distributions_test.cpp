#include "cosiva/experiments/statistics/distributions.h"

#include <gtest/gtest.h>

#include <cmath>

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

}  // namespace
}  // namespace cosiva::statistics
