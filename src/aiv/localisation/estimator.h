#pragma once

#include <cstdint>
#include <optional>

#include "cosiva/aiv/localisation/distance_counter.h"
#include "cosiva/aiv/localisation/estimator_model.h"
#include "cosiva/aiv/localisation/off_path_estimator.h"
#include "cosiva/aiv/localisation/on_path_estimator.h"
#include "cosiva/aiv/localisation/position_fix.h"
#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/circuit/course.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The estimated pose of the vehicle: the article's motion on the circuit fed by odometry, rectified at tags and
/// beacons (A21). Unknown until a position is given or a tag is read.
///
/// The estimate advances along a course (OnPathEstimator). Off the path the estimate is a pose (OffPathEstimator):
/// while the vehicle turns, and where it is off-path (near a path: with the position where it will join that path) or
/// away from all paths. Invariant: a vehicle near a path, to join it, has the known position on the circuit where it
/// will do so.
class PositionEstimator {
 public:
  /// @param zone  must outlive the estimator
  explicit PositionEstimator(const zone::TrafficZone& zone, const EstimatorModel& model = {});

  /// A position on the circuit is known: the vehicle can drive, or (beside) join the path there.
  [[nodiscard]] bool known() const { return on_path_.known(); }
  [[nodiscard]] zone::TrackPosition track_position() const { return on_path_.path().track_position(); }
  /// pose() is defined. Without a known position on the circuit the vehicle is away from all paths.
  [[nodiscard]] bool pose_known() const { return known() || off_path_.has_pose(); }
  [[nodiscard]] Pose2 pose() const { return off_path_.has_pose() ? off_path_.pose() : on_path_.path().pose(); }
  /// Off the path, and near enough to join it at track_position().
  [[nodiscard]] bool near_path() const { return known() && off_path_.near_path(); }
  /// No path is under the vehicle, or need be: the vehicle turns, or is off-path or away.
  [[nodiscard]] bool off_path() const { return off_path_.has_pose() || off_path_.manoeuvring(); }
  [[nodiscard]] Outlook outlook() const;
  /// Total of all odometry steps, forwards positive, without corrections.
  [[nodiscard]] double travelled_m() const { return counter_.travelled_m(); }

  /// The course, and the uncertainty along it, which grows with the distance since the last fix.
  [[nodiscard]] const OnPathEstimator& on_path_estimator() const { return on_path_; }
  /// The manoeuvre, and the distance to the circuit.
  [[nodiscard]] const OffPathEstimator& off_path_estimator() const { return off_path_; }
  [[nodiscard]] const DistanceCounter& counter() const { return counter_; }
  /// The last tag of the zone that was read, and travelled_m() when the vehicle passed it.
  struct LastTag {
    zone::TagNumber number;
    double travelled_m;
  };
  [[nodiscard]] const std::optional<LastTag>& last_tag() const { return last_tag_; }

  /// The position is given: configuration, state file, initPosition.
  void position_at(zone::TrackPosition position);
  /// Selects one of the same_positions(), because the route is known; the uncertainty stays the same.
  void take_same_position(zone::TrackPosition position);
  /// The pose is given, on the path or off it (zone::snap_to_path).
  void set_off_path(const Pose2& X_MB);
  /// For an off-path vehicle: it joins the path here, not at the nearest position.
  void aim(zone::TrackPosition position);
  /// A manoeuvre was in progress when it was saved: how far it had come, and the section that it leads to if it is a
  /// turn at the end of track_position().section.
  void resume_manoeuvre(const Pose2& X_OB, std::optional<zone::SectionId> next);
  /// In another zone with the same body: pose and odometer stay, and the vehicle is on no path until it joins one. Only
  /// on the same circuit in the other direction the vehicle stays on its path.
  void take_over(const PositionEstimator& before);

  /// The vehicle's course: on the present section now. The traversed sections stay if they are known.
  void follow(const zone::Course& course) { on_path_.follow(course); }

  /// Takes a reading of the odometer, and of PILS's motion off the path; the end of a manoeuvre is a fix.
  EstimateStep on_odometry(const wire::Odometry& odometry);
  /// The board counts from zero again: the next reading is a new origin, and the distance driven meanwhile is not
  /// known.
  void on_odometer_reset();
  /// PILS stays where it is although commanded to drive: it is at a joint that it does not cross. Returns the
  /// correction [m].
  double on_stuck();

  /// @param number     a tag's, or a beacon's
  /// @param age_s      age of the reading when its frame was sent
  /// @param speed_mps  of the vehicle since
  PositionFix on_tag(std::uint32_t number, double age_s, double speed_mps);
  /// The beacons have been moved: the last contradicting beacon has no meaning any more.
  void forget_doubt() { on_path_.forget_doubt(); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  const zone::TrafficZone& zone_;
  double reading_latency_s_;
  DistanceCounter counter_;
  OnPathEstimator on_path_;
  OffPathEstimator off_path_;
  std::optional<LastTag> last_tag_;
};

}  // namespace cosiva::aiv
