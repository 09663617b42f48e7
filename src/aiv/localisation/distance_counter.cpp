#include "cosiva/aiv/localisation/distance_counter.h"

#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

double DistanceCounter::count(std::int64_t distance_um) {
  const auto before_um = reading_um_;
  reading_um_ = distance_um;
  if (!before_um) return 0.0;
  // Unsigned, because a damaged counter may jump from one end to the other.
  const auto step_um =
      static_cast<std::int64_t>(static_cast<std::uint64_t>(distance_um) - static_cast<std::uint64_t>(*before_um));
  const double step_m = static_cast<double>(step_um) * 1e-6;
  if (std::fabs(step_m) > step_m_max_) return 0.0;
  travelled_m_ += step_m;
  COSIVA_EXPECT(std::isfinite(travelled_m_));
  return step_m;
}

void DistanceCounter::take_over(const DistanceCounter& before) {
  travelled_m_ = before.travelled_m_;
  reading_um_ = before.reading_um_;
}

void DistanceCounter::archive(Archive& archive) { archive(travelled_m_, reading_um_); }

}  // namespace cosiva::aiv
