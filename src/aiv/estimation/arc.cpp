#include "cosiva/aiv/estimation/arc.h"

#include <cmath>
#include <utility>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"

namespace cosiva::estimation {
namespace {

/// A reading further off than this many standard deviations contradicts the estimate.
constexpr double gate_sigmas = 6.0;
/// Two contradicting readings agree when they differ by less than this, beyond the tolerance of odometry.
constexpr double agree_m = 0.05;
/// Rounding error of a variance that becomes small; NaN passes, and the estimate then shows it.
constexpr double variance_rounding = 1e-12;

double fiducial_variance(const Setting& setting) {
  const double sigma = setting.sensors.fiducial_along_sigma_m;
  return sigma * sigma;
}

}  // namespace

DeadReckoning::DeadReckoning(Setting setting)
    : configured{std::move(setting)},
      s_m{configured.start_along_m},
      p_m2{configured.start_sigma_m * configured.start_sigma_m},
      pose_{configured.start},
      covariance_{start_covariance(configured)} {}

void DeadReckoning::predict(const Odometry& odometry) {
  if (!configured.track) {
    covariance_ = spread(configured.sensors, pose_, odometry, covariance_);
    pose_ = moved(pose_, odometry);
  }
  s_m += odometry.distance_m;
  p_m2 += configured.sensors.distance_variance_per_m * std::fabs(odometry.distance_m) + odometry.distance_variance_m2;
  COSIVA_EXPECT(!(p_m2 < 0.0));
}

Estimate DeadReckoning::estimate() const {
  if (!configured.track) return {pose_, covariance_, std::nullopt};
  return on_track(*configured.track, configured.sensors, s_m, p_m2);
}

std::optional<DeadReckoning::Detection> DeadReckoning::see(const Reading& reading) {
  if (!configured.track) return std::nullopt;
  const double gate_m = gate_sigmas * std::sqrt(p_m2 + fiducial_variance(configured));
  // The foot of a fiducial on another branch of the path may lie near; the estimate selects the intended one.
  const double reach_m = std::fmax(1.0, 2.0 * gate_m);
  const auto foot_m = configured.track->foot(reading.fiducial_M, s_m + reading.detected_B.x_m, reach_m);
  if (!foot_m) return std::nullopt;
  const Detection detection{*foot_m - reading.detected_B.x_m, *foot_m - reading.detected_B.x_m - s_m};
  if (std::fabs(detection.innovation_m) <= gate_m) {
    doubting_ = false;
    return detection;
  }
  const bool agree = doubting_ && std::fabs(detection.innovation_m - doubt_m_) < agree_m;
  doubt_m_ = detection.innovation_m;
  doubting_ = !agree;
  if (!agree) return std::nullopt;
  // Two readings agree: the estimate was wrong, and its variance too.
  p_m2 = std::fmax(p_m2, detection.innovation_m * detection.innovation_m);
  return detection;
}

Rectified ResetRule::rectify(const Reading& reading) {
  const auto detection = see(reading);
  if (!detection) return {};
  const double expected = p_m2 + fiducial_variance(configured);
  s_m = detection->along_m;
  p_m2 = fiducial_variance(configured);
  return {true, detection->innovation_m * detection->innovation_m / expected, 1};
}

Rectified ArcKalman::rectify(const Reading& reading) {
  const auto detection = see(reading);
  if (!detection) return {};
  const double expected = p_m2 + fiducial_variance(configured);
  const double gain = p_m2 / expected;
  s_m += gain * detection->innovation_m;
  p_m2 *= 1.0 - gain;
  return {true, detection->innovation_m * detection->innovation_m / expected, 1};
}

ArcKalmanScale::ArcKalmanScale(Setting setting)
    : DeadReckoning{std::move(setting)},
      scale_variance_{configured.sensors.distance_scale_sigma * configured.sensors.distance_scale_sigma} {}

void ArcKalmanScale::predict(const Odometry& odometry) {
  // s' = s + d/(1 + e): F = [1, −d; 0, 1] in (s, e).
  const double d = odometry.distance_m / (1.0 + scale_error_);
  s_m += d;
  p_m2 += -2.0 * d * cross_m_ + d * d * scale_variance_ +
          configured.sensors.distance_variance_per_m * std::fabs(odometry.distance_m) + odometry.distance_variance_m2;
  cross_m_ -= d * scale_variance_;
}

Rectified ArcKalmanScale::rectify(const Reading& reading) {
  const auto detection = see(reading);
  if (!detection) return {};
  const double expected = p_m2 + fiducial_variance(configured);
  const double gain = p_m2 / expected;
  const double scale_gain_per_m = cross_m_ / expected;
  s_m += gain * detection->innovation_m;
  scale_error_ += scale_gain_per_m * detection->innovation_m;
  scale_variance_ -= scale_gain_per_m * cross_m_;
  COSIVA_EXPECT(!(scale_variance_ < -variance_rounding));
  cross_m_ *= 1.0 - gain;
  p_m2 *= 1.0 - gain;
  return {true, detection->innovation_m * detection->innovation_m / expected, 1};
}

ArcSmoother::ArcSmoother(Setting setting) : ArcKalman{std::move(setting)} {
  moments_.push_back({s_m, p_m2, s_m, p_m2});
}

void ArcSmoother::predict(const Odometry& odometry) {
  COSIVA_EXPECT(moments_.back().along_m == s_m);
  ArcKalman::predict(odometry);
  moments_.push_back({s_m, p_m2, s_m, p_m2});
}

Rectified ArcSmoother::rectify(const Reading& reading) {
  const Rectified rectified = ArcKalman::rectify(reading);
  moments_.back().along_m = s_m;
  moments_.back().variance_m2 = p_m2;
  return rectified;
}

std::vector<Estimate> ArcSmoother::revised() {
  std::vector<Estimate> all(moments_.size() - 1);
  double along_m = moments_.back().along_m;
  double variance_m2 = moments_.back().variance_m2;
  for (std::size_t i = moments_.size(); i-- > 1;) {
    all[i - 1] = on_track(*configured.track, configured.sensors, along_m, variance_m2);
    const Moment& here = moments_[i - 1];
    const Moment& next = moments_[i];
    const double gain = next.predicted_variance_m2 > 0.0 ? here.variance_m2 / next.predicted_variance_m2 : 0.0;
    along_m = here.along_m + gain * (along_m - next.predicted_m);
    variance_m2 = here.variance_m2 + gain * gain * (variance_m2 - next.predicted_variance_m2);
  }
  return all;
}

void UnbiasedFir::predict(const Odometry& odometry) {
  DeadReckoning::predict(odometry);
  for (PathSnap& entry_point : snaps_) {
    entry_point.along_m += odometry.distance_m;
    entry_point.rolled_m += std::fabs(odometry.distance_m);
  }
}

Rectified UnbiasedFir::rectify(const Reading& reading) {
  const auto detection = see(reading);
  if (!detection) return {};
  const double expected = p_m2 + fiducial_variance(configured);
  snaps_.push_back({detection->along_m});
  while (snaps_.size() > configured.horizon) snaps_.pop_front();
  average();
  return {true, detection->innovation_m * detection->innovation_m / expected, 1};
}

void UnbiasedFir::average() {
  COSIVA_EXPECT(!snaps_.empty() && snaps_.size() <= configured.horizon);
  const auto n = static_cast<double>(snaps_.size());
  s_m = 0.0;
  p_m2 = fiducial_variance(configured) / n;
  for (std::size_t i = 0; i < snaps_.size(); ++i) {
    s_m += snaps_[i].along_m / n;
    // The distance since a reading is part of all the older ones, too: 0…i have the distance driven since i in common.
    const double shared = 2.0 * static_cast<double>(i) + 1.0;
    p_m2 += configured.sensors.distance_variance_per_m * snaps_[i].rolled_m * shared / (n * n);
  }
}

}  // namespace cosiva::estimation
