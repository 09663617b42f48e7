#include "cosiva/experiments/statistics/special.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/experiments/statistics/distributions.h"

namespace cosiva::statistics {
namespace {

/// The density of √(χ²/degrees) at u > 0.
double scale_density(double u, double degrees, double log_front) {
  return det_exp(log_front + (degrees - 1.0) * det_log(u) - 0.5 * degrees * u * u);
}

/// The mean of a function of √(χ²/degrees), by Simpson's rule over the range with significant density.
template <typename Function>
double mean_over_scale(double degrees, const Function& function) {
  constexpr int panels = 600;
  const double log_front = 0.69314718055994530942 + 0.5 * degrees * det_log(0.5 * degrees) - log_gamma(0.5 * degrees);
  const double reach = 9.0 / std::sqrt(2.0 * degrees);
  const double low = std::max(1e-9, 1.0 - reach);
  const double step = (1.0 + reach - low) / panels;
  double sum = 0.0;
  for (int i = 0; i <= panels; ++i) {
    const double u = low + i * step;
    const double weight = i == 0 || i == panels ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    sum += weight * scale_density(u, degrees, log_front) * function(u);
  }
  return sum * step / 3.0;
}

}  // namespace

double fisher_cdf(double f, double numerator_degrees, double denominator_degrees) {
  COSIVA_EXPECT(numerator_degrees > 0.0 && denominator_degrees > 0.0);
  if (f <= 0.0) return 0.0;
  const double x = numerator_degrees * f / (numerator_degrees * f + denominator_degrees);
  return incomplete_beta(0.5 * numerator_degrees, 0.5 * denominator_degrees, x);
}

double shifted_student_cdf(double t, double degrees, double shift) {
  COSIVA_EXPECT(degrees > 0.0);
  return mean_over_scale(degrees, [&](double u) { return normal_cdf(t * u - shift); });
}

double shifted_student_quantile(double p, double degrees, double shift) {
  COSIVA_EXPECT(p > 0.0 && p < 1.0);
  double low = shift - 10.0;
  double high = shift + 10.0;
  while (shifted_student_cdf(low, degrees, shift) > p) low = shift + 2.0 * (low - shift);
  while (shifted_student_cdf(high, degrees, shift) < p) high = shift + 2.0 * (high - shift);
  for (int i = 0; i < 60 && high - low > 1e-11 * std::fabs(high); ++i) {
    const double centre = 0.5 * (low + high);
    (shifted_student_cdf(centre, degrees, shift) < p ? low : high) = centre;
  }
  return 0.5 * (low + high);
}

}  // namespace cosiva::statistics
