#pragma once

#include "cosiva/aiv/estimation/algorithm.h"

/// The estimators of a pose on the plane, without a path.
namespace cosiva::estimation {

/// One step of odometry along an arc of a circle, the article's equation (1), of which (2) and (3) are the cases
/// without a turn.
[[nodiscard]] Pose2 moved(const Pose2& X_MB, const Odometry& odometry);
/// That step on its own: X_BB' of equation (1).
[[nodiscard]] Pose2 step_of(const Odometry& odometry);
[[nodiscard]] Matrix3 start_covariance(const Setting& setting);
/// A pose's covariance after one step from `X_MB` with odometry's noise, to first order.
[[nodiscard]] Matrix3 spread(const SensorModel& sensors, const Pose2& X_MB, const Odometry& odometry,
                             const Matrix3& covariance);
/// Length of a step, and its direction relative to the body's: straight ahead for a vehicle that cannot move sideways,
/// whose length is negative backwards.
struct StepCourse {
  double distance_m;
  double aside_rad;
};
[[nodiscard]] StepCourse course_of(const Odometry& odometry);
/// Variances of distance and turn of one step.
[[nodiscard]] Vector2 step_variances(const SensorModel& sensors, const Odometry& odometry);
/// The pose at an arc length, with the covariance due to the variances of the arc length and of the lateral offset.
[[nodiscard]] Estimate on_track(const Track& track, const SensorModel& sensors, double along_m, double variance_m2);
/// Of a range of about this length, for a filter that does not estimate the errors common to ranges: the filter treats
/// them as noise that is drawn anew each time, which they are not.
[[nodiscard]] double range_variance(const SensorModel& sensors, double range_m);
/// Of a reading, (along, across).
[[nodiscard]] Matrix2 fiducial_covariance(const SensorModel& sensors);

/// Innovations beyond these are refused: chi-squared of one and two dimensions at 99.9 %.
inline constexpr double gate_1 = 10.828;
inline constexpr double gate_2 = 13.816;

/// The extended Kalman filter of (x, y, heading) with gating, the usual choice in robotics. Once its gate refuses
/// correct measurements the filter diverges for good; it is included unchanged to demonstrate that. Source: S. Thrun,
/// W. Burgard, D. Fox, Probabilistic Robotics (2005), chapter 7. Invariant: no variance is negative but for rounding.
class Ekf : public Algorithm {
 public:
  explicit Ekf(Setting setting);
  void predict(const Odometry& odometry) override;
  Rectified rectify(const Reading& reading) override;
  Rectified rectify(const Range& range) override;
  [[nodiscard]] Estimate estimate() const override { return {current_estimate, doubt, std::nullopt}; }

 protected:
  Setting configured;
  Pose2 current_estimate;
  Matrix3 doubt;
};

/// The unscented Kalman filter, same state, same noise: seven points are moved instead of a tangent.
/// Source: S. Julier, J. Uhlmann, Unscented Filtering and Nonlinear Estimation, Proc. IEEE 92 (2004).
class Ukf final : public Ekf {
 public:
  using Ekf::Ekf;
  void predict(const Odometry& odometry) override;
  Rectified rectify(const Reading& reading) override;
  Rectified rectify(const Range& range) override;
};

/// The right-invariant extended Kalman filter on SE(2): its error obeys an equation that does not depend on the
/// estimate, so the filter does not become certain of an unobserved heading. Source: A. Barrau, S. Bonnabel, The
/// Invariant Extended Kalman Filter as a Stable Observer, IEEE TAC 62 (2017). Invariant: as of Ekf.
class InvariantEkf final : public Algorithm {
 public:
  explicit InvariantEkf(Setting setting);
  void predict(const Odometry& odometry) override;
  Rectified rectify(const Reading& reading) override;
  Rectified rectify(const Range& range) override;
  [[nodiscard]] Estimate estimate() const override;

 private:
  void correct(const Vector3& xi);
  Setting setting_;
  Pose2 pose_;
  Matrix3 covariance_;  ///< of ξ = (x, y, heading) in the map: X = exp(ξ)·X̂
};

}  // namespace cosiva::estimation
