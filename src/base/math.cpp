#include "base/math.h"

#include <bit>
#include <cmath>
#include <cstdint>

namespace cosiva {
namespace {

// π/2 in two parts, the first with 33 bits, so that k·π/2 is subtracted without rounding for |k| < 2^20 (Cody and
// Waite).
constexpr double half_pi_high = 1.57079632673412561417e+00;
constexpr double half_pi_low = 6.07710050650619224932e-11;

/// Taylor series to x^17 and x^16: beyond |x| = π/4 the next terms stay under 1e-17.
double sin_kernel(double x) {
  const double z = x * x;
  double p = 1.0 / 355687428096000.0;
  p = p * z - 1.0 / 1307674368000.0;
  p = p * z + 1.0 / 6227020800.0;
  p = p * z - 1.0 / 39916800.0;
  p = p * z + 1.0 / 362880.0;
  p = p * z - 1.0 / 5040.0;
  p = p * z + 1.0 / 120.0;
  p = p * z - 1.0 / 6.0;
  return x + x * (z * p);
}

double cos_kernel(double x) {
  const double z = x * x;
  double p = 1.0 / 20922789888000.0;
  p = p * z - 1.0 / 87178291200.0;
  p = p * z + 1.0 / 479001600.0;
  p = p * z - 1.0 / 3628800.0;
  p = p * z + 1.0 / 40320.0;
  p = p * z - 1.0 / 720.0;
  p = p * z + 1.0 / 24.0;
  return 1.0 - (0.5 * z - z * z * p);
}

/// atan on [0, 1] by two halvings: atan x = 2·atan(x / (1 + √(1 + x²))) brings |x| under 0.2, then the series to x^23.
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

SinCos sincos(double angle_rad) noexcept {
  const double k = std::nearbyint(angle_rad * (2.0 / pi));
  const double x = (angle_rad - k * half_pi_high) - k * half_pi_low;
  const double s = sin_kernel(x);
  const double c = cos_kernel(x);
  switch (static_cast<std::int64_t>(k) & 3) {
    case 0: return {s, c};
    case 1: return {c, -s};
    case 2: return {-s, -c};
    default: return {-c, s};
  }
}

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
  // x = m·2^e with m in [√½, √2); log m = 2·atanh((m−1)/(m+1)) by its series.
  int exponent = 0;
  double m = std::frexp(x, &exponent);
  if (m < 0.70710678118654752440) {
    m *= 2.0;
    --exponent;
  }
  const double t = (m - 1.0) / (m + 1.0);
  const double z = t * t;
  double p = 0.0;
  for (int n = 21; n >= 3; n -= 2) p = 1.0 / n + z * p;
  const double log_m = 2.0 * (t + t * (z * p));
  constexpr double ln2_high = 6.93147180369123816490e-01;
  constexpr double ln2_low = 1.90821492927058770002e-10;
  return exponent * ln2_high + (log_m + exponent * ln2_low);
}

double det_exp(double x) noexcept {
  constexpr double ln2_high = 6.93147180369123816490e-01;
  constexpr double ln2_low = 1.90821492927058770002e-10;
  const double k = std::nearbyint(x * 1.44269504088896340736);
  const double r = (x - k * ln2_high) - k * ln2_low;
  double p = 1.0;
  for (int n = 14; n >= 1; --n) p = 1.0 + r / n * p;
  return std::ldexp(p, static_cast<int>(k));
}

double norm(double x, double y) noexcept { return std::sqrt(x * x + y * y); }

double wrap_angle(double angle_rad) noexcept {
  if (angle_rad > -pi && angle_rad <= pi) return angle_rad;
  const double turns = std::nearbyint(angle_rad / (2.0 * pi));
  double wrapped = (angle_rad - turns * 4.0 * half_pi_high) - turns * 4.0 * half_pi_low;
  if (wrapped <= -pi) wrapped += 2.0 * pi;
  if (wrapped > pi) wrapped -= 2.0 * pi;
  return wrapped;
}

}  // namespace cosiva
