#pragma once

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdint>

#include "cosiva/base/math.h"
#include "cosiva/base/math_inline.h"

/// The kernel is compiled once per width of vectors; its callees are included only if they are inlined.
#define COSIVA_PART __attribute__((always_inline))

/// The curved memberships without branches or library calls, so that a loop over them becomes vector instructions and
/// gives the same bits on every machine. Errors stay under 1e-15.
namespace cosiva::fuzzy {

/// e^x for any x except NaN; limited to x = ±700.
[[nodiscard]] COSIVA_PART inline double exponential(double x) noexcept {
  constexpr double log2_e = 1.44269504088896340736;
  constexpr double ln2_high = 6.93147180369123816490e-01;
  constexpr double ln2_low = 1.90821492927058770002e-10;
  const double bounded = std::max(-700.0, std::min(700.0, x));
  const double shifted = bounded * log2_e + plain::rounder;
  const double k = shifted - plain::rounder;
  const std::uint64_t power = std::bit_cast<std::uint64_t>(shifted) << 52U;
  const double r = (bounded - k * ln2_high) - k * ln2_low;
  // Taylor to r^13: |r| ≤ ln 2 / 2 leaves 4e-18.
  double p = 1.0 / 6227020800.0;
  p = p * r + 1.0 / 479001600.0;
  p = p * r + 1.0 / 39916800.0;
  p = p * r + 1.0 / 3628800.0;
  p = p * r + 1.0 / 362880.0;
  p = p * r + 1.0 / 40320.0;
  p = p * r + 1.0 / 5040.0;
  p = p * r + 1.0 / 720.0;
  p = p * r + 1.0 / 120.0;
  p = p * r + 1.0 / 24.0;
  p = p * r + 1.0 / 6.0;
  p = p * r + 0.5;
  p = p * r + 1.0;
  p = p * r + 1.0;
  return std::bit_cast<double>(std::bit_cast<std::uint64_t>(p) + power);
}

/// cos² of an angle; 0 beyond a quarter turn to either side.
[[nodiscard]] COSIVA_PART inline double cosine_bump(double angle) noexcept {
  const double half = 0.5 * std::max(-0.5 * pi, std::min(0.5 * pi, angle));
  const double sine = plain::sin_kernel(half);
  const double cosine = 1.0 - 2.0 * (sine * sine);
  return cosine * cosine;
}

/// t^exponent for t ≥ 0. Integer exponents, the usual ones, are computed by multiplication.
[[nodiscard]] COSIVA_PART inline double bell_power(double t, double exponent) noexcept {
  const auto whole = static_cast<std::uint32_t>(exponent);
  if (static_cast<double>(whole) == exponent) {
    double result = 1.0;
    double power = t;
    for (std::uint32_t bits = whole; bits != 0; bits >>= 1U) {
      if ((bits & 1U) != 0) result *= power;
      power *= power;
    }
    return result;
  }
  if (!(t > 0.0)) return 0.0;
  return exponential(exponent * det_log(std::min(t, 1e300)));
}

}  // namespace cosiva::fuzzy
