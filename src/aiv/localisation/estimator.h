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

/// What the vehicle knows about its own sensors, and how it doubts them.
struct EstimatorModel {
  double sigma_start_m{0.01};        ///< standard deviation of a place that was told
  double sigma_fix_m{0.004};         ///< after a tag or beacon
  double variance_per_m{1e-4};       ///< of odometry: 1 cm per √m
  double antenna_range_m{0.020};     ///< a tag reports when it enters the field: this long before the antenna is on it
  double reading_latency_s{0.020};   ///< from the field to the age stamp of the frame, and the way of the frame to us
  double beacon_gate_m{0.30};        ///< a beacon further from the belief than this contradicts it
  double tag_gate_m{0.60};           ///< likewise a tag
  double sigma_reset_m{0.05};        ///< added when the odometer starts anew
  double odometry_step_m_max{0.50};  ///< more between two readings is a board that counts from zero again
  double bend_gate_m{0.15};          ///< who turns on the spot, or stops at a fork, is at the joint this near ahead;
                                     ///< after a long way without a fix it is looked for further
  double landed_m{0.06};             ///< a manoeuvre that ends this near to a line, and as good as along it,
  double landed_rad{0.30};           ///< has brought the vehicle onto it
};

/// Where the vehicle believes it is: the article's motion on the circuit fed by odometry, rectified at tags and beacons
/// (A21). It knows nothing until somebody tells a place or a tag is read.
///
/// It goes along a course, and by itself no further than that is sure: not over a fork that nobody has decided, and not
/// over a joint where the vehicle turns on the spot, which it does first. Off the line it knows a pose: while it turns,
/// and where it stands beside the line (`beside`: with a place where it will come onto it) or away from all lines.
class PositionEstimator {
 public:
  explicit PositionEstimator(const zone::TrafficZone& zone, EstimatorModel model = {});

  /// A place on the circuit is known: it can drive, or (beside) go there.
  [[nodiscard]] bool known() const { return known_; }
  [[nodiscard]] zone::TrackPosition track_position() const { return motion_.track_position(zone_.circuit); }
  /// pose() has a meaning.
  [[nodiscard]] bool pose_known() const { return known_ || X_MO_.has_value(); }
  [[nodiscard]] Pose2 pose() const;
  [[nodiscard]] const AivMotion& motion() const { return motion_; }
  /// Off the line, and near enough to go onto it at place().
  [[nodiscard]] bool near_path() const { return known_ && near_path_; }
  /// The pose is known, and no line is near.
  [[nodiscard]] bool away() const { return !known_ && X_MO_.has_value(); }
  /// From the circuit to where it stands, beside it or away.
  [[nodiscard]] double off_by_m() const { return off_by_m_; }
  /// PILS is in a manoeuvre.
  [[nodiscard]] bool manoeuvring() const { return X_OB_.has_value(); }
  /// No line is under it, or need be: it turns, or stands beside or away.
  [[nodiscard]] bool off_path() const { return X_MO_.has_value() || X_OB_.has_value(); }
  /// Where the manoeuvre began, or where it stands off the line; and how far the manoeuvre has come.
  [[nodiscard]] const std::optional<Pose2>& left_line_at() const { return X_MO_; }
  [[nodiscard]] const std::optional<Pose2>& manoeuvred() const { return X_OB_; }
  [[nodiscard]] Outlook outlook() const;
  /// Standard deviation along the circuit; grows with the distance since the last fix.
  [[nodiscard]] double sigma_m() const;
  /// Total of all odometry steps, forwards positive, whatever the corrections.
  [[nodiscard]] double travelled_m() const { return travelled_m_; }
  [[nodiscard]] std::optional<std::int64_t> odometer_um() const { return odometer_um_; }

  /// Somebody tells the place: configuration, memory, initPosition.
  void position_at(zone::TrackPosition position);
  /// Somebody tells the pose, on the line or not (zone::snap_to_path).
  void set_off_path(const Pose2& X_MB);
  /// Of one that stands beside the line: it goes onto it here, not at the nearest place.
  void aim(zone::TrackPosition position);
  /// A manoeuvre was in progress when it was remembered: how far it had come, and the section that it leads to if it
  /// is a turn at the end of place().section.
  void resume_manoeuvre(const Pose2& X_OB, std::optional<zone::SectionId> next);
  /// In another zone where the body is the same: pose and odometer are kept, and it is on no line until it goes there.
  void take_over(const PositionEstimator& before);
  /// The nearest place on the circuit to a pose, within `distance_m_max` and looking the same way; nothing otherwise.
  [[nodiscard]] std::optional<zone::TrackPosition> on_circuit(const Pose2& X_MB, double distance_m_max) const;

  /// Where it stands as well, nearest first: at a joint, and where sections lie on one another. None off the line.
  [[nodiscard]] std::vector<zone::TrackPosition> same_positions() const;
  /// One of those is meant, as somebody who knows where it goes has told; it is known no better than before.
  void take_same_position(zone::TrackPosition position);

  /// The way that it takes: on the present section now. Where it came from is kept if it is known.
  void follow(const zone::Course& course);
  [[nodiscard]] const zone::Course& course() const { return course_; }

  enum class FixKind {
    none,       ///< an unknown number, or a beacon that says nothing
    corrected,  ///< the belief moved a little along the circuit
    relocated,  ///< the belief was wrong, and jumped
    outlier,    ///< it contradicts the belief and is alone in that
  };
  struct Fix {
    FixKind kind{FixKind::none};
    double correction_m{};  ///< for `corrected`: along the circuit, forwards positive
  };

  /// Takes the odometer's reading. Gives the step that the belief made [m].
  double on_odometry(std::int64_t distance_um);
  /// Likewise with what PILS does off the line; the end of a manoeuvre is a fix.
  struct Rolled {
    double step_m{};  ///< along the circuit, corrections included
    FixKind kind{FixKind::none};
  };
  Rolled on_odometry(const wire::Odometry& odometry);
  /// The board counts from zero again: the next reading is a new beginning, and what rolled meanwhile is not known.
  void on_odometer_reset();
  /// Told to go on, PILS stays where it is: it has come to a joint that it does not cross. Gives the correction [m].
  double on_stuck();

  /// @param number     a tag's, or a beacon's
  /// @param age_s      how long ago it was read when its frame was sent
  /// @param speed_mps  of the vehicle since
  Fix on_tag(std::uint32_t number, double age_s, double speed_mps);
  /// Beacons stand elsewhere now: the last strange one tells nothing any more.
  void forget_doubt() { doubt_.reset(); }

  [[nodiscard]] std::optional<zone::TagNumber> last_tag() const { return last_tag_; }
  [[nodiscard]] double since_last_tag_m() const { return travelled_m_ - last_tag_travelled_m_; }

 private:
  struct Sighting {
    Point2 beacon;
    double travelled_m;
  };
  /// What the odometer rolled since the last reading; 0 where that cannot be.
  double count(std::int64_t distance_um);
  /// Along the course; less than asked where it must not go on. Gives what it moved.
  double shift(double distance_m);
  double shift_on(double distance_m);
  double shift_back(double distance_m);
  void enter(zone::SectionId next);
  /// A joint at which PILS waits or turns lies this near ahead of the belief.
  [[nodiscard]] double joint_gate_m() const;
  [[nodiscard]] zone::SectionId section_before() const;

  // off the line
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
  /// Of a mark on the floor on the way near the belief; nothing: its way does not pass over it.
  struct Foot {
    double offset_m;  ///< along the course from the belief
    double beside_m;  ///< from the mark
  };
  [[nodiscard]] std::optional<Foot> foot_of(Point2 fiducial) const;
  Fix on_strange_beacon(Point2 beacon, double latency_m);
  Fix jump_to(zone::TrackPosition position);
  /// The sections of its way so near to the belief, each once and in their order. More than fit are left out.
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
  /// Along the course from the belief to `place`, negative backwards; nothing beyond `limit_m`.
  [[nodiscard]] std::optional<double> offset_to(zone::TrackPosition position, double limit_m) const;
  [[nodiscard]] std::optional<double> distance_back_m(zone::TrackPosition position, double limit_m) const;

  const zone::TrafficZone& zone_;
  EstimatorModel model_;
  bool known_{false};
  AivMotion motion_;
  zone::Course course_;
  std::optional<Pose2> X_MO_;  ///< where it left the line to turn, or stands off it; nothing: on the line
  std::optional<Pose2> X_OB_;  ///< the manoeuvre as PILS tells it
  bool near_path_{false};
  double off_by_m_{};
  double strayed_m_{};              ///< rolled since it stands off the line, in no manoeuvre
  double manoeuvre_travelled_m_{};  ///< the odometer does not count during a manoeuvre
  bool on_old_floor_{false};        ///< the manoeuvre under way began before the zone was switched
  double variance_m2_{};
  double travelled_m_{};
  std::optional<std::int64_t> odometer_um_;
  std::optional<zone::TagNumber> last_tag_;
  double last_tag_travelled_m_{};
  std::optional<Sighting> doubt_;  ///< the last beacon, when it contradicted the belief
};

}  // namespace cosiva::aiv
