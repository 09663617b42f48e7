#pragma once

#include <bit>
#include <cstdint>

#include "cosiva/base/math.h"

/// The elementary functions of base/math.h for passes over arrays: without branches or calls, so that a loop over them
/// becomes vector instructions. They give exactly the bits of those functions, which are implemented with them.
namespace cosiva::plain {

/// Inlined into the calling function, and so into each of its versions for wider vectors.
#define COSIVA_INLINE __attribute__((always_inline)) inline

/// Adding 1.5·2^52 rounds a number under 2^51 to the nearest integer, halves to even, which is then in the lowest bits.
inline constexpr double rounder = 6755399441055744.0;
[[nodiscard]] COSIVA_INLINE double round_even(double x) noexcept { return (x + rounder) - rounder; }

/// π/2 in two parts, the first with 33 bits, so that k·π/2 is subtracted without rounding for |k| < 2^20 (Cody and
/// Waite).
inline constexpr double half_pi_high = 1.57079632673412561417e+00;
inline constexpr double half_pi_low = 6.07710050650619224932e-11;

/// Taylor series to x^17 and x^16: beyond |x| = π/4 the next terms stay under 1e-17.
[[nodiscard]] COSIVA_INLINE double sin_kernel(double x) noexcept {
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

[[nodiscard]] COSIVA_INLINE double cos_kernel(double x) noexcept {
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

/// cosiva::sincos.
[[nodiscard]] COSIVA_INLINE SinCos sincos(double angle_rad) noexcept {
  const double shifted = angle_rad * (2.0 / pi) + rounder;
  const double k = shifted - rounder;
  const double x = (angle_rad - k * half_pi_high) - k * half_pi_low;
  const double s = sin_kernel(x);
  const double c = cos_kernel(x);
  const auto quarter = std::bit_cast<std::uint64_t>(shifted);
  const bool odd = (quarter & 1U) != 0;
  const double sin = odd ? c : s;
  const double cos = odd ? s : c;
  return {(quarter & 2U) != 0 ? -sin : sin, ((quarter + 1U) & 2U) != 0 ? -cos : cos};
}

/// cosiva::wrap_angle.
[[nodiscard]] COSIVA_INLINE double wrap_angle(double angle_rad) noexcept {
  const double turns = round_even(angle_rad / (2.0 * pi));
  double wrapped = (angle_rad - turns * 4.0 * half_pi_high) - turns * 4.0 * half_pi_low;
  wrapped = wrapped <= -pi ? wrapped + 2.0 * pi : wrapped;
  wrapped = wrapped > pi ? wrapped - 2.0 * pi : wrapped;
  return angle_rad > -pi && angle_rad <= pi ? angle_rad : wrapped;
}

}  // namespace cosiva::plain
