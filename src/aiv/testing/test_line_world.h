#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <optional>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/aiv/motion/motion.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::aiv::test {

/// A body on the floor, and a PILS that follows the path exactly: it takes the commanded branch, turns on the spot
/// where the path bends, seeks, and counts the turns of its wheels.
class LineWorld {
 public:
  LineWorld(const zone::Circuit& floor, zone::TrackPosition position) : ground_truth{floor, position}, floor_{&floor} {}

  /// @param drive  null: there is no command, the body brakes
  void step(const wire::Drive* drive, double dt_s) {
    const double wanted_mps = drive != nullptr ? 1e-3 * drive->speed_mmps : 0.0;
    if (off_) return step_off_line(drive, wanted_mps, dt_s);
    const double braking = drive != nullptr ? 1e-3 * drive->braking_mmps2 : 2.0;
    const double before = speed_mps;
    speed_mps = wanted_mps > speed_mps ? std::min(wanted_mps, speed_mps + 1e-3 * drive->acceleration_mmps2 * dt_s)
                                       : std::max(wanted_mps, speed_mps - braking * dt_s);
    roll(0.5 * (before + speed_mps) * dt_s, drive != nullptr ? drive->branch : branch_);
  }

  /// Replaces the floor under the same body, which is stopped.
  void set_zone(const zone::Circuit& floor) {
    off_ = Off{pose(), {}, {}};
    floor_ = &floor;
    ground_truth = AivMotion{floor, {0, 0.0}};
  }

  [[nodiscard]] Pose2 pose() const {
    if (!off_) return ground_truth.pose(*floor_);
    return off_->manoeuvre ? off_->X_MS * off_->manoeuvre->X_SB() : off_->X_MS;
  }
  [[nodiscard]] zone::TrackPosition track_position() const { return ground_truth.track_position(*floor_); }
  [[nodiscard]] bool on_line() const { return !off_; }
  [[nodiscard]] bool manoeuvring() const { return off_ && off_->manoeuvre; }
  [[nodiscard]] wire::Odometry odometry() const {
    wire::Odometry odometry;
    odometry.distance_um = std::llround(odometer_m * 1e6);
    odometry.speed_mmps = static_cast<std::int16_t>(std::lround(speed_mps * 1e3));
    odometry.line_lost = off_ && !off_->manoeuvre && !line_under();
    if (manoeuvring()) odometry.manoeuvre = to_manoeuvre(off_->manoeuvre->X_SB());
    return odometry;
  }

  AivMotion ground_truth;  ///< on the path
  double speed_mps{0.0};
  double odometer_m{0.0};

 private:
  struct Off {
    Pose2 X_MS;
    std::optional<Manoeuvre> manoeuvre;
    zone::TrackPosition goal;
  };

  void roll(double distance_m, std::uint8_t branch) {
    branch_ = branch;
    if (distance_m < 0.0) odometer_m += ground_truth.shift(*floor_, distance_m);
    for (double left_m = distance_m; left_m > 0.0;) {
      const zone::TrackPosition here = track_position();
      const double to_end_m = floor_->section(here.section).length_m() - here.s_m;
      const double step_m = std::min(left_m, to_end_m);
      odometer_m += ground_truth.move(*floor_, step_m);
      left_m -= step_m;
      if (left_m <= 0.0) return;
      const Onward onward = aiv::onward(*floor_, here.section, branch);
      if (onward.section != zone::no_section && onward.turn_rad == 0.0) {
        ground_truth = AivMotion{*floor_, {onward.section, 0.0}};
        continue;
      }
      speed_mps = 0.0;
      if (onward.section == zone::no_section) return;
      off_ = Off{ground_truth.pose(*floor_), Manoeuvre{{0.0, 0.0, onward.turn_rad}}, {onward.section, 0.0}};
      return;
    }
  }

  /// A path that is under the body on another floor by chance.
  [[nodiscard]] std::optional<zone::TrackPosition> line_under() const {
    const auto entry_point = zone::snap_to_path(*floor_, off_->X_MS, 0.001);
    const bool along =
        entry_point &&
        std::fabs(wrap_angle(floor_->pose_at(entry_point->position).heading_rad - off_->X_MS.heading_rad)) < 0.01;
    return along ? std::optional{entry_point->position} : std::nullopt;
  }

  void step_off_line(const wire::Drive* drive, double wanted_mps, double dt_s) {
    speed_mps = 0.0;
    if (!off_->manoeuvre) {
      const auto line = line_under();
      if (wanted_mps != 0.0 && !drive->seek && line) {
        ground_truth = AivMotion{*floor_, *line};
        off_.reset();
      }
      if (drive == nullptr || !drive->seek || wanted_mps <= 0.0) return;
      const auto position = sought(*floor_, off_->X_MS, drive->goal);
      if (!position) return;
      off_->goal = *position;
      off_->manoeuvre.emplace(inverse(off_->X_MS) * floor_->pose_at(*position));
    }
    off_->manoeuvre->step(wanted_mps, dt_s);
    if (!off_->manoeuvre->done()) return;
    ground_truth = AivMotion{*floor_, off_->goal};
    off_.reset();
  }

  const zone::Circuit* floor_;
  std::uint8_t branch_{0};
  std::optional<Off> off_;
};

}  // namespace cosiva::aiv::test
