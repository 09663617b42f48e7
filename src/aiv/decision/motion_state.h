#pragma once

#include <cstdint>
#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::aiv {

/// How the vehicle moves, from the readings of its odometer: speed, turn rate, and whether it has stopped.
/// Invariant: a vehicle whose odometer is lost counts as stopped, at speed 0, until the next reading.
class MotionState {
 public:
  void on_odometry(const wire::Odometry& odometry);
  void on_odometry_lost();
  /// Whether the vehicle has been commanded to drive for half a second of readings without any progress, as a vehicle
  /// that waits at a joint for its branch. The count restarts after that.
  /// @param driving      the motors are commanded to drive along the path, and a line is under the sensors
  /// @param travelled_m  of the vehicle's own odometer
  [[nodiscard]] bool stuck(bool driving, double travelled_m);
  /// Continues from `before`, the state in another zone; the measurement of progress restarts.
  void take_over(const MotionState& before);

  [[nodiscard]] double speed_mps() const { return speed_mps_; }  ///< signed: negative while backing up
  [[nodiscard]] bool stopped() const { return stopped_; }        ///< since two readings, and not in a manoeuvre
  [[nodiscard]] bool has_manoeuvre() const { return manoeuvre_.has_value(); }  ///< the last reading was of one
  [[nodiscard]] double manoeuvre_turn_radps() const { return turn_radps_; }    ///< 0 outside manoeuvres
  void archive(Archive& archive);                                              ///< the state, for a snapshot

 private:
  double speed_mps_{0.0};
  int slow_readings_{2};  ///< in a row under a centimetre per second; a vehicle starts stopped
  bool stopped_{true};
  std::optional<wire::Manoeuvre> manoeuvre_;  ///< as last read
  std::uint32_t manoeuvre_ms_{};
  int still_readings_{0};  ///< in a row in which the manoeuvre did not go on
  double turn_radps_{0.0};
  int stuck_readings_{0};
  double stuck_travelled_m_{0.0};
};

}  // namespace cosiva::aiv
