#pragma once

#include <deque>
#include <vector>

#include "cosiva/aiv/estimation/algorithm.h"

/// The estimators along a track: their state is an arc length.
namespace cosiva::estimation {

/// Follows the sections' own equations (1) to (3) with odometry alone: the article's predictor, and the reference for
/// the other algorithms. In the open it follows arcs of circles. Invariant: the arc length's variance is not negative.
class DeadReckoning : public Algorithm {
 public:
  explicit DeadReckoning(Setting setting);
  void predict(const Odometry& odometry) override;
  Rectified rectify(const Reading&) override { return {}; }
  Rectified rectify(const Range&) override { return {}; }
  [[nodiscard]] Estimate estimate() const override;

 protected:
  /// The vehicle's arc length according to a fiducial that was read, and its difference from the estimate; nothing: the
  /// fiducial is not near. Two contradicting readings that agree with each other move the search to them.
  struct Detection {
    double along_m;
    double innovation_m;
  };
  [[nodiscard]] std::optional<Detection> see(const Reading& reading);

  Setting configured;
  double s_m;   ///< s
  double p_m2;  ///< its variance

 private:
  Pose2 pose_;  ///< in the open
  Matrix3 covariance_;
  double doubt_m_{};  ///< along the track from the estimate to the position by the last contradicting reading
  bool doubting_{false};
};

/// The article's own rule: dead reckoning, and the fiducial's position on every reading.
class ResetRule final : public DeadReckoning {
 public:
  using DeadReckoning::DeadReckoning;
  using DeadReckoning::rectify;
  Rectified rectify(const Reading& reading) override;
};

/// A Kalman filter of the arc length: optimal where the path is followed and the noise is Gaussian. The speed is no
/// state: odometry measures distances, whose errors do not depend on the speed.
/// Source: R. E. Kalman, A New Approach to Linear Filtering and Prediction Problems, J. Basic Eng. 82 (1960).
class ArcKalman : public DeadReckoning {
 public:
  using DeadReckoning::DeadReckoning;
  using DeadReckoning::rectify;
  Rectified rectify(const Reading& reading) override;
};

/// Likewise with the odometer's scale as a second state: wheels wear, and a wrong scale is a bias that no number of
/// readings removes from a filter without this state. Invariant: no variance is negative but for rounding.
class ArcKalmanScale final : public DeadReckoning {
 public:
  explicit ArcKalmanScale(Setting setting);
  void predict(const Odometry& odometry) override;
  using DeadReckoning::rectify;
  Rectified rectify(const Reading& reading) override;
  [[nodiscard]] double scale_error() const { return scale_error_; }  ///< counted over true distance, minus one

 private:
  double scale_error_{0.0};
  double cross_m_{0.0};  ///< covariance of s and scale error
  double scale_variance_;
};

/// A smoother over the whole run: the arc-length Kalman filter forwards, then the smoother of Rauch, Tung and Striebel
/// backwards. Source: Maximum Likelihood Estimates of Linear Dynamic Systems, AIAA Journal 3 (1965).
/// Invariant: the last moment is the present estimate.
class ArcSmoother final : public ArcKalman {
 public:
  explicit ArcSmoother(Setting setting);
  void predict(const Odometry& odometry) override;
  using ArcKalman::rectify;
  Rectified rectify(const Reading& reading) override;
  [[nodiscard]] std::vector<Estimate> revised() override;

 private:
  struct Moment {
    double predicted_m;
    double predicted_variance_m2;
    double along_m;
    double variance_m2;
  };
  std::vector<Moment> moments_;
};

/// The unbiased FIR filter on the track: the mean of the arc lengths by the last readings, each moved on by odometry.
/// The filter needs no noise parameters except for the covariance that it states.
/// Source: J. Pomarico-Franquiz, Y. S. Shmaliy, Accurate Self-Localization in RFID Tag Information Grids Using FIR
/// Filtering, IEEE Trans. Industrial Informatics 10 (2014); their extended filter reduced to an arc length as state and
/// a linear model, where its gain is 1/n. Invariant: the estimate is a mean of at least one reading, at most `horizon`.
class UnbiasedFir final : public DeadReckoning {
 public:
  using DeadReckoning::DeadReckoning;
  void predict(const Odometry& odometry) override;
  using DeadReckoning::rectify;
  Rectified rectify(const Reading& reading) override;

 private:
  void average();
  struct PathSnap {
    double along_m;      ///< the vehicle's present arc length by this reading alone
    double rolled_m{0};  ///< since the reading
  };
  std::deque<PathSnap> snaps_;
};

}  // namespace cosiva::estimation
