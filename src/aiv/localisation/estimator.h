#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "cosiva/aiv/motion/motion.h"
#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/circuit/course.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The vehicle's model of its own sensors, with gates against wrong measurements.
struct EstimatorModel {
  double sigma_start_m{0.01};        ///< standard deviation of a position that was given
  double sigma_fix_m{0.004};         ///< after a tag or beacon
  double variance_per_m{1e-4};       ///< of odometry: 1 cm per √m
  double antenna_range_m{0.020};     ///< a tag is reported when it enters the field: this far before the antenna is
                                     ///< over it
  double reading_latency_s{0.020};   ///< from the field to the age stamp of the frame, and the transfer of the frame
  double beacon_gate_m{0.30};        ///< a beacon further from the estimate than this contradicts it
  double tag_gate_m{0.60};           ///< likewise a tag
  double sigma_reset_m{0.05};        ///< added when the odometer restarts
  double odometry_step_m_max{0.50};  ///< a larger step between two readings means that the board counts from zero again
  double bend_gate_m{0.15};          ///< a vehicle that turns on the spot, or stops at a fork, is at the joint this
                                     ///< near ahead; after a long distance without a fix the search extends further
  double landed_m{0.06};             ///< a manoeuvre that ends this near to a path,
  double landed_rad{0.30};           ///< and with this heading error, has brought the vehicle onto the path
};

/// The estimated pose of the vehicle: the article's motion on the circuit fed by odometry, rectified at tags and
/// beacons (A21). Unknown until a position is given or a tag is read.
///
/// The estimate advances along a course, and without further information only as far as is certain: not over a fork
/// whose branch is undecided, and not over a joint where the vehicle turns on the spot, before that turn. Off the path
/// the estimate is a pose: while the vehicle turns, and where it is off-path (`beside`: with a position where it will
/// join the path) or away from all paths.
class PositionEstimator {
 public:
  explicit PositionEstimator(const zone::TrafficZone& zone, EstimatorModel model = {});

  /// A position on the circuit is known: the vehicle can drive, or (beside) join the path there.
  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] zone::TrackPosition track_position() const { return motion_.track_position(zone_.circuit); }
  /// pose() is defined.
  [[nodiscard]] bool pose_known() const { return known_ || X_MO_.has_value(); }
  [[nodiscard]] Pose2 pose() const;
  [[nodiscard]] const AivMotion& motion() const { return motion_; }
  /// Off the path, and near enough to join it at place().
  [[nodiscard]] bool near_path() const { return known_ && near_path_; }
  /// The pose is known, and no path is near.
  [[nodiscard]] bool away() const { return !known_ && X_MO_.has_value(); }
  /// Distance from the circuit to an off-path vehicle.
  [[nodiscard]] double off_by_m() const { return off_by_m_; }
  /// PILS is in a manoeuvre.
  [[nodiscard]] bool manoeuvring() const { return X_OB_.has_value(); }
  /// No path is under the vehicle, or need be: the vehicle turns, or is off-path or away.
  [[nodiscard]] bool off_path() const { return X_MO_.has_value() || X_OB_.has_value(); }
  /// Where the manoeuvre began, or where the vehicle is off the path; and how far the manoeuvre has come.
  [[nodiscard]] const std::optional<Pose2>& left_line_at() const { return X_MO_; }
  [[nodiscard]] const std::optional<Pose2>& manoeuvred() const { return X_OB_; }
  [[nodiscard]] Outlook outlook() const;
  /// Standard deviation along the circuit; grows with the distance since the last fix.
  [[nodiscard]] double sigma_m() const;
  /// Total of all odometry steps, forwards positive, without corrections.
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  [[nodiscard]] std::optional<std::int64_t> odometer_um() const { return odometer_um_; }

  /// The position is given: configuration, state file, initPosition.
  void position_at(zone::TrackPosition position);
  /// The pose is given, on the path or off it (zone::snap_to_path).
  void set_off_path(const Pose2& X_MB);
  /// For an off-path vehicle: it joins the path here, not at the nearest position.
  void aim(zone::TrackPosition position);
  /// A manoeuvre was in progress when it was saved: how far it had come, and the section that it leads to if it is a
  /// turn at the end of place().section.
  void resume_manoeuvre(const Pose2& X_OB, std::optional<zone::SectionId> next);
  /// In another zone with the same body: pose and odometer stay, and the vehicle is on no path until it joins one.
  void take_over(const PositionEstimator& before);
  /// The nearest position on the circuit to a pose, within `distance_m_max` and in a similar direction; nothing
  /// otherwise.
  [[nodiscard]] std::optional<zone::TrackPosition> on_circuit(const Pose2& X_MB, double distance_m_max) const;

  /// Positions that coincide with the estimated one, nearest first: at a joint, and where sections lie on one another.
  /// None off the path.
  [[nodiscard]] std::vector<zone::TrackPosition> same_positions() const;
  /// Selects one of those, because the route is known; the uncertainty stays the same.
  void take_same_position(zone::TrackPosition position);

  /// The vehicle's course: on the present section now. The traversed sections stay if they are known.
  void follow(const zone::Course& course);
  [[nodiscard]] const zone::Course& course() const { return course_; }

  enum class FixKind {
    none,       ///< an unknown number, or a beacon without information
    corrected,  ///< the estimate moved a little along the circuit
    relocated,  ///< the estimate was wrong, and jumped
    outlier,    ///< contradicts the estimate, and no other reading supports it
  };
  struct Fix {
    FixKind kind{FixKind::none};
    double correction_m{};  ///< for `corrected`: along the circuit, forwards positive
  };

  /// Takes the odometer's reading. Returns the step of the estimate [m].
  double on_odometry(std::int64_t distance_um);
  /// Likewise with PILS's motion off the path; the end of a manoeuvre is a fix.
  struct Rolled {
    double step_m{};  ///< along the circuit, corrections included
    FixKind kind{FixKind::none};
  };
  Rolled on_odometry(const wire::Odometry& odometry);
  /// The board counts from zero again: the next reading is a new origin, and the distance driven meanwhile is not
  /// known.
  void on_odometer_reset();
  /// PILS stays where it is although commanded to drive: it is at a joint that it does not cross. Returns the
  /// correction [m].
  double on_stuck();

  /// @param number     a tag's, or a beacon's
  /// @param age_s      age of the reading when its frame was sent
  /// @param speed_mps  of the vehicle since
  Fix on_tag(std::uint32_t number, double age_s, double speed_mps);
  /// The beacons have been moved: the last contradicting beacon has no meaning any more.
  void forget_doubt() { doubt_.reset(); }

  [[nodiscard]] std::optional<zone::TagNumber> last_tag() const { return last_tag_; }
  [[nodiscard]] double since_last_tag_m() const { return travelled_m_ - last_tag_travelled_m_; }

 private:
  struct Sighting {
    Point2 beacon;
    double travelled_m;
  };
  /// Distance by the odometer since the last reading; 0 where the step is impossible.
  double count(std::int64_t distance_um);
  /// Along the course; less than `distance_m` where the estimate must not advance. Returns the distance moved.
  double shift(double distance_m);
  double shift_on(double distance_m);
  double shift_back(double distance_m);
  void enter(zone::SectionId next);
  /// A joint at which PILS waits or turns lies this near ahead of the estimate.
  [[nodiscard]] double joint_gate_m() const;
  [[nodiscard]] zone::SectionId section_before() const;

  // off the path
  Rolled off_path(double step_m, const wire::Odometry& odometry);
  void roll_off_line(double step_m, Rolled& rolled);
  void begin_manoeuvre(Rolled& rolled);
  void end_manoeuvre(bool line_lost, Rolled& rolled);
  [[nodiscard]] bool end_turn(double turned_rad, Rolled& rolled);
  [[nodiscard]] std::optional<zone::SectionId> turned_to(double turned_rad) const;
  void land(const Pose2& X_MB, bool line_lost, Rolled& rolled);

  /// `latency_m`: driven since the reading.
  Fix on_landmark(zone::TrackPosition position, double latency_m);
  Fix on_beacon(Point2 beacon, double latency_m);
  /// Nearest point of the course to a fiducial near the estimate; nothing: the course does not pass over the fiducial.
  struct Foot {
    double offset_m;  ///< along the course from the estimate
    double beside_m;  ///< from the fiducial
  };
  [[nodiscard]] std::optional<Foot> foot_of(Point2 fiducial) const;
  Fix on_strange_beacon(Point2 beacon, double latency_m);
  Fix jump_to(zone::TrackPosition position);
  /// The sections of the course within a distance of the estimate, each once and sorted. More than fit are left out.
  class Near {
   public:
    bool room() const { return count_ < ids_.size(); }
    bool add(zone::SectionId id) {
      if (!room()) return false;
      ids_[count_++] = id;
      return true;
    }
    void sort();
    [[nodiscard]] std::span<const zone::SectionId> ids() const { return std::span{ids_}.first(count_); }

   private:
    std::array<zone::SectionId, 64> ids_;
    std::size_t count_{0};
  };
  [[nodiscard]] Near sections_near(double reach_m) const;
  /// Along the course from the estimate to `place`, negative backwards; nothing beyond `limit_m`.
  [[nodiscard]] std::optional<double> offset_to(zone::TrackPosition position, double limit_m) const;
  [[nodiscard]] std::optional<double> distance_back_m(zone::TrackPosition position, double limit_m) const;

  const zone::TrafficZone& zone_;
  EstimatorModel model_;
  bool known_{false};
  AivMotion motion_;
  zone::Course course_;
  std::optional<Pose2> X_MO_;  ///< start of the turn, or the pose off the path; nothing: on the path
  std::optional<Pose2> X_OB_;  ///< the manoeuvre as PILS reports it
  bool near_path_{false};
  double off_by_m_{};
  double strayed_m_{};              ///< driven off the path, in no manoeuvre
  double manoeuvre_travelled_m_{};  ///< the odometer does not count during a manoeuvre
  bool on_old_floor_{false};        ///< the present manoeuvre began before the zone was switched
  double variance_m2_{};
  double travelled_m_{};
  std::optional<std::int64_t> odometer_um_;
  std::optional<zone::TagNumber> last_tag_;
  double last_tag_travelled_m_{};
  std::optional<Sighting> doubt_;  ///< the last beacon, when it contradicted the estimate
};

}  // namespace cosiva::aiv
