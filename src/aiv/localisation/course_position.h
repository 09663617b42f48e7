#pragma once

#include <optional>

#include "cosiva/aiv/motion/motion.h"
#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/circuit/course.h"

namespace cosiva::aiv {

/// A position on the circuit that moves along a course, and without further information only as far as is certain: not
/// over a fork whose branch is undecided, and not over a joint where the vehicle turns on the spot.
/// Invariant: the course is empty, or its present section is that of the position.
class CoursePosition {
 public:
  /// @param circuit  must outlive this object
  explicit CoursePosition(const zone::Circuit& circuit) : circuit_{circuit} {}

  [[nodiscard]] const zone::Circuit& circuit() const { return circuit_; }
  [[nodiscard]] const AivMotion& motion() const { return motion_; }
  [[nodiscard]] const zone::Course& course() const { return course_; }
  [[nodiscard]] zone::TrackPosition track_position() const { return motion_.track_position(circuit_); }
  [[nodiscard]] Pose2 pose() const;
  [[nodiscard]] Outlook outlook() const { return {track_position(), course_.remaining()}; }

  /// Jumps; the course stays where it leads over that section.
  void jump_to(zone::TrackPosition position);
  /// Jumps, without a course from there.
  void jump_without_course(zone::TrackPosition position);
  void clear_course() { course_.clear(); }
  /// The course: on the present section now. The traversed sections stay if they are known.
  void follow(const zone::Course& course);
  /// The course leads to this section, and no further.
  void expect_next(zone::SectionId next);

  /// Along the course; less than `distance_m` where the position must not advance. Returns the distance moved, with its
  /// sign.
  double shift(double distance_m);
  /// Onto the start of this section, round the bend between. A course that does not lead there ends there.
  void enter_branch(zone::SectionId next);

  /// Along the course to `position`, negative backwards; nothing beyond `limit_m`.
  [[nodiscard]] std::optional<double> offset_to(zone::TrackPosition position, double limit_m) const;
  /// Nearest point of the course to a fiducial.
  struct Foot {
    double offset_m;  ///< along the course
    double beside_m;  ///< from the fiducial
  };
  /// At most `reach_m` along the course and less than `beside_m_max` from the fiducial; nothing: the course does not
  /// pass over the fiducial there.
  [[nodiscard]] std::optional<Foot> foot_of(Point2 fiducial, double reach_m, double beside_m_max) const;
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  double shift_on(double distance_m);
  double shift_back(double distance_m);
  void enter(zone::SectionId next);
  [[nodiscard]] zone::SectionId section_before() const;
  [[nodiscard]] std::optional<double> distance_back_m(zone::TrackPosition position, double limit_m) const;

  const zone::Circuit& circuit_;
  AivMotion motion_;
  zone::Course course_;
  /// What pose() gave last, and for which position: several parts need it between two steps.
  mutable zone::TrackPosition posed_at_{zone::no_section, 0.0};
  mutable Pose2 pose_;
};

}  // namespace cosiva::aiv
