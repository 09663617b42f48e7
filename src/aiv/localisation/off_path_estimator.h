#pragma once

#include <optional>

#include "cosiva/aiv/localisation/estimator_model.h"
#include "cosiva/aiv/localisation/on_path_estimator.h"
#include "cosiva/aiv/localisation/position_fix.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::aiv {

/// The estimated pose of a vehicle that is on no path: it turns on the spot, joins a path by a manoeuvre, or is stopped
/// away from all paths. Functions that put the vehicle onto a path, or off it, take the estimate on the path along.
/// Invariant: a vehicle that is near a path, to join it, has a pose off the path.
class OffPathEstimator {
 public:
  explicit OffPathEstimator(const EstimatorModel& model) : landed_m_{model.landed_m}, landed_rad_{model.landed_rad} {}

  /// The vehicle has a pose off the path.
  [[nodiscard]] bool has_pose() const { return X_MO_.has_value(); }
  /// Only while it has one.
  [[nodiscard]] Pose2 pose() const { return X_OB_ ? *X_MO_ * *X_OB_ : *X_MO_; }
  /// Near enough to a path to join it.
  [[nodiscard]] bool near_path() const { return near_path_; }
  /// Distance from the circuit to an off-path vehicle.
  [[nodiscard]] double off_by_m() const { return off_by_m_; }
  /// PILS is in a manoeuvre.
  [[nodiscard]] bool manoeuvring() const { return X_OB_.has_value(); }
  /// Where the manoeuvre began, or where the vehicle is off the path; and how far the manoeuvre has come.
  [[nodiscard]] const std::optional<Pose2>& left_line_at() const { return X_MO_; }
  [[nodiscard]] const std::optional<Pose2>& manoeuvred() const { return X_OB_; }

  /// The vehicle's pose is given: on the path, or away from it.
  void set(const Pose2& X_MB, OnPathEstimator& on_path);
  /// The vehicle's position on the path is given: a manoeuvre of PILS in progress began there.
  void on_path_at(const Pose2& X_MB);
  /// As PositionEstimator::resume_manoeuvre(); the vehicle's pose is known.
  void resume_manoeuvre(const Pose2& X_OB, double travelled_m, const OnPathEstimator& on_path);
  /// The manoeuvre of `before`, on the floor of another zone.
  void take_over_manoeuvre(const OffPathEstimator& before);

  /// Takes a reading of PILS in a manoeuvre or off the path.
  /// @param step_m       since the last reading
  /// @param travelled_m  of the vehicle's own odometer, the step included
  EstimateStep on_odometry(double step_m, double travelled_m, const wire::Odometry& odometry, OnPathEstimator& on_path);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void roll(double step_m, OnPathEstimator& on_path, EstimateStep& result);
  void begin_manoeuvre(double travelled_m, OnPathEstimator& on_path, EstimateStep& result);
  void end_manoeuvre(bool line_lost, OnPathEstimator& on_path, EstimateStep& result);
  void land(const Pose2& X_MB, bool line_lost, OnPathEstimator& on_path, EstimateStep& result);
  void find_path();

  double landed_m_;            ///< as in EstimatorModel
  double landed_rad_;          ///< likewise
  std::optional<Pose2> X_MO_;  ///< start of the turn, or the pose off the path; nothing: on the path
  std::optional<Pose2> X_OB_;  ///< the manoeuvre as PILS reports it
  bool near_path_{false};
  double off_by_m_{};
  double strayed_m_{};              ///< driven off the path, in no manoeuvre
  double manoeuvre_travelled_m_{};  ///< the odometer does not count during a manoeuvre
  bool on_old_floor_{false};        ///< the present manoeuvre began before the zone was switched
};

}  // namespace cosiva::aiv
