#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/aiv/motion/motion.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/pose.h"
#include "cosiva/virtual/vehicle/antenna.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::virtual_side {

/// The body of a virtual AIV: it does exactly what PILS' motors are told, on the line without any error, and off it by
/// the manoeuvres of a physical one (docs/protocols/module-link.md).
class VirtualBody {
 public:
  VirtualBody(std::shared_ptr<const zone::TrafficZone> zone, zone::TrackPosition start);

  /// Another floor. With the same ways its tags and beacons count at once; with others the body goes on along its old
  /// line until it stands, and is then on the new floor, as it is.
  void change_floor(std::shared_ptr<const zone::TrafficZone> zone);

  /// One move of at most 0.1 s. Appends what the antenna read.
  /// @param drive  what the motors are told; nothing: brake
  void move(const wire::Drive* drive, double dt_s, std::vector<Antenna::Reading>& readings);

  [[nodiscard]] Pose2 X_MB() const;  // NOLINT(readability-identifier-naming): frames are written so everywhere
  /// On the line where it is, in a turn the joint; off it the place of its floor that is nearest.
  [[nodiscard]] zone::TrackPosition put() const;
  [[nodiscard]] double speed_mps() const { return manoeuvre_ ? manoeuvre_->speed_mps() : speed_mps_; }
  /// As the odometer counts: along lines, not in manoeuvres.
  [[nodiscard]] double distance_m() const { return distance_m_; }
  [[nodiscard]] bool line_lost() const { return off_line_ && !lies_on_line_; }
  /// Where it is in a manoeuvre, seen from where that began; nothing: in none.
  [[nodiscard]] const Pose2* manoeuvre() const { return manoeuvre_ ? &manoeuvre_->X_SB() : nullptr; }
  void fold(Digest& digest) const;

 private:
  [[nodiscard]] bool is_stopped() const { return manoeuvre_ ? manoeuvre_->abandoned() : speed_mps_ == 0.0; }
  void adopt_next_zone();
  void change_speed(const wire::Drive* drive, double dt_s);
  void roll(double wanted_m, bool goes_on);
  void roll_back(double wanted_m);
  void stop_at(zone::TrackPosition position);
  void move_off_line(const wire::Drive* drive, double dt_s);
  [[nodiscard]] bool begin_seek(const wire::Drive& drive);

  std::shared_ptr<const zone::TrafficZone> zone_;  ///< with the tags and beacons in force
  std::shared_ptr<const zone::TrafficZone> next_;  ///< comes under it when it stands
  aiv::AivMotion motion_;
  Antenna antenna_;
  double speed_mps_{0.0};
  double distance_m_{0.0};
  std::size_t branch_{0};    ///< as told last
  bool off_line_{false};     ///< in a manoeuvre, or put on another floor
  bool lies_on_line_{true};  ///< what the sensors say while off_line_
  std::optional<aiv::Manoeuvre> manoeuvre_;
  Pose2 X_MS_;                ///< where it stood when the manoeuvre began, or stands on a new floor
  zone::TrackPosition goal_;  ///< where the manoeuvre ends
};

}  // namespace cosiva::virtual_side
