#include "cosiva/physical/plant/vehicle_dynamics.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::physical {
namespace {

/// Moves `value` towards `target` by at most `step`.
double towards(double value, double target, double step) { return value + std::clamp(target - value, -step, step); }

/// Of the line's heading, as the line sensors detect it.
double detection_error_rad(double line_offset_sd_m, Random& random) {
  constexpr double sensors_ahead_m = 0.1;
  return line_offset_sd_m > 0.0 ? random.gaussian(0.0, line_offset_sd_m / sensors_ahead_m) : 0.0;
}

}  // namespace

LineVehicle::LineVehicle(const zone::Circuit& circuit, zone::TrackPosition start, double line_offset_sd_m,
                         Random line_noise)
    : circuit_{&circuit}, line_offset_sd_m_{line_offset_sd_m}, line_random_{line_noise}, position_{start} {
  line_noise_m_ = line_random_.gaussian(0.0, line_offset_sd_m_);
  put_body(0.0, 1.0);
  record_section();
}

void LineVehicle::step(const DriveCommand* command, double dt_s) {
  COSIVA_EXPECT(dt_s > 0.0 && dt_s <= 0.0201);
  if (dt_s != lag_dt_s_) {
    lag_dt_s_ = dt_s;
    motor_blend_ = 1.0 - det_exp(-dt_s / train_.motor_lag_s);
    turn_blend_ = 1.0 - det_exp(-dt_s / train_.turn_lag_s);
  }
  if (command != nullptr) branch_ = command->branch;
  goes_on_ = command != nullptr && command->speed_mps > 0.0;
  if (off_path_) return step_off_path(command, dt_s);
  change_speed(command, dt_s);
  if (speed_mps_ == 0.0) {
    step_distance_m_ = 0.0;
    turn_rate_radps_ = 0.0;
    return;
  }
  if (may_end_here_) brake_for_end(dt_s);
  steer(dt_s);
  step_distance_m_ = speed_mps_ * dt_s;
  const auto [sin_error, cos_error] = sincos(heading_rad_);
  const double kappa = circuit_->section(position_.section).curvature_at(position_.s_m);
  lateral_m_ += step_distance_m_ * sin_error;
  move_along(step_distance_m_ * cos_error / (1.0 - kappa * lateral_m_));
  put_body(sin_error, cos_error);
  if (manoeuvre_) X_MS_ = body_.X_MB;  // the vehicle came to a sharp bend
}

bool LineVehicle::line_lost() const { return off_path_ ? !lies_on_line_ : std::fabs(lateral_m_) > train_.line_lost_m; }

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

  // Errors decay over 5 cm of distance; at speed the lags allow no more than 12 rad/s.
  constexpr double per_m_max = 20.0;
  constexpr double radps_max = 12.0;
  constexpr double damping = 0.9;
  const double speed = std::fabs(speed_mps_);
  const double natural_per_m = std::min(per_m_max, radps_max / speed);
  const double forwards = speed_mps_ < 0.0 ? -1.0 : 1.0;
  const double kappa = circuit_->section(position_.section).curvature_at(position_.s_m);
  const double detected_lateral_m = lateral_m_ - line_noise_m_;
  const double wanted_radps =
      speed_mps_ * kappa - speed * (forwards * natural_per_m * natural_per_m * detected_lateral_m +
                                    2.0 * damping * natural_per_m * heading_rad_);
  turn_rate_radps_ +=
      (std::clamp(wanted_radps, -train_.turn_rate_radps_max, train_.turn_rate_radps_max) - turn_rate_radps_) *
      turn_blend_;
  heading_rad_ += (turn_rate_radps_ - kappa * speed_mps_) * dt_s;
}

void LineVehicle::move_along(double distance_m) {
  position_.s_m += distance_m;
  // One step is a few millimetres, a section at least that: this loop runs once or twice at most.
  for (;;) {
    const double length_m = circuit_->section(position_.section).length_m();
    if (position_.s_m > length_m) {
      if (may_end_here_) {
        const aiv::Onward onward = aiv::onward(*circuit_, position_.section, branch_);
        if (onward.section == zone::no_section) return stop_at_end(length_m);
        if (onward.turn_rad != 0.0) {
          stop_at_end(length_m);
          return goes_on_ ? begin_turn(onward) : void();
        }
      }
      position_.s_m -= length_m;
      to_next();
    } else if (position_.s_m < 0.0) {
      if (!to_previous()) return stop_at_end(0.0);
      position_.s_m += circuit_->section(position_.section).length_m();
    } else {
      return;
    }
  }
}

void LineVehicle::to_next() {
  const std::span<const zone::SectionId> branches = circuit_->next(position_.section);
  came_from_ = position_.section;
  position_.section = branches[std::min(branch_, branches.size() - 1)];
  record_section();
}

bool LineVehicle::to_previous() {
  const std::span<const zone::SectionId> branches = circuit_->previous(position_.section);
  const auto bends = [&](zone::SectionId id) { return circuit_->turn_at(id, position_.section) != 0.0; };
  const bool known = std::find(branches.begin(), branches.end(), came_from_) != branches.end() && !bends(came_from_);
  const auto before = known ? std::find(branches.begin(), branches.end(), came_from_)
                            : std::find_if_not(branches.begin(), branches.end(), bends);
  if (before == branches.end()) return false;
  position_.section = *before;
  came_from_ = zone::no_section;
  record_section();
  return true;
}

/// Most sections of most circuits have one smooth successor; a step on these costs one check of this flag.
void LineVehicle::record_section() {
  const zone::Circuit::Part& part = circuit_->part(position_.section);
  may_end_here_ = part.next.size() != 1 || part.pivots;
}

/// Where the path ends or bends sharply under its branch the vehicle brakes as hard as possible, down to a creep.
void LineVehicle::brake_for_end(double dt_s) {
  constexpr double creep_mps = 0.02;
  const double left_m = std::max(0.0, circuit_->section(position_.section).length_m() - position_.s_m);
  // v·dt + v²/2b = left.
  const double b = train_.braking_mps2_max;
  const double in_time_mps = std::max(creep_mps, b * (std::sqrt(dt_s * dt_s + 2.0 * left_m / b) - dt_s));
  if (speed_mps_ <= in_time_mps) return;
  const aiv::Onward onward = aiv::onward(*circuit_, position_.section, branch_);
  if (onward.section != zone::no_section && onward.turn_rad == 0.0) return;
  speed_mps_ = in_time_mps;
  speed_reference_mps_ = std::min(speed_reference_mps_, in_time_mps);
}

void LineVehicle::stop_at_end(double s_m) {
  // The wheels stop as soon as the body does: commanded to drive on at a joint that it may not cross, the vehicle
  // counts no distance.
  step_distance_m_ -= position_.s_m - s_m;
  position_.s_m = s_m;
  speed_mps_ = 0.0;
  speed_reference_mps_ = 0.0;
}

void LineVehicle::begin_turn(const aiv::Onward& onward) {
  turn_rate_radps_ = 0.0;
  off_path_ = true;
  lies_on_line_ = true;
  // The body turns until the sensors detect the line ahead; the detection is as accurate as the line's paint.
  goal_heading_rad_ = detection_error_rad(line_offset_sd_m_, line_random_);
  manoeuvre_.emplace(Pose2{0.0, 0.0, wrap_angle(onward.turn_rad - heading_rad_ + goal_heading_rad_)});
  // The joint stays in place under the body: e to the left of the old path, expressed along the new one.
  const auto [sin, cos] = sincos(onward.turn_rad);
  goal_ = {onward.section, std::max(0.0, sin * lateral_m_)};
  goal_lateral_m_ = cos * lateral_m_;
}

bool LineVehicle::begin_seek(const DriveCommand& command) {
  const auto track_position = aiv::sought(*circuit_, body_.X_MB, command.goal);
  if (!track_position) return false;
  goal_ = *track_position;
  // On the path already, the body only turns along it: steering removes the remaining offset.
  const auto here = circuit_->section(goal_.section).nearest(position(body_.X_MB));
  const Pose2 X_PB = inverse(circuit_->section(goal_.section).pose_at(here.s_m)) * body_.X_MB;
  const bool stays = (command.goal ? aiv::to_stay(*command.goal) : lies_on_line_) && lies_over(X_PB);
  if (stays) goal_.s_m = here.s_m;
  goal_lateral_m_ = stays ? X_PB.y_m : line_offset_sd_m_ > 0.0 ? line_random_.gaussian(0.0, line_offset_sd_m_) : 0.0;
  goal_heading_rad_ = detection_error_rad(line_offset_sd_m_, line_random_);
  const Pose2 X_MG = circuit_->pose_at(goal_) * Pose2{0.0, goal_lateral_m_, goal_heading_rad_};
  manoeuvre_.emplace(inverse(body_.X_MB) * X_MG);
  X_MS_ = body_.X_MB;
  return true;
}

void LineVehicle::step_off_path(const DriveCommand* command, double dt_s) {
  step_distance_m_ = 0.0;
  step_acceleration_mps2_ = 0.0;
  step_manoeuvre_ = {};
  const double speed_mps = command == nullptr ? 0.0 : command->speed_mps;
  if (!manoeuvre_) {  // on another floor than at its start
    if (speed_mps > 0.0 && command->seek) {
      if (!begin_seek(*command)) return;
    } else {
      if (speed_mps != 0.0 && lies_on_line_) off_path_ = false;
      return;
    }
  }
  step_manoeuvre_ = manoeuvre_->step(speed_mps, dt_s);
  body_ = BodyPose::at(X_MS_ * manoeuvre_->X_SB());
  if (manoeuvre_->done()) end_manoeuvre();
}

void LineVehicle::end_manoeuvre() {
  manoeuvre_.reset();
  off_path_ = false;
  came_from_ = zone::no_section;
  position_ = goal_;
  lateral_m_ = goal_lateral_m_;
  heading_rad_ = goal_heading_rad_;
  record_section();
  const auto [sin, cos] = sincos(heading_rad_);
  put_body(sin, cos);
}

void LineVehicle::set_zone(const zone::Circuit& circuit, bool turns) {
  COSIVA_EXPECT(is_stopped());
  circuit_ = &circuit;
  if (turns) {
    body_ = BodyPose::at(turned_round(body_.X_MB));
    line_noise_m_ = -line_noise_m_;
  }
  manoeuvre_.reset();
  off_path_ = true;
  came_from_ = zone::no_section;
  turn_rate_radps_ = 0.0;
  step_distance_m_ = 0.0;
  step_manoeuvre_ = {};
  // The body may be on a path by chance, as where the old floor and the new have a section in common.
  const auto entry_point = zone::snap_to_path(circuit, body_.X_MB, train_.line_lost_m);
  position_ = entry_point ? entry_point->position : zone::TrackPosition{0, 0.0};
  const Pose2 X_PB = inverse(circuit.pose_at(position_)) * body_.X_MB;
  lateral_m_ = X_PB.y_m;
  heading_rad_ = X_PB.heading_rad;
  lies_on_line_ = entry_point && lies_over(X_PB) && std::fabs(heading_rad_) <= aiv::on_line_rad;
  record_section();
}

void LineVehicle::archive(Archive& archive) {
  archive(position_, came_from_, speed_mps_, speed_reference_mps_, lateral_m_, heading_rad_, turn_rate_radps_,
          line_noise_m_, body_, branch_, off_path_, lies_on_line_, manoeuvre_, X_MS_, goal_, goal_lateral_m_,
          goal_heading_rad_);
  if (archive.reads()) record_section();
}

bool LineVehicle::lies_over(const Pose2& X_PB) const {
  constexpr double beyond_m = 1e-3;  // off the path, and not beyond its end
  return std::fabs(X_PB.x_m) <= beyond_m && std::fabs(X_PB.y_m) <= train_.line_lost_m;
}

void LineVehicle::put_body(double sin_error, double cos_error) {
  // X_MB = X_MP · (0, e, ψ). The path's own sine and cosine follow from the body's by turning back, which saves one
  // sincos.
  const Pose2 X_MP = circuit_->pose_at(position_);
  body_ = BodyPose::at({X_MP.x_m, X_MP.y_m, wrap_angle(X_MP.heading_rad + heading_rad_)});
  const double sin_path = body_.sin * cos_error - body_.cos * sin_error;
  const double cos_path = body_.cos * cos_error + body_.sin * sin_error;
  body_.X_MB.x_m -= lateral_m_ * sin_path;
  body_.X_MB.y_m += lateral_m_ * cos_path;
}

}  // namespace cosiva::physical
