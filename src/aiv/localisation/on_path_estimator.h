#pragma once

#include <cmath>
#include <optional>
#include <vector>

#include "cosiva/aiv/localisation/course_position.h"
#include "cosiva/aiv/localisation/estimator_model.h"
#include "cosiva/aiv/localisation/position_fix.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::aiv {

/// The estimated position along the circuit and its uncertainty: fed by odometry, rectified at tags, at beacons, and at
/// joints where PILS waits or turns (A21).
/// Invariant: the variance is not negative, and a contradicting beacon is stored only while the position is known.
class OnPathEstimator {
 public:
  /// @param circuit  must outlive this object
  OnPathEstimator(const zone::Circuit& circuit, const EstimatorModel& model) : model_{model}, path_{circuit} {}

  /// A position on the circuit is known: the vehicle's, or of an off-path vehicle the one where it joins the path.
  [[nodiscard]] bool known() const { return known_; }
  /// Meaningful only while the position is known.
  [[nodiscard]] const CoursePosition& path() const { return path_; }
  /// Standard deviation along the circuit [m].
  [[nodiscard]] double sigma_m() const;

  void position_at(zone::TrackPosition position);
  /// Jumps to a position that coincides with the estimated one; the uncertainty stays the same.
  void take_same_position(zone::TrackPosition position);
  /// The vehicle leaves the path, or is found off it.
  /// @param entry_point  where it will join the path; nothing: no path is near, and the position becomes unknown
  void leave_path(std::optional<zone::TrackPosition> entry_point);
  /// The vehicle joins the path here. The position is known.
  void aim(zone::TrackPosition position) { path_.jump_without_course(position); }
  /// A manoeuvre ended on the path, here: the uncertainty does not become smaller.
  void land_on(zone::TrackPosition position);
  /// As PositionEstimator::follow().
  void follow(const zone::Course& course) { path_.follow(course); }
  /// The vehicle turns into this section, at the end of the present one.
  void expect_turn(zone::SectionId next) { path_.expect_next(next); }
  /// The uncertainty of `before`, an estimate of the same vehicle.
  void take_over_variance(const OnPathEstimator& before) { variance_m2_ = before.variance_m2_; }
  /// The vehicle has driven: less certain by that distance.
  void on_driven(double step_m) { variance_m2_ += model_.variance_per_m * std::fabs(step_m); }
  /// The odometer restarted: the distance driven meanwhile is not known.
  void on_odometer_reset() { variance_m2_ += model_.sigma_reset_m * model_.sigma_reset_m; }
  void forget_doubt() { doubt_.reset(); }

  /// Moves the position; returns the distance moved. Only while it is known.
  double shift(double distance_m) { return path_.shift(distance_m); }
  /// PILS does not move although commanded to: it is at a joint that it does not cross. Returns the correction [m].
  double on_stuck();
  /// PILS begins to turn: the vehicle is at the bend. Returns the correction [m], 0 where no bend is near.
  double on_turn_begun();
  /// PILS has turned by this angle at the end of the present section. What that did to the estimate; nothing, and no
  /// change: no branch lies in that direction.
  [[nodiscard]] std::optional<FixKind> on_turn_ended(double turned_rad);

  /// The antenna has detected a tag.
  /// @param latency_m    driven since the reading
  /// @param travelled_m  of the vehicle's own odometer
  PositionFix on_tag(zone::TrackPosition tag, double latency_m, double travelled_m);
  /// Likewise a beacon, while the position is known.
  PositionFix on_beacon(Point2 beacon, double latency_m, double travelled_m);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Sighting {
    Point2 beacon;
    double travelled_m;
  };
  PositionFix on_strange_beacon(Point2 beacon, double latency_m, double travelled_m);
  PositionFix jump_to(zone::TrackPosition position);
  /// A joint at which PILS waits or turns lies this near ahead of the estimate.
  [[nodiscard]] double joint_gate_m() const;
  [[nodiscard]] std::optional<zone::SectionId> turned_to(double turned_rad) const;

  EstimatorModel model_;
  bool known_{false};
  CoursePosition path_;
  double variance_m2_{};
  std::optional<Sighting> doubt_;  ///< the last beacon, when it contradicted the estimate
};

/// The nearest position on the circuit to a pose, within `distance_m_max` and in a similar direction; nothing
/// otherwise.
[[nodiscard]] std::optional<zone::TrackPosition> position_on_circuit(const zone::Circuit& circuit, const Pose2& X_MB,
                                                                     double distance_m_max);

/// Positions on other sections that coincide with this one, nearest first: at a joint, and where sections lie on one
/// another.
[[nodiscard]] std::vector<zone::TrackPosition> same_positions(const zone::Circuit& circuit,
                                                              zone::TrackPosition position);

}  // namespace cosiva::aiv
