#include "cosiva/base/gaussians.h"

#include <bit>
#include <cmath>

#include "cosiva/base/log_kernel.h"
#include "cosiva/base/vector_clones.h"

namespace cosiva {
namespace {

constexpr std::size_t pairs = 32;

/// det_log() of a normal number above 0, without a branch.
__attribute__((always_inline)) inline double log_of(double x) noexcept {
  const auto bits = std::bit_cast<std::uint64_t>(x);
  // m in [½, 1); 2^52 with the exponent in its lowest bits gives the exponent as a double.
  double m = std::bit_cast<double>((bits & 0x000FFFFFFFFFFFFFULL) | 0x3FE0000000000000ULL);
  double exponent = std::bit_cast<double>((bits >> 52U) | 0x4330000000000000ULL) - 4503599627370496.0 - 1022.0;
  const bool low = m < 0.70710678118654752440;
  m = low ? 2.0 * m : m;
  exponent = low ? exponent - 1.0 : exponent;
  return plain::log_kernel(m, exponent);
}

/// The second half of Marsaglia's polar method: points in the unit circle become two draws each.
COSIVA_VECTOR_CLONES
void spread(const double* __restrict u, const double* __restrict v, const double* __restrict q,
            double* __restrict made) {
  double scale[pairs];
  for (std::size_t i = 0; i < pairs; ++i) scale[i] = std::sqrt(-2.0 * log_of(q[i]) / q[i]);
  for (std::size_t i = 0; i < pairs; ++i) {
    made[2 * i] = u[i] * scale[i];
    made[2 * i + 1] = v[i] * scale[i];
  }
}

}  // namespace

void Gaussians::make() noexcept {
  static_assert(std::tuple_size_v<decltype(made_)> == 2 * pairs);
  double u[pairs];
  double v[pairs];
  double q[pairs];
  for (std::size_t i = 0; i < pairs;) {
    u[i] = 2.0 * random_.uniform() - 1.0;
    v[i] = 2.0 * random_.uniform() - 1.0;
    q[i] = u[i] * u[i] + v[i] * v[i];
    if (q[i] < 1.0 && q[i] != 0.0) ++i;
  }
  spread(u, v, q, made_.data());
  at_ = 0;
}

}  // namespace cosiva
