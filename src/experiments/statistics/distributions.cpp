#include "cosiva/experiments/statistics/distributions.h"

#include <cmath>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::statistics {
namespace {

/// e^x, with zero for underflow.
double exp_or_zero(double x) { return x < -700.0 ? 0.0 : det_exp(x); }

/// The regularised incomplete gamma function P(a, x).
double gamma_p(double a, double x) {
  if (x <= 0.0) return 0.0;
  const double front = exp_or_zero(a * det_log(x) - x - log_gamma(a));
  if (x < a + 1.0) {
    double term = 1.0 / a;
    double sum = term;
    for (double n = a + 1.0; term > sum * 1e-17; n += 1.0) {
      term *= x / n;
      sum += term;
    }
    return sum * front;
  }
  // Lentz's continued fraction for Q = 1 − P.
  double b = x + 1.0 - a;
  double c = 1e300;
  double d = 1.0 / b;
  double h = d;
  for (int i = 1; i < 100'000; ++i) {
    const double an = -i * (i - a);
    b += 2.0;
    d = 1.0 / (an * d + b);
    c = b + an / c;
    const double delta = d * c;
    h *= delta;
    if (delta == 1.0) break;
  }
  return 1.0 - front * h;
}

/// Lentz's continued fraction of the incomplete beta function.
double beta_fraction(double a, double b, double x) {
  constexpr double tiny = 1e-300;
  const auto kept = [](double v) { return std::fabs(v) < tiny ? tiny : v; };
  double c = 1.0;
  double d = 1.0 / kept(1.0 - (a + b) * x / (a + 1.0));
  double h = d;
  for (int m = 1; m < 10'000; ++m) {
    const double even = m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m));
    d = 1.0 / kept(1.0 + even * d);
    c = kept(1.0 + even / c);
    h *= d * c;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1));
    d = 1.0 / kept(1.0 + odd * d);
    c = kept(1.0 + odd / c);
    const double delta = d * c;
    h *= delta;
    if (delta == 1.0) break;
  }
  return h;
}

/// The argument at which a rising function reaches p, by bisection.
template <typename Cdf>
double inverse(const Cdf& cdf, double p, double low, double high) {
  for (int i = 0; i < 200; ++i) {
    const double centre = 0.5 * (low + high);
    if (centre == low || centre == high) break;
    (cdf(centre) < p ? low : high) = centre;
  }
  return 0.5 * (low + high);
}

}  // namespace

double log_gamma(double x) {
  double shift = 0.0;
  while (x < 12.0) {
    shift -= det_log(x);
    x += 1.0;
  }
  const double z = 1.0 / (x * x);
  const double series =
      (1.0 / 12.0 + z * (-1.0 / 360.0 + z * (1.0 / 1260.0 + z * (-1.0 / 1680.0 + z * (1.0 / 1188.0))))) / x;
  return shift + (x - 0.5) * det_log(x) - x + 0.91893853320467274178 + series;
}

double incomplete_beta(double a, double b, double x) {
  if (x <= 0.0) return 0.0;
  if (x >= 1.0) return 1.0;
  const double front =
      exp_or_zero(log_gamma(a + b) - log_gamma(a) - log_gamma(b) + a * det_log(x) + b * det_log(1.0 - x));
  if (x < (a + 1.0) / (a + b + 2.0)) return front * beta_fraction(a, b, x) / a;
  return 1.0 - front * beta_fraction(b, a, 1.0 - x) / b;
}

double normal_cdf(double z) { return 0.5 * det_erfc(-z * 0.70710678118654752440); }

double normal_quantile(double p) {
  COSIVA_EXPECT(p > 0.0 && p < 1.0);
  if (p > 0.5) return -normal_quantile(1.0 - p);
  return inverse(normal_cdf, p, -40.0, 0.0);
}

double chi_squared_cdf(double x, double degrees) { return gamma_p(0.5 * degrees, 0.5 * x); }

double chi_squared_quantile(double p, double degrees) {
  COSIVA_EXPECT(p > 0.0 && p < 1.0 && degrees > 0.0);
  double high = degrees + 10.0;
  while (chi_squared_cdf(high, degrees) < p) high *= 2.0;
  return inverse([&](double x) { return chi_squared_cdf(x, degrees); }, p, 0.0, high);
}

double student_cdf(double t, double degrees) {
  const double tail = 0.5 * incomplete_beta(0.5 * degrees, 0.5, degrees / (degrees + t * t));
  return t < 0.0 ? tail : 1.0 - tail;
}

double student_quantile(double p, double degrees) {
  COSIVA_EXPECT(p > 0.0 && p < 1.0 && degrees > 0.0);
  if (p > 0.5) return -student_quantile(1.0 - p, degrees);
  double low = -10.0;
  while (student_cdf(low, degrees) > p) low *= 2.0;
  return inverse([&](double t) { return student_cdf(t, degrees); }, p, low, 0.0);
}

}  // namespace cosiva::statistics
