#include "physical/plant/vehicle_dynamics.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "base/expect.h"

namespace cosiva::physical {
namespace {

/// Moves `value` towards `target` by at most `step`.
double towards(double value, double target, double step) { return value + std::clamp(target - value, -step, step); }

}  // namespace

LineVehicle::LineVehicle(const zone::Circuit& circuit, zone::Place start, double line_offset_sd_m, Random line_noise)
    : circuit_{&circuit}, line_offset_sd_m_{line_offset_sd_m}, line_random_{line_noise}, place_{start} {
  line_noise_m_ = line_random_.gaussian(0.0, line_offset_sd_m_);
  place_body(0.0, 1.0);
}

void LineVehicle::step(const DriveCommand* command, double dt_s) {
  COSIVA_EXPECT(dt_s > 0.0 && dt_s <= 0.0201);
  if (dt_s != lag_dt_s_) {
    lag_dt_s_ = dt_s;
    motor_blend_ = 1.0 - det_exp(-dt_s / train_.motor_lag_s);
    turn_blend_ = 1.0 - det_exp(-dt_s / train_.turn_lag_s);
  }
  change_speed(command, dt_s);
  if (speed_mps_ == 0.0) {
    step_distance_m_ = 0.0;
    turn_rate_radps_ = 0.0;
    return;
  }
  steer(dt_s);
  step_distance_m_ = speed_mps_ * dt_s;
  const auto [sin_error, cos_error] = sincos(heading_rad_);
  const double kappa = circuit_->section(place_.section).curvature_at(place_.s_m);
  lateral_m_ += step_distance_m_ * sin_error;
  move_along(step_distance_m_ * cos_error / (1.0 - kappa * lateral_m_), command == nullptr ? 0 : command->branch);
  place_body(sin_error, cos_error);
}

bool LineVehicle::line_lost() const { return std::fabs(lateral_m_) > train_.line_lost_m; }

void LineVehicle::change_speed(const DriveCommand* command, double dt_s) {
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
  step_acceleration_mps2_ = (std::fabs(speed_mps_) - before_mps) / dt_s;
}

void LineVehicle::steer(double dt_s) {
  // The paint's unevenness passes under the sensors as the body moves: a first-order process in distance.
  constexpr double correlation_m = 0.05;
  const double distance_m = std::fabs(speed_mps_) * dt_s;
  const double keep = correlation_m / (correlation_m + distance_m);
  if (line_offset_sd_m_ > 0.0)
    line_noise_m_ = keep * line_noise_m_ + std::sqrt(1.0 - keep * keep) * line_random_.gaussian(0.0, line_offset_sd_m_);

  // Errors die out over 5 cm of way; at speed the lags allow no more than 12 rad/s.
  constexpr double per_m_max = 20.0;
  constexpr double radps_max = 12.0;
  constexpr double damping = 0.9;
  const double speed = std::fabs(speed_mps_);
  const double natural_per_m = std::min(per_m_max, radps_max / speed);
  const double forwards = speed_mps_ < 0.0 ? -1.0 : 1.0;
  const double kappa = circuit_->section(place_.section).curvature_at(place_.s_m);
  const double seen_lateral_m = lateral_m_ - line_noise_m_;
  const double wanted_radps = speed_mps_ * kappa - speed * (forwards * natural_per_m * natural_per_m * seen_lateral_m +
                                                            2.0 * damping * natural_per_m * heading_rad_);
  turn_rate_radps_ +=
      (std::clamp(wanted_radps, -train_.turn_rate_radps_max, train_.turn_rate_radps_max) - turn_rate_radps_) *
      turn_blend_;
  heading_rad_ += (turn_rate_radps_ - kappa * speed_mps_) * dt_s;
}

void LineVehicle::move_along(double distance_m, std::size_t branch) {
  place_.s_m += distance_m;
  // One step is a few millimetres, a section at least that: this goes round once or twice at most.
  for (;;) {
    const double length_m = circuit_->section(place_.section).length_m();
    if (place_.s_m > length_m) {
      if (circuit_->next(place_.section).empty()) return stop_at_end(length_m);
      place_.s_m -= length_m;
      to_next(branch);
    } else if (place_.s_m < 0.0) {
      if (circuit_->previous(place_.section).empty()) return stop_at_end(0.0);
      to_previous();
      place_.s_m += circuit_->section(place_.section).length_m();
    } else {
      return;
    }
  }
}

void LineVehicle::to_next(std::size_t branch) {
  const std::span<const zone::SectionId> ways = circuit_->next(place_.section);
  came_from_ = place_.section;
  place_.section = ways[std::min(branch, ways.size() - 1)];
}

void LineVehicle::to_previous() {
  const std::span<const zone::SectionId> ways = circuit_->previous(place_.section);
  const bool known = std::find(ways.begin(), ways.end(), came_from_) != ways.end();
  place_.section = known ? came_from_ : ways.front();
  came_from_ = zone::no_section;
}

void LineVehicle::stop_at_end(double s_m) {
  place_.s_m = s_m;
  speed_mps_ = 0.0;
  speed_reference_mps_ = 0.0;
}

void LineVehicle::place_body(double sin_error, double cos_error) {
  // X_MB = X_MP · (0, e, ψ). The path's own sine and cosine follow from the body's by turning back: one sincos saved.
  const Pose2 X_MP = circuit_->pose_at(place_);
  body_ = BodyPose::at({X_MP.x_m, X_MP.y_m, wrap_angle(X_MP.heading_rad + heading_rad_)});
  const double sin_path = body_.sin * cos_error - body_.cos * sin_error;
  const double cos_path = body_.cos * cos_error + body_.sin * sin_error;
  body_.X_MB.x_m -= lateral_m_ * sin_path;
  body_.X_MB.y_m += lateral_m_ * cos_path;
}

}  // namespace cosiva::physical
