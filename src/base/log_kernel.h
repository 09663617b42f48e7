#pragma once

#include "cosiva/base/math_inline.h"

namespace cosiva::plain {

/// ln 2 in two parts, the first with so few bits that its product with an exponent of a double is exact.
inline constexpr double ln2_high = 6.93147180369123816490e-01;
inline constexpr double ln2_low = 1.90821492927058770002e-10;

/// log(m·2^exponent) for m in [√½, √2): log m = 2·atanh((m−1)/(m+1)) by its series, which is written out so that the
/// divisions are evaluated at compile time.
[[nodiscard]] COSIVA_INLINE double log_kernel(double m, double exponent) noexcept {
  const double t = (m - 1.0) / (m + 1.0);
  const double z = t * t;
  double p = 1.0 / 21.0;
  p = 1.0 / 19.0 + z * p;
  p = 1.0 / 17.0 + z * p;
  p = 1.0 / 15.0 + z * p;
  p = 1.0 / 13.0 + z * p;
  p = 1.0 / 11.0 + z * p;
  p = 1.0 / 9.0 + z * p;
  p = 1.0 / 7.0 + z * p;
  p = 1.0 / 5.0 + z * p;
  p = 1.0 / 3.0 + z * p;
  const double log_m = 2.0 * (t + t * (z * p));
  return exponent * ln2_high + (log_m + exponent * ln2_low);
}

}  // namespace cosiva::plain
