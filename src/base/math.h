#pragma once

#include <cmath>

namespace cosiva {

inline constexpr double pi = 3.14159265358979323846;

/// Elementary functions that give the same bits on every machine: glibc's sine changes its last bit with the processor.
/// Errors stay under 1 ulp + 1e-16 absolute for |x| ≤ 1e6; arguments must be finite.
struct SinCos {
  double sin;
  double cos;
};
[[nodiscard]] SinCos sincos(double angle_rad) noexcept;
[[nodiscard]] double det_sin(double angle_rad) noexcept;
[[nodiscard]] double det_cos(double angle_rad) noexcept;
[[nodiscard]] double det_atan2(double y, double x) noexcept;
[[nodiscard]] double det_log(double x) noexcept;  ///< natural logarithm, x > 0
[[nodiscard]] double det_exp(double x) noexcept;  ///< |x| ≤ 700

/// The error function 2/√π·∫₀ˣ e^−t² dt, and one minus it, whose small values stay exact. Relative error under 1e-13.
[[nodiscard]] double det_erf(double x) noexcept;
[[nodiscard]] double det_erfc(double x) noexcept;

/// √(x² + y²); IEEE square root is exactly rounded everywhere.
[[nodiscard]] inline double norm(double x, double y) noexcept { return std::sqrt(x * x + y * y); }

/// The same angle in (−π, π].
[[nodiscard, gnu::const]] double wrap_angle(double angle_rad) noexcept;

}  // namespace cosiva
