#pragma once

#include <cmath>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/random.h"

namespace cosiva::physical {

/// Wheel encoders: they count the wheels' turns, not the body's motion. Wear scales the count, driven wheels slip under
/// acceleration (and slide under braking), and the ground adds a random walk.
class Odometer {
 public:
  Odometer(double scale_sd, double noise_m_per_sqrt_m, double slip_per_mps2, Random random)
      : noise_m_per_sqrt_m_{noise_m_per_sqrt_m}, slip_per_mps2_{slip_per_mps2}, random_{random} {
    scale_ = 1.0 + random_.gaussian(0.0, scale_sd);
  }

  /// @param distance_m  that the body moved, forwards positive
  /// @param acceleration_mps2  of the speed along the path, braking negative
  void add(double distance_m, double acceleration_mps2) {
    if (distance_m == 0.0) return;
    count_m_ += distance_m * (scale_ + slip_per_mps2_ * acceleration_mps2);
    if (noise_m_per_sqrt_m_ > 0.0)
      count_m_ += noise_m_per_sqrt_m_ * std::sqrt(std::fabs(distance_m)) * random_.gaussian();
  }
  /// In a manoeuvre both wheels turn as well, in the same direction or in opposite directions: the odometer integrates
  /// the resulting pose from zero and leaves the distance unchanged.
  void begin_manoeuvre() { X_SB_ = {}; }
  void add_manoeuvre(double turned_rad, double traversed_m) {
    if (turned_rad == 0.0 && traversed_m == 0.0) return;
    const double wheel_distance_m = traversed_m + half_track_m * std::fabs(turned_rad);
    double scale = scale_;
    if (noise_m_per_sqrt_m_ > 0.0) scale += noise_m_per_sqrt_m_ * random_.gaussian() / std::sqrt(wheel_distance_m);
    X_SB_ = X_SB_ * Pose2{scale * traversed_m, 0.0, scale * turned_rad};
  }
  /// In the frame of the manoeuvre's start; the heading is wrapped.
  // NOLINTNEXTLINE(readability-identifier-naming): frames are written so everywhere
  [[nodiscard]] const Pose2& X_SB() const { return X_SB_; }
  static constexpr double half_track_m = 0.05;  ///< from the body's centre to a wheel

  [[nodiscard]] double distance_m() const { return count_m_; }
  [[nodiscard]] double scale() const { return scale_; }
  /// The counter begins again, as after a loss of power.
  void restart() { count_m_ = 0.0; }
  void archive(Archive& archive);  ///< the counts, for a restart of the emulation

 private:
  double noise_m_per_sqrt_m_;
  double slip_per_mps2_;
  Random random_;
  double scale_;
  double count_m_{0.0};
  Pose2 X_SB_;
};

}  // namespace cosiva::physical
