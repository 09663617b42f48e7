#pragma once

#include <cstddef>
#include <optional>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/pose.h"
#include "cosiva/base/random.h"
#include "cosiva/physical/boards/line_tracker.h"
#include "cosiva/physical/plant/body.h"
#include "cosiva/physical/plant/dems.h"
#include "cosiva/physical/plant/pmot.h"
#include "cosiva/zone/circuit/circuit.h"

namespace cosiva::physical {

/// What PILS joins by BRAC (A16), on the body.
struct LineParts {
  Dems dems;
  Pmot pmot;
};

/// A differential-drive body that PILS steers along the line. Its ground truth in path coordinates: the projection of
/// its centre onto the path, the lateral error e (left of the path) and the heading error ψ:
///     ṡ = v cos ψ / (1 − κ e),   ė = v sin ψ,   ψ̇ = ω − κ ṡ,
/// with ω from the line tracking of PILS, which has nothing but the readings of DEMS and the wheels' speed. Where the
/// next section leaves at an angle the body stops at the joint and turns on the spot. When the floor under it is
/// replaced (invariant: at standstill) the body stays, off-path until a seek succeeds (docs/protocols/module-link.md).
class LineVehicle {
 public:
  /// @param circuit  must outlive this
  /// @param line_offset_sd_m  unevenness of the line's paint and of its measurement, correlated over 5 cm
  LineVehicle(const zone::Circuit& circuit, zone::TrackPosition start, double line_offset_sd_m, Random line_noise);

  /// One step of at most 20 ms. No command: the motors stop by themselves, and a fork is passed as last commanded.
  /// @param pils  steers the body along the line
  void step(const DriveCommand* command, LineTracker& pils, double dt_s);

  /// The floor is this one from now on; the body stays in place, wherever the paths are. Only for a stopped body.
  /// @param circuit  must outlive this
  /// @param turns    vehicles travel it in the other direction: the body's frame, whose x axis is the direction of
  ///                 travel, turns round
  void set_zone(const zone::Circuit& circuit, bool turns = false);
  /// Speed exactly 0, and no manoeuvre but an abandoned one.
  [[nodiscard]] bool is_stopped() const { return manoeuvre_ ? manoeuvre_->abandoned() : speed_mps() == 0.0; }

  [[nodiscard]] const BodyPose& body() const { return body_; }
  /// On the path; off-path (following() is false), where the body left the path, or any position of a new floor.
  [[nodiscard]] zone::TrackPosition track_position() const { return position_; }
  /// Whether the body follows the path: in no manoeuvre, and not waiting off-path.
  [[nodiscard]] bool following() const { return !off_path_; }
  /// The present manoeuvre, if any.
  [[nodiscard]] const aiv::Manoeuvre* manoeuvre() const { return manoeuvre_ ? &*manoeuvre_ : nullptr; }
  /// Along the path; 0 in a manoeuvre.
  [[nodiscard]] double speed_mps() const { return parts_.pmot.speed_mps(); }
  [[nodiscard]] double lateral_error_m() const { return lateral_m_; }
  [[nodiscard]] double heading_error_rad() const { return heading_rad_; }
  /// The parts, and what a scenario does to them.
  [[nodiscard]] LineParts& parts() { return parts_; }
  [[nodiscard]] const LineParts& parts() const { return parts_; }
  [[nodiscard]] bool line_lost() const;
  /// The distance travelled by the wheels in the last step, forwards positive.
  [[nodiscard]] double step_distance_m() const { return step_distance_m_; }
  /// The wheels' motion in the last step of a manoeuvre; not counted above.
  [[nodiscard]] const aiv::Manoeuvre::Step& step_manoeuvre() const { return step_manoeuvre_; }
  /// The motion's state, for a restart of the emulation: to be read on the circuit that it was written on.
  void archive(Archive& archive);

 private:
  void step_off_path(const DriveCommand* command, double dt_s);
  void begin_turn(const aiv::Onward& onward);
  [[nodiscard]] bool begin_seek(const DriveCommand& command);
  /// Whether the sensors detect the line for a body in this pose, expressed from the nearest position on the path.
  [[nodiscard]] bool lies_over(const Pose2& X_PB) const;
  void end_manoeuvre();
  void record_section();
  void brake_for_end(double dt_s);
  void steer(LineTracker& pils, double dt_s);
  void read_line(double distance_m);
  void move_along(double distance_m);
  void to_next();
  [[nodiscard]] bool to_previous();
  void stop_at_end(double s_m);
  void put_body(double sin_error, double cos_error);

  const zone::Circuit* circuit_;
  LineParts parts_;

  zone::TrackPosition position_;
  zone::SectionId came_from_{zone::no_section};  ///< backing up returns there
  double lateral_m_{0.0};
  double heading_rad_{0.0};
  double step_distance_m_{0.0};
  BodyPose body_;

  std::size_t branch_{0};     ///< as last commanded
  bool may_end_here_{false};  ///< the section ends in a fork, a sharp bend, or nowhere
  bool goes_on_{false};       ///< commanded forwards
  bool off_path_{false};      ///< in a manoeuvre, or put on another floor
  bool lies_on_line_{true};   ///< the sensors' reading while off_path_
  std::optional<aiv::Manoeuvre> manoeuvre_;
  Pose2 X_MS_;  ///< the body's pose when the manoeuvre began
  aiv::Manoeuvre::Step step_manoeuvre_;
  zone::TrackPosition goal_;  ///< the body's position on the path when the manoeuvre ends, and its errors
  double goal_lateral_m_{0.0};
  double goal_heading_rad_{0.0};
};

}  // namespace cosiva::physical
