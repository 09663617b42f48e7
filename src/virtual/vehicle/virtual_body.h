#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/aiv/motion/motion.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/virtual/vehicle/antenna.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

/// The body of a virtual AIV: executes the commands to PILS' motors exactly, on the path without any error, and off the
/// path by a physical vehicle's manoeuvres (docs/protocols/module-link.md). Invariant: no manoeuvre on the path.
class VirtualBody {
 public:
  VirtualBody(std::shared_ptr<const zone::TrafficZone> zone, zone::TrackPosition start);

  /// Sets another floor. With the same geometry its tags and beacons count at once; with another geometry the body
  /// continues along its old path until standstill, and is then on the new floor with its pose unchanged.
  void change_floor(std::shared_ptr<const zone::TrafficZone> zone);

  /// One move of at most 0.1 s. Appends the readings of the antenna. @param drive  the command to the motors; nothing:
  /// brake
  void move(const wire::Drive* drive, double dt_s, std::vector<Antenna::Reading>& readings);

  /// The travel frame's pose (zone::body_pose): its x axis is the direction of travel.
  [[nodiscard]] Pose2 X_MB() const;  // NOLINT(readability-identifier-naming): frames are written so everywhere
  /// On the path the present track position, in a turn that of the joint; off the path the nearest one of the floor.
  [[nodiscard]] zone::TrackPosition track_position() const;
  [[nodiscard]] double speed_mps() const { return manoeuvre_ ? manoeuvre_->speed_mps() : speed_mps_; }
  /// As counted by the odometer: along sections, not in manoeuvres, in the body frame (negative in indirect direction).
  [[nodiscard]] double distance_m() const { return distance_m_; }
  [[nodiscard]] bool line_lost() const { return off_line_ && !lies_on_line_; }
  /// The pose in a manoeuvre, relative to its start; nothing: no manoeuvre.
  [[nodiscard]] const Pose2* manoeuvre() const { return manoeuvre_ ? &manoeuvre_->X_SB() : nullptr; }
  void fold(Digest& digest) const;
  /// The floor, and the one that follows at standstill; null: none follows.
  [[nodiscard]] const zone::TrafficZone* floor() const { return zone_.get(); }
  [[nodiscard]] const zone::TrafficZone* next_floor() const { return next_.get(); }
  void archive(Archive& archive);  ///< the state without the floors, for a snapshot
  /// To be called before the state of a body on these floors is read.
  /// @param zone  not null (checked)
  void put_on(std::shared_ptr<const zone::TrafficZone> zone, std::shared_ptr<const zone::TrafficZone> next);

 private:
  [[nodiscard]] bool is_stopped() const { return manoeuvre_ ? manoeuvre_->abandoned() : speed_mps_ == 0.0; }
  void count(double travelled_m) { distance_m_ += zone_->circuit.indirect() ? -travelled_m : travelled_m; }
  void adopt_next_zone();
  void change_speed(const wire::Drive* drive, double dt_s);
  void roll(double wanted_m, bool goes_on);
  void roll_back(double wanted_m);
  void stop_at(zone::TrackPosition position);
  void move_off_line(const wire::Drive* drive, double dt_s);
  [[nodiscard]] bool begin_seek(const wire::Drive& drive);

  std::shared_ptr<const zone::TrafficZone> zone_;  ///< with the tags and beacons in force
  std::shared_ptr<const zone::TrafficZone> next_;  ///< becomes the floor at standstill
  aiv::AivMotion motion_;
  Antenna antenna_;
  double speed_mps_{0.0};
  double distance_m_{0.0};
  std::size_t branch_{0};    ///< as last commanded
  bool off_line_{false};     ///< in a manoeuvre, or placed on another floor
  bool lies_on_line_{true};  ///< the reading of the line sensors while off_line_
  std::optional<aiv::Manoeuvre> manoeuvre_;
  Pose2 X_MS_;                ///< the pose at the start of the manoeuvre, or on the new floor
  zone::TrackPosition goal_;  ///< end of the manoeuvre
};

}  // namespace cosiva::virtual_side
