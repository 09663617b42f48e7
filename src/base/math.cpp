#include "cosiva/base/math.h"

#include <cmath>

#include "cosiva/base/log_kernel.h"
#include "cosiva/base/math_inline.h"

namespace cosiva {
namespace {

/// atan on [0, 1] by two halvings: atan x = 2·atan(x / (1 + √(1 + x²))) reduces |x| below 0.2, then the series to x^23.
double atan_unit(double x) {
  x = x / (1.0 + std::sqrt(1.0 + x * x));
  x = x / (1.0 + std::sqrt(1.0 + x * x));
  const double z = x * x;
  double p = 0.0;
  for (int n = 23; n >= 3; n -= 2) {
    const double term = 1.0 / n;
    p = (((n - 1) / 2) % 2 == 0 ? term : -term) + z * p;
  }
  return 4.0 * (x + x * (z * p));
}

}  // namespace

SinCos sincos(double angle_rad) noexcept { return plain::sincos(angle_rad); }

double det_sin(double angle_rad) noexcept { return sincos(angle_rad).sin; }
double det_cos(double angle_rad) noexcept { return sincos(angle_rad).cos; }

double det_atan2(double y, double x) noexcept {
  const double ax = std::fabs(x);
  const double ay = std::fabs(y);
  if (ax == 0.0 && ay == 0.0) return std::signbit(x) ? (std::signbit(y) ? -pi : pi) : y;
  double angle = ay <= ax ? atan_unit(ay / ax) : 0.5 * pi - atan_unit(ax / ay);
  if (std::signbit(x)) angle = pi - angle;
  return std::signbit(y) ? -angle : angle;
}

double det_log(double x) noexcept {
  // x = m·2^exponent with m in [√½, √2).
  int exponent = 0;
  double m = std::frexp(x, &exponent);
  if (m < 0.70710678118654752440) {
    m *= 2.0;
    --exponent;
  }
  return plain::log_kernel(m, exponent);
}

double det_exp(double x) noexcept {
  const double k = std::nearbyint(x * 1.44269504088896340736);
  const double r = (x - k * plain::ln2_high) - k * plain::ln2_low;
  double p = 1.0;
  for (int n = 14; n >= 1; --n) p = 1.0 + r / n * p;
  return std::ldexp(p, static_cast<int>(k));
}

namespace {

constexpr double two_over_root_pi = 1.12837916709551257390;

/// erf by its series of positive terms, e^−x²·2/√π·Σ 2ⁿx²ⁿ⁺¹/(2n+1)!!, for 0 ≤ x ≤ 2.
double erf_series(double x) {
  const double z = 2.0 * x * x;
  double term = x;
  double sum = x;
  for (double n = 3.0; term > sum * 1e-18; n += 2.0) {
    term *= z / n;
    sum += term;
  }
  return two_over_root_pi * det_exp(-x * x) * sum;
}

/// erfc by its continued fraction, from the inside out, for x ≥ 2.
double erfc_fraction(double x) {
  if (x > 26.0) return 0.0;
  double f = 0.0;
  for (int n = 120; n >= 1; --n) f = 0.5 * n / (x + f);
  return 0.5 * two_over_root_pi * det_exp(-x * x) / (x + f);
}

}  // namespace

double det_erf(double x) noexcept {
  const double a = std::fabs(x);
  const double value = a < 2.0 ? erf_series(a) : 1.0 - erfc_fraction(a);
  return x < 0.0 ? -value : value;
}

double det_erfc(double x) noexcept {
  if (x < 0.0) return 1.0 + det_erf(-x);
  return x < 2.0 ? 1.0 - erf_series(x) : erfc_fraction(x);
}

double wrap_angle(double angle_rad) noexcept {
  if (angle_rad > -pi && angle_rad <= pi) return angle_rad;
  return plain::wrap_angle(angle_rad);
}

}  // namespace cosiva
