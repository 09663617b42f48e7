#include "cosiva/aiv/decision/agent.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <utility>

#include "cosiva/aiv/decision/branch_choice.h"
#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// A detected body and a vehicle that reports its pose are one body when they are no further apart than this: the
/// errors of two positions, and the distance that the other vehicle has driven since its report.
constexpr double same_body_m = 0.10;
/// A vehicle that has stopped before an obstacle continues only with this much more free distance: echoes are noisy.
constexpr double resume_room_m = 0.05;
constexpr double base_warning_m = 0.30;
/// A vehicle that must not stop nearer than this is given no room: it stops earlier without commands.
constexpr double room_m_max = 10.0;
/// Braking for a virtual body is reported from this difference of speeds on, and until it is less than the second one.
constexpr double perceived_begins_mps = 0.01;
constexpr double perceived_ends_mps = 0.002;

}  // namespace

Agent::Agent(const zone::TrafficZone& zone, std::unique_ptr<SpeedPolicy> speed_policy, Lateness late,
             ActionCatalogue catalogue)
    : zone_{zone},
      speed_policy_{speed_policy ? std::move(speed_policy) : std::make_unique<CrispSpeedPolicy>()},
      envelope_{zone, late},
      one_way_{one_way_only(zone.circuit)},
      vehicle_{zone, one_way_, std::move(catalogue)} {}

void Agent::on_odometry(const wire::Odometry& odometry) {
  vehicle_.on_odometry(odometry, decision_.drive.speed_mmps > 0 && !decision_.drive.seek);
}

wire::Drive Agent::decide_backwards() {
  decision_.blocked = decision_.braking_for_virtual = decision_.wants_base = false;
  const zone::SpeedProfile& slow = zone_.profiles.slow;
  double speed_mps = vehicle_.back_up().speed_mps(slow, vehicle_.position().travelled_m());
  if (instructions_.speed_mps_max) speed_mps = std::min(speed_mps, *instructions_.speed_mps_max);
  wire::Drive& drive = decision_.drive;
  drive = this->drive(vehicle_.holds().any() ? 0.0 : speed_mps, slow);
  drive.speed_mmps = static_cast<std::int16_t>(-drive.speed_mmps);
  drive.seek = false;
  drive.goal.reset();
  return drive;
}

void Agent::take_over(const Agent& before) {
  vehicle_.take_over(before.vehicle_);
  inputs_.charge = before.inputs_.charge;
  instructions_ = before.instructions_;
}

Agent::Plan Agent::plan(double room_m, double base_end_m) const {
  const PositionEstimator& position = vehicle_.position();
  const double speed_mps = vehicle_.motion().speed_mps();
  // A vehicle that has stopped for an obstacle continues only with clearly more free distance.
  const double obstacle_m = decision_.blocked && room_m < clearance_m + resume_room_m ? 0.0 : room_m;
  const bool may_drive = !vehicle_.holds().any() && !vehicle_.progress().cancelling() && position.known();
  const bool leader_detected =
      inputs_.others.leader_mps && std::fabs(inputs_.others.leader_gap_m - room_m) <= same_body_m;
  constexpr double nothing = std::numeric_limits<double>::infinity();
  const auto closing_mps = leader_detected ? std::optional{speed_mps - *inputs_.others.leader_mps} : std::nullopt;
  const bool on_path = position.known() && !vehicle_.joining();
  const double foreseen_m = on_path ? envelope_.foreseen_m(position.outlook(), vehicle_.order()) : nothing;
  const Situation situation{.speed_mps = speed_mps,
                            .obstacle_ahead_m = obstacle_m,
                            .end_of_base_m = base_end_m,
                            .crossing_ahead_m = std::min(decision_.crossing_ahead_m, foreseen_m),
                            .charge = inputs_.charge,
                            .imposed = instructions_.imposed,
                            .closing_mps = closing_mps,
                            .crossing_margin_s = inputs_.others.crossing_margin_s,
                            .crossing_priority = inputs_.others.crossing_priority,
                            .release_distance_m = vehicle_.order().horizon_left() ? base_end_m : nothing,
                            .passed_m = on_path ? envelope_.passed_m(position.outlook()) : nothing,
                            .present = decision_.profile};
  const auto [profile, ratio] = may_drive ? speed_policy_->target(situation) : SpeedChoice{Profile::stop, 1.0};
  zone::SpeedProfile target_speed = kinematics(zone_.profiles, profile);
  target_speed.speed_mps *= ratio;
  if (instructions_.speed_mps_max)
    target_speed.speed_mps = std::min(target_speed.speed_mps, *instructions_.speed_mps_max);
  if (!position.known()) return {target_speed, {0.0, target_speed.braking_mps2}, std::nullopt};
  if (position.near_path() && target_speed.speed_mps > zone_.profiles.slow.speed_mps)
    target_speed = zone_.profiles.slow;
  const OrderProgress& progress = vehicle_.progress();
  const double path_left_m = std::min(progress.move_left_m(), progress.stop_left_m());
  // While the vehicle joins the path no order leads it, and its speed is the manoeuvre's.
  Limit limit =
      vehicle_.joining()
          ? envelope_.limit_off_path(obstacle_m, target_speed)
          : envelope_.limit({position.outlook(), speed_mps, obstacle_m, vehicle_.order(), barrier_m_, path_left_m},
                            target_speed);
  if (limit.speed_mps > 0.0 && !vehicle_.watch().may_sweep(position, limit.bend_ahead_m)) {
    limit.speed_mps = 0.0;
    limit.by_obstacle = true;
  }
  return {target_speed, limit, may_drive ? std::optional{profile} : std::nullopt};
}

bool Agent::limited_by_virtual(const Plan& plan, double sensed_m, double base_end_m) const {
  if (!(inputs_.perceived_m < sensed_m)) return false;
  const double free_mps = this->plan(sensed_m, base_end_m).limit.speed_mps;
  return plan.limit.speed_mps < free_mps - (decision_.braking_for_virtual ? perceived_ends_mps : perceived_begins_mps);
}

wire::Drive Agent::decide() {
  if (vehicle_.progress().cancelling() && vehicle_.motion().stopped()) vehicle_.end_cancel();
  if (vehicle_.back_up().active()) return decide_backwards();
  const PositionEstimator& position = vehicle_.position();
  constexpr double nothing = std::numeric_limits<double>::infinity();
  // An obstacle on the path matters only to a vehicle that is on the path.
  const double sensed_m = position.near_path() ? nothing : vehicle_.watch().ahead_m(position);
  const double base_end_m = vehicle_.joining() ? nothing : vehicle_.order().distance_to_base_end_m();
  const Plan plan = this->plan(std::min(sensed_m, inputs_.perceived_m), base_end_m);
  auto [target_speed, limit, chosen] = plan;
  if (!position.known()) {
    decision_.profile.reset();
    decision_.blocked = decision_.braking_for_virtual = decision_.wants_base = false;
    return drive(0.0, target_speed);
  }
  decision_.braking_for_virtual = limited_by_virtual(plan, sensed_m, base_end_m);
  COSIVA_EXPECT(chosen || limit.speed_mps == 0.0);
  decision_.profile = chosen;
  decision_.crossing_ahead_m = limit.crossing_ahead_m;
  decision_.blocked = limit.by_obstacle && limit.speed_mps < stopped_mps;
  const double speed_mps = vehicle_.motion().speed_mps();
  const double braking_m = speed_mps * speed_mps / (2.0 * target_speed.braking_mps2);
  decision_.wants_base = vehicle_.order().horizon_left() && base_end_m < braking_m + base_warning_m;
  target_speed.braking_mps2 = limit.braking_mps2;
  return drive(limit.speed_mps, target_speed, limit.end_m);
}

wire::Drive Agent::drive(double speed_mps, const zone::SpeedProfile& kinematics, double room_m) {
  const auto milli = [](double value, double top) { return std::nearbyint(std::clamp(1000.0 * value, 0.0, top)); };
  const PositionEstimator& position = vehicle_.position();
  const std::uint8_t branch = one_way_ ? 0 : choose_branch(zone_.circuit, position, vehicle_.order());
  wire::Drive& drive = decision_.drive;
  drive = {static_cast<std::int16_t>(milli(speed_mps, 32767.0)),
           static_cast<std::uint16_t>(milli(kinematics.acceleration_mps2, 65535.0)),
           static_cast<std::uint16_t>(milli(kinematics.braking_mps2, 65535.0)), branch, false};
  // PILS stops there by itself: this program may end before it commands to brake. Its own stop is the earlier one.
  if (room_m < room_m_max) drive.room_mm = static_cast<std::uint16_t>(milli(room_m + stop_line_m, 65535.0));
  drive.seek = position.near_path() && (drive.speed_mmps > 0 || position.off_path_estimator().manoeuvring());
  // PILS detects the floor at the body's actual pose, not at the estimated one: the nearest path need not be the
  // intended one.
  if (drive.seek)
    drive.goal = to_manoeuvre(inverse(position.pose()) * zone_.circuit.pose_at(position.track_position()));
  return drive;
}

Status Agent::status() const {
  const MotionState& motion = vehicle_.motion();
  const bool manoeuvring = vehicle_.position().off_path_estimator().manoeuvring() && !motion.stopped();
  return status_of(manoeuvring ? bend_creep_mps : motion.speed_mps(), instructions_.imposed);
}

void Agent::archive(Archive& archive) { archive(vehicle_, inputs_, instructions_, decision_); }

}  // namespace cosiva::aiv
