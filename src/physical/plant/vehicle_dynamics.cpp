#include "cosiva/physical/plant/vehicle_dynamics.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/physical/plant/marking.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::physical {

LineVehicle::LineVehicle(const zone::Circuit& circuit, zone::TrackPosition start, double line_offset_sd_m,
                         Random line_noise)
    : circuit_{&circuit}, parts_{Dems{line_offset_sd_m, line_noise}, Pmot{DriveTrain{}}}, position_{start} {
  put_body(0.0, 1.0);
  record_section();
  read_line(0.0);
}

void LineVehicle::step(const DriveCommand* command, LineTracker& pils, double dt_s) {
  COSIVA_EXPECT(dt_s > 0.0 && dt_s <= 0.0201);
  if (command != nullptr) branch_ = command->branch;
  goes_on_ = command != nullptr && command->speed_mps > 0.0;
  if (off_path_) {
    pils.restart();
    return step_off_path(command, dt_s);
  }
  parts_.pmot.change_speed(command, dt_s);
  if (speed_mps() == 0.0) {
    step_distance_m_ = 0.0;
    parts_.pmot.end_turn();
    return;
  }
  if (may_end_here_) brake_for_end(dt_s);
  steer(pils, dt_s);
  step_distance_m_ = speed_mps() * dt_s;
  const auto [sin_error, cos_error] = sincos(heading_rad_);
  const double kappa = circuit_->section(position_.section).curvature_at(position_.s_m);
  lateral_m_ += step_distance_m_ * sin_error;
  move_along(step_distance_m_ * cos_error / (1.0 - kappa * lateral_m_));
  put_body(sin_error, cos_error);
  if (manoeuvre_) X_MS_ = body_.X_MB;  // the vehicle came to a sharp bend
}

bool LineVehicle::line_lost() const {
  return off_path_ ? !lies_on_line_ : std::fabs(lateral_m_) > parts_.pmot.train().line_lost_m;
}

void LineVehicle::steer(LineTracker& pils, double dt_s) {
  const double speed_mps = std::fabs(this->speed_mps());
  if (const double since_s = pils.pass(dt_s, this->speed_mps() > 0.0); since_s > 0.0) {
    read_line(speed_mps * since_s);
    pils.step(parts_.dems.readings(), speed_mps);
  }
  parts_.pmot.turn(speed_mps * pils.curvature_per_m(), dt_s);
  const double kappa = circuit_->section(position_.section).curvature_at(position_.s_m);
  heading_rad_ += (parts_.pmot.turn_rate_radps() - kappa * this->speed_mps()) * dt_s;
}

/// The leading row reads the line; its left is the body's right when the body drives backwards.
void LineVehicle::read_line(double distance_m) {
  const double row_m = lateral_m_ + dems_row_m * heading_rad_;
  if (speed_mps() >= 0.0)
    return parts_.dems.read(marking_before_m(*circuit_, position_, dems_row_m, branch_) - row_m, distance_m);
  const double behind_m = lateral_m_ - dems_row_m * heading_rad_;
  const bool known = came_from_ != zone::no_section && circuit_->turn_at(came_from_, position_.section) == 0.0;
  parts_.dems.read(behind_m - marking_behind_m(*circuit_, position_, dems_row_m, known ? came_from_ : zone::no_section),
                   distance_m);
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
  const double b = parts_.pmot.train().braking_mps2_max;
  const double in_time_mps = std::max(creep_mps, b * (std::sqrt(dt_s * dt_s + 2.0 * left_m / b) - dt_s));
  if (speed_mps() <= in_time_mps) return;
  const aiv::Onward onward = aiv::onward(*circuit_, position_.section, branch_);
  if (onward.section != zone::no_section && onward.turn_rad == 0.0) return;
  parts_.pmot.limit_speed(in_time_mps);
}

void LineVehicle::stop_at_end(double s_m) {
  // The wheels stop as soon as the body does: commanded to drive on at a joint that it may not cross, the vehicle
  // counts no distance.
  step_distance_m_ -= position_.s_m - s_m;
  position_.s_m = s_m;
  parts_.pmot.stop();
}

void LineVehicle::begin_turn(const aiv::Onward& onward) {
  parts_.pmot.end_turn();
  off_path_ = true;
  lies_on_line_ = true;
  // The body turns until the sensors detect the line ahead; the detection is as accurate as the line's paint.
  goal_heading_rad_ = parts_.dems.heading_error_rad();
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
  goal_lateral_m_ = stays ? X_PB.y_m : parts_.dems.lateral_error_m();
  goal_heading_rad_ = parts_.dems.heading_error_rad();
  const Pose2 X_MG = circuit_->pose_at(goal_) * Pose2{0.0, goal_lateral_m_, goal_heading_rad_};
  manoeuvre_.emplace(inverse(body_.X_MB) * X_MG);
  X_MS_ = body_.X_MB;
  return true;
}

void LineVehicle::step_off_path(const DriveCommand* command, double dt_s) {
  step_distance_m_ = 0.0;
  parts_.pmot.rest();
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
  read_line(0.0);
}

void LineVehicle::set_zone(const zone::Circuit& circuit, bool turns) {
  COSIVA_EXPECT(is_stopped());
  circuit_ = &circuit;
  if (turns) body_ = BodyPose::at(turned_round(body_.X_MB));
  manoeuvre_.reset();
  off_path_ = true;
  came_from_ = zone::no_section;
  parts_.pmot.end_turn();
  step_distance_m_ = 0.0;
  step_manoeuvre_ = {};
  // The body may be on a path by chance, as where the old floor and the new have a section in common.
  const auto entry_point = zone::snap_to_path(circuit, body_.X_MB, parts_.pmot.train().line_lost_m);
  position_ = entry_point ? entry_point->position : zone::TrackPosition{0, 0.0};
  const Pose2 X_PB = inverse(circuit.pose_at(position_)) * body_.X_MB;
  lateral_m_ = X_PB.y_m;
  heading_rad_ = X_PB.heading_rad;
  lies_on_line_ = entry_point && lies_over(X_PB) && std::fabs(heading_rad_) <= aiv::on_line_rad;
  record_section();
  lies_on_line_ ? read_line(0.0) : parts_.dems.read_nothing();
}

void LineVehicle::archive(Archive& archive) {
  archive(position_, came_from_, lateral_m_, heading_rad_, parts_.pmot, parts_.dems, body_, branch_, off_path_,
          lies_on_line_, manoeuvre_, X_MS_, goal_, goal_lateral_m_, goal_heading_rad_);
  if (archive.reads()) record_section();
}

bool LineVehicle::lies_over(const Pose2& X_PB) const {
  constexpr double beyond_m = 1e-3;  // off the path, and not beyond its end
  return std::fabs(X_PB.x_m) <= beyond_m && std::fabs(X_PB.y_m) <= parts_.pmot.train().line_lost_m;
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
