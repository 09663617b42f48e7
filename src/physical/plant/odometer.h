#pragma once

#include <cmath>

#include "base/random.h"

namespace cosiva::physical {

/// Wheel encoders: they count what the wheels turned, not what the body moved. Worn wheels scale it, driving wheels
/// slip when they accelerate (and slide when they brake), and the ground adds a random walk.
class Odometer {
 public:
  Odometer(double scale_sd, double noise_m_per_sqrt_m, double slip_per_mps2, Random random)
      : noise_m_per_sqrt_m_{noise_m_per_sqrt_m}, slip_per_mps2_{slip_per_mps2}, random_{random} {
    scale_ = 1.0 + random_.gaussian(0.0, scale_sd);
  }

  /// @param distance_m  that the body moved, forwards positive
  /// @param acceleration_mps2  of the speed along its way, braking negative
  void add(double distance_m, double acceleration_mps2) {
    if (distance_m == 0.0) return;
    count_m_ += distance_m * (scale_ + slip_per_mps2_ * acceleration_mps2);
    if (noise_m_per_sqrt_m_ > 0.0)
      count_m_ += noise_m_per_sqrt_m_ * std::sqrt(std::fabs(distance_m)) * random_.gaussian();
  }
  [[nodiscard]] double distance_m() const { return count_m_; }
  [[nodiscard]] double scale() const { return scale_; }

 private:
  double noise_m_per_sqrt_m_;
  double slip_per_mps2_;
  Random random_;
  double scale_;
  double count_m_{0.0};
};

}  // namespace cosiva::physical
