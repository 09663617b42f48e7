#pragma once

#include <deque>
#include <vector>

#include "cosiva/aiv/estimation/algorithm.h"

/// The estimators that go along a track: their state is an arc length.
namespace cosiva::estimation {

/// Follows the sections' own equations (1) to (3) with what odometry counted, and believes nothing else: the article's
/// predictor, and what the others are measured against. In the open it follows arcs of circles.
class DeadReckoning : public Algorithm {
 public:
  explicit DeadReckoning(Setting setting);
  void predict(const Odometry& odometry) override;
  Rectified rectify(const Reading&) override { return {}; }
  Rectified rectify(const Range&) override { return {}; }
  [[nodiscard]] Estimate estimate() const override;

 protected:
  /// Where on the track the mark that was read puts the vehicle, and how far that is from the belief; nothing: nowhere
  /// near. Two strange readings that agree move the search to them.
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
  double doubt_m_{};  ///< along the track from the belief to where the last strange reading would put it
  bool doubting_{false};
};

/// The article's own rule: dead reckoning, and the mark's place on every reading.
class ResetRule final : public DeadReckoning {
 public:
  using DeadReckoning::DeadReckoning;
  using DeadReckoning::rectify;
  Rectified rectify(const Reading& reading) override;
};

/// A Kalman filter of the arc length: optimal where the line is followed and the noise is Gaussian. The speed is not in
/// its state: odometry tells distances, whose errors know nothing of the speed.
/// Source: R. E. Kalman, A New Approach to Linear Filtering and Prediction Problems, J. Basic Eng. 82 (1960).
class ArcKalman : public DeadReckoning {
 public:
  using DeadReckoning::DeadReckoning;
  using DeadReckoning::rectify;
  Rectified rectify(const Reading& reading) override;
};

/// Likewise with the odometer's scale as a second state: wheels wear, and a wrong scale is a bias that no amount of
/// readings takes from a filter that does not know of it.
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

/// Looks back over the whole run: the arc-length Kalman filter forwards, then the smoother of Rauch, Tung and Striebel
/// backwards. Source: Maximum Likelihood Estimates of Linear Dynamic Systems, AIAA Journal 3 (1965).
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

/// The unbiased FIR filter on the track: the mean of where each of the last readings, moved on by odometry, puts the
/// vehicle. It needs no noise figures but for the covariance that it states.
/// Source: J. Pomarico-Franquiz, Y. S. Shmaliy, Accurate Self-Localization in RFID Tag Information Grids Using FIR
/// Filtering, IEEE Trans. Industrial Informatics 10 (2014); of their extended filter what is left where the state is an
/// arc length and the model linear, since its gain is then 1/n.
class UnbiasedFir final : public DeadReckoning {
 public:
  using DeadReckoning::DeadReckoning;
  void predict(const Odometry& odometry) override;
  using DeadReckoning::rectify;
  Rectified rectify(const Reading& reading) override;

 private:
  void average();
  struct PathSnap {
    double along_m;      ///< where this reading alone puts the vehicle now
    double rolled_m{0};  ///< since
  };
  std::deque<PathSnap> snaps_;
};

}  // namespace cosiva::estimation
