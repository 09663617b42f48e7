#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::physical {

/// The limits of the emulated drive train; the values of a small differential-drive vehicle.
struct DriveTrain {
  double speed_mps_max{1.5};
  double acceleration_mps2_max{3.0};
  double braking_mps2_max{4.0};
  double own_braking_mps2{1.0};  ///< without a command, or where the command leaves it open
  double motor_lag_s{0.05};      ///< first order, from wheel command to wheel speed
  double turn_lag_s{0.02};       ///< first order, from steering command to turn rate
  double turn_rate_radps_max{8.0};
  double line_lost_m{0.015};  ///< a line is followed from an offset of at most this
};

/// The command to the motors. All values are non-negative but the speed, which is negative for backing up.
struct DriveCommand {
  double speed_mps{};
  double acceleration_mps2{};  ///< 0: the drive train's own braking, for both
  double braking_mps2{};
  std::size_t branch{};  ///< at a fork take the n-th branch; beyond the last: the last; wire::no_branch: stop there
  bool seek{};           ///< off the path: go to the nearest one
  std::optional<wire::Manoeuvre> goal{};  ///< or to the one at this position, in the body frame
};

/// A wheel motor that does not turn.
enum class DeadMotor : std::uint8_t { none, left, right };

/// The emulated wheel motors (PMOT, A16) while the vehicle follows its line: a ramp to the commanded speed, which the
/// motors follow with a lag, and a turn rate likewise. A wheel whose motor is dead does not turn: the body turns around
/// it. Invariant: a turn has the time step of the change of speed before it.
class Pmot {
 public:
  explicit Pmot(const DriveTrain& train) : train_{train} {}

  void change_speed(const DriveCommand* command, double dt_s);
  /// Turns with the wheels' speed; left positive.
  void turn(double wanted_radps, double dt_s);
  /// The body can go no further than to a stop from this speed.
  void limit_speed(double speed_mps);
  void stop();
  void end_turn() { turn_rate_radps_ = 0.0; }

  [[nodiscard]] double speed_mps() const { return speed_mps_; }  ///< of the body's centre
  [[nodiscard]] double turn_rate_radps() const { return turn_rate_radps_; }
  /// Of |v| in the last step; braking < 0.
  [[nodiscard]] double acceleration_mps2() const { return acceleration_mps2_; }
  struct Wheels {
    double left_mps;
    double right_mps;
  };
  [[nodiscard]] Wheels wheels() const;
  [[nodiscard]] DeadMotor dead() const { return dead_; }
  void set_dead(DeadMotor motor) { dead_ = motor; }
  void rest() { acceleration_mps2_ = 0.0; }
  [[nodiscard]] const DriveTrain& train() const { return train_; }
  void archive(Archive& archive);  ///< the state, for a restart of the emulation

 private:
  DriveTrain train_;
  double speed_mps_{0.0};
  double speed_reference_mps_{0.0};  ///< the ramp that the motors follow with their lag
  double turn_rate_radps_{0.0};
  double acceleration_mps2_{0.0};
  double lag_dt_s_{0.0};  ///< the step that the two blends below are for
  double motor_blend_{1.0};
  double turn_blend_{1.0};
  DeadMotor dead_{DeadMotor::none};
};

}  // namespace cosiva::physical
