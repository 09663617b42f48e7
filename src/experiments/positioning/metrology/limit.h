#pragma once

#include <optional>
#include <span>
#include <vector>

#include "cosiva/experiments/positioning/metrology/trial.h"

/// The posterior Cramér-Rao limit of a vehicle on its path: the error that no estimator can surpass with these sensors
/// for Gaussian noise. Along the track, in steady state; the line-following variance adds across it.
namespace cosiva::experiments {

/// @param variance_per_m  q of odometry
/// @param pitch_m         d between beacons
/// @param fiducial_variance_m2  R of a reading; with reads missed at 1 − p, R/p gives a lower bound
struct Regime {
  double variance_per_m;
  double pitch_m;
  double fiducial_variance_m2;
};

/// Variance just after a beacon and just before the next, from the Riccati equation (P⁻)² − QP⁻ − QR = 0 with Q = q·d.
struct Sawtooth {
  double after_m2;
  double before_m2;
};
[[nodiscard]] Sawtooth sawtooth(const Regime& regime);
/// RMSE of the best filter, √(S/2) with S = √(Q² + 4QR).
[[nodiscard]] double filter_limit_m(const Regime& regime);
/// RMSE of the best smoother, √((QR + Q²/6)/S).
[[nodiscard]] double smoother_limit_m(const Regime& regime);
/// RMSE of the article's rule, √(R + Q/2): not a limit, but the rule's own error.
[[nodiscard]] double reset_rule_m(const Regime& regime);
/// The best filter's precision: the ratio of the path on which |error along the track| < τ.
[[nodiscard]] double precision_limit(const Regime& regime, double threshold_m);
/// The widest pitch at which the best filter's RMSE stays within a tolerance; nothing where no pitch does.
[[nodiscard]] std::optional<double> pitch_for(double rmse_m, double variance_per_m, double fiducial_variance_m2);

/// The same for the actual readings of a run at any positions: mean squared error along the track of the best filter
/// and of the best smoother over its moments, line-following included.
struct RunLimit {
  double filter_m2{};
  double smoother_m2{};
};
[[nodiscard]] RunLimit limit_of(const Trial& run);

}  // namespace cosiva::experiments
