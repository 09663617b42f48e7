#include "cosiva/physical/plant/pmot.h"

#include <algorithm>
#include <cmath>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/physical/plant/odometer.h"

namespace cosiva::physical {
namespace {

/// Moves `value` towards `target` by at most `step`.
double towards(double value, double target, double step) { return value + std::clamp(target - value, -step, step); }

}  // namespace

void Pmot::change_speed(const DriveCommand* command, double dt_s) {
  if (dt_s != lag_dt_s_) {
    lag_dt_s_ = dt_s;
    motor_blend_ = 1.0 - det_exp(-dt_s / train_.motor_lag_s);
    turn_blend_ = 1.0 - det_exp(-dt_s / train_.turn_lag_s);
  }
  double target_mps = 0.0;
  double acceleration_mps2 = train_.own_braking_mps2;
  double braking_mps2 = train_.own_braking_mps2;
  if (command != nullptr) {
    target_mps = std::clamp(command->speed_mps, -train_.speed_mps_max, train_.speed_mps_max);
    if (command->acceleration_mps2 > 0.0)
      acceleration_mps2 = std::min(command->acceleration_mps2, train_.acceleration_mps2_max);
    if (command->braking_mps2 > 0.0) braking_mps2 = std::min(command->braking_mps2, train_.braking_mps2_max);
  }
  const bool turns_round = target_mps * speed_reference_mps_ < 0.0;
  if (turns_round || std::fabs(target_mps) < std::fabs(speed_reference_mps_))
    speed_reference_mps_ = towards(speed_reference_mps_, turns_round ? 0.0 : target_mps, braking_mps2 * dt_s);
  else
    speed_reference_mps_ = towards(speed_reference_mps_, target_mps, acceleration_mps2 * dt_s);

  const double before_mps = std::fabs(speed_mps_);
  speed_mps_ += (speed_reference_mps_ - speed_mps_) * motor_blend_;
  // Friction ends the motors' creep.
  constexpr double creep_mps = 5e-4;
  if (speed_reference_mps_ == 0.0 && std::fabs(speed_mps_) < creep_mps) speed_mps_ = 0.0;
  acceleration_mps2_ = (std::fabs(speed_mps_) - before_mps) / dt_s;
}

void Pmot::turn(double wanted_radps, double dt_s) {
  COSIVA_EXPECT(dt_s == lag_dt_s_);
  turn_rate_radps_ +=
      (std::clamp(wanted_radps, -train_.turn_rate_radps_max, train_.turn_rate_radps_max) - turn_rate_radps_) *
      turn_blend_;
  if (dead_ == DeadMotor::none) return;
  const double side = dead_ == DeadMotor::left ? 1.0 : -1.0;
  const double wheel_mps = speed_mps_ + side * Odometer::half_track_m * turn_rate_radps_;
  speed_mps_ = 0.5 * wheel_mps;
  turn_rate_radps_ = side * speed_mps_ / Odometer::half_track_m;
}

void Pmot::limit_speed(double speed_mps) {
  speed_mps_ = std::min(speed_mps_, speed_mps);
  speed_reference_mps_ = std::min(speed_reference_mps_, speed_mps);
}

void Pmot::stop() {
  speed_mps_ = 0.0;
  speed_reference_mps_ = 0.0;
}

Pmot::Wheels Pmot::wheels() const {
  const double difference_mps = Odometer::half_track_m * turn_rate_radps_;
  return {speed_mps_ - difference_mps, speed_mps_ + difference_mps};
}

void Pmot::archive(Archive& archive) { archive(speed_mps_, speed_reference_mps_, turn_rate_radps_, dead_); }

}  // namespace cosiva::physical
