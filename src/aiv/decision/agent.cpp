#include "cosiva/aiv/decision/agent.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "cosiva/aiv/decision/branch_choice.h"
#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::aiv {
namespace {

constexpr double off_circuit_m_max = 0.25;
/// A detected body and a vehicle that reports its pose are one body when they are no further apart than this: the
/// errors of two positions, and the distance that the other vehicle has driven since its report.
constexpr double same_body_m = 0.10;
/// A vehicle that has stopped before an obstacle continues only with this much more free distance: echoes are noisy.
constexpr double resume_room_m = 0.05;
constexpr double base_warning_m = 0.30;
/// Braking for a virtual body is reported from this difference of speeds on, and until it is less than the second one.
constexpr double perceived_begins_mps = 0.01;
constexpr double perceived_ends_mps = 0.002;
/// Largest distance to the pose at which to join a path, and largest distance of that pose from the path.
constexpr double join_within_m = 0.70;
constexpr double join_off_m_max = 0.02;

}  // namespace

Agent::Agent(const zone::TrafficZone& zone, std::unique_ptr<SpeedPolicy> speed_policy, Lateness late)
    : zone_{zone},
      speed_policy_{speed_policy ? std::move(speed_policy) : std::make_unique<CrispSpeedPolicy>()},
      estimator_{zone},
      progress_{zone},
      envelope_{zone, late},
      one_way_{one_way_only(zone.circuit)},
      watch_{zone, one_way_} {}

void Agent::on_odometry(const wire::Odometry& odometry) {
  const auto rolled = estimator_.on_odometry(odometry);
  motion_.on_odometry(odometry);
  // Off the path there need not be a line.
  hold(Hold::line_lost, odometry.line_lost && !estimator_.off_path());
  // Without an order a distance backed up is not part of a remaining route.
  if (rolled.step_m > 0.0 || (rolled.step_m < 0.0 && order().active())) progress_.advance(rolled.step_m);
  if (rolled.kind == FixKind::relocated) on_relocated();
  joining_ = joining_ && estimator_.near_path();
  if (back_up_.active()) back_up_.on_odometry(estimator_.travelled_m(), on_line());
  // Driving is commanded and the vehicle does not move: PILS waits at the end of the commanded route.
  const bool driving = decision_.drive.speed_mmps > 0 && !decision_.drive.seek && !holds_.has(Hold::line_lost);
  if (!motion_.stuck(driving, estimator_.travelled_m())) return;
  if (const double correction_m = estimator_.on_stuck(); correction_m != 0.0) progress_.advance(correction_m);
}

PositionFix Agent::on_tag(const wire::TagRead& tag) {
  // When driving backwards the antenna's field comes from the other side; so short a distance needs no fix.
  if (back_up_.active()) return {};
  const auto fix = estimator_.on_tag(tag.number, 0.001 * tag.age_ms, motion_.speed_mps());
  if (fix.kind == FixKind::corrected) progress_.advance(fix.correction_m);
  if (fix.kind == FixKind::relocated) on_relocated();
  return fix;
}

void Agent::on_relocated() {
  watch_.clear_ahead();
  const zone::TrackPosition position = estimator_.known() ? estimator_.track_position() : zone::TrackPosition{};
  if (!progress_.relocate(estimator_.known() ? &position : nullptr)) return;
  follow_order();
  progress_.advance(0.0);
}

void Agent::on_ranges(const wire::Ranges& ranges) {
  if (estimator_.known()) watch_.on_ranges(estimator_, ranges);
}

Result<void> Agent::initialise_position(const Pose2& X_MB, std::string last_node_id) {
  if (order().active() || !motion_.stopped())
    return fail("position.busy", "a position is initialised only while the vehicle is stopped without an order");
  const auto position = position_on_circuit(zone_.circuit, X_MB, off_circuit_m_max);
  if (!position) {
    return fail("position.off_circuit",
                "no path of '" + zone_.name + "' passes within 0.25 m of the position in its direction");
  }
  // Where its sensors detect no line the vehicle is off-path, near the given position.
  if (holds_.has(Hold::line_lost) || estimator_.off_path())
    estimator_.set_off_path(X_MB);
  else
    estimator_.position_at(*position);
  progress_.set_last_node(std::move(last_node_id));
  watch_.clear_ahead();
  return {};
}

Result<void> Agent::join_line(const Pose2& X_MG) {
  if (!estimator_.near_path()) return fail("join.on_line", "the vehicle is not off-path");
  if (estimator_.off_path_estimator().manoeuvring()) return fail("join.busy", "the vehicle is joining a path already");
  const double far_m = distance(estimator_.pose(), X_MG);
  if (!(far_m <= join_within_m)) {
    return fail("join.too_far", "the pose is " + std::to_string(far_m) + " m away, further than " +
                                    std::to_string(join_within_m) + " m");
  }
  const auto line = zone::snap_to_path(zone_.circuit, X_MG, join_off_m_max);
  if (!line ||
      std::fabs(wrap_angle(zone_.circuit.pose_at(line->position).heading_rad - X_MG.heading_rad)) > on_line_rad)
    return fail("join.no_line", "no path of '" + zone_.name + "' passes there in that direction");
  estimator_.aim(line->position);
  watch_.clear_entry();
  joining_ = true;
  return {};
}

Result<void> Agent::begin_back_up(double distance_m) {
  if (!(distance_m >= 0.0 && distance_m <= BackUp::distance_m_max)) {
    return fail("back_up.distance", "a vehicle backs up at most " + std::to_string(BackUp::distance_m_max) +
                                        " m, not " + std::to_string(distance_m) + " m");
  }
  if (distance_m == 0.0) {
    back_up_.end();
    return {};
  }
  if (!on_line()) return fail("back_up.off_line", "the vehicle is not on a path");
  if (order().active() || progress_.cancelling())
    return fail("back_up.order", "the vehicle has an order, which has to be cancelled first");
  back_up_.begin(distance_m, estimator_.travelled_m());
  return {};
}

bool Agent::on_line() const {
  if (!estimator_.known()) return false;
  if (!estimator_.off_path()) return true;
  // The zone was switched, and a path of the new zone is under the vehicle by chance.
  const Pose2 X_BP = inverse(estimator_.pose()) * zone_.circuit.pose_at(estimator_.track_position());
  return estimator_.near_path() && !estimator_.off_path_estimator().manoeuvring() && to_stay(to_manoeuvre(X_BP)) &&
         std::fabs(X_BP.heading_rad) <= on_line_rad;
}

wire::Drive Agent::decide_backwards() {
  decision_.blocked = decision_.braking_for_virtual = decision_.wants_base = false;
  const zone::SpeedProfile& slow = zone_.profiles.slow;
  double speed_mps = back_up_.speed_mps(slow, estimator_.travelled_m());
  if (instructions_.speed_mps_max) speed_mps = std::min(speed_mps, *instructions_.speed_mps_max);
  wire::Drive& drive = decision_.drive;
  drive = this->drive(holds_.any() ? 0.0 : speed_mps, slow);
  drive.speed_mmps = static_cast<std::int16_t>(-drive.speed_mmps);
  drive.seek = false;
  drive.goal.reset();
  return drive;
}

Result<OrderBook::Verdict> Agent::take_order(const wire::Order& order) {
  if (!progress_.cancelling() && estimator_.pose_known() && !estimator_.known()) {
    return fail("noRouteError", "the nearest path of '" + zone_.name + "' passes " +
                                    std::to_string(estimator_.off_path_estimator().off_by_m()) +
                                    " m from the vehicle, further than " + std::to_string(zone::snap_within_m) + " m");
  }
  OrderBook::StartState reference{estimator_.known() ? estimator_.track_position() : zone::TrackPosition{},
                                  estimator_.known()};
  // With a remaining base the vehicle's position does not matter.
  const bool needs_position = !one_way_ && !progress_.book().base_left();
  if (needs_position && estimator_.known() && !estimator_.off_path())
    reference.also = same_positions(zone_.circuit, reference.position);
  auto verdict = progress_.offer(order, reference);
  if (verdict && *verdict != OrderBook::Verdict::ignored_same) {
    back_up_.end();
    if (needs_position && !(progress_.book().accepted_at() == reference.position))
      estimator_.take_same_position(progress_.book().accepted_at());
    follow_order();
    progress_.advance(0.0);
  }
  return verdict;
}

void Agent::take_over(const Agent& before) {
  estimator_.take_over(before.estimator_);
  progress_.take_over_ids(before.progress_);
  motion_.take_over(before.motion_);
  inputs_.charge = before.inputs_.charge;
  holds_ = before.holds_;
  instructions_ = before.instructions_;
  hold(Hold::zone_change, false);
  if (estimator_.off_path()) hold(Hold::line_lost, false);
}

Agent::Plan Agent::plan(double room_m, double base_end_m) const {
  // A vehicle that has stopped for an obstacle continues only with clearly more free distance.
  const double obstacle_m = decision_.blocked && room_m < clearance_m + resume_room_m ? 0.0 : room_m;
  const bool may_drive = !holds_.any() && !progress_.cancelling() && estimator_.known();
  const bool leader_detected =
      inputs_.others.leader_mps && std::fabs(inputs_.others.leader_gap_m - room_m) <= same_body_m;
  const auto closing_mps =
      leader_detected ? std::optional{motion_.speed_mps() - *inputs_.others.leader_mps} : std::nullopt;
  const Situation situation{.speed_mps = motion_.speed_mps(),
                            .obstacle_ahead_m = obstacle_m,
                            .end_of_base_m = base_end_m,
                            .crossing_ahead_m = decision_.crossing_ahead_m,
                            .charge = inputs_.charge,
                            .imposed = instructions_.imposed,
                            .closing_mps = closing_mps,
                            .crossing_margin_s = inputs_.others.crossing_margin_s,
                            .crossing_priority = inputs_.others.crossing_priority,
                            .present = decision_.profile};
  const Profile profile = may_drive ? speed_policy_->choose(situation) : Profile::stop;
  zone::SpeedProfile target_speed = kinematics(zone_.profiles, profile);
  if (instructions_.speed_mps_max)
    target_speed.speed_mps = std::min(target_speed.speed_mps, *instructions_.speed_mps_max);
  if (!estimator_.known()) return {target_speed, {0.0, target_speed.braking_mps2}, std::nullopt};
  if (estimator_.near_path() && target_speed.speed_mps > zone_.profiles.slow.speed_mps)
    target_speed = zone_.profiles.slow;
  // While the vehicle joins the path no order leads it, and its speed is the manoeuvre's.
  Limit limit = joining_
                    ? envelope_.limit_off_line(obstacle_m, target_speed)
                    : envelope_.limit({estimator_.outlook(), motion_.speed_mps(), obstacle_m, order()}, target_speed);
  if (limit.speed_mps > 0.0 && !watch_.may_sweep(estimator_, limit.bend_ahead_m)) {
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
  if (progress_.cancelling() && motion_.stopped()) {
    progress_.end_cancel();
    if (!one_way_ && estimator_.known()) follow_order();
  }
  if (back_up_.active()) return decide_backwards();
  constexpr double nothing = std::numeric_limits<double>::infinity();
  // An obstacle on the path matters only to a vehicle that is on the path.
  const double sensed_m = estimator_.near_path() ? nothing : watch_.ahead_m(estimator_);
  const double base_end_m = joining_ ? nothing : order().distance_to_base_end_m();
  const Plan plan = this->plan(std::min(sensed_m, inputs_.perceived_m), base_end_m);
  auto [target_speed, limit, chosen] = plan;
  if (!estimator_.known()) {
    decision_.profile.reset();
    decision_.blocked = decision_.braking_for_virtual = decision_.wants_base = false;
    return drive(0.0, target_speed);
  }
  decision_.braking_for_virtual = limited_by_virtual(plan, sensed_m, base_end_m);
  COSIVA_EXPECT(chosen || limit.speed_mps == 0.0);
  decision_.profile = chosen;
  decision_.crossing_ahead_m = limit.crossing_ahead_m;
  decision_.blocked = limit.by_obstacle && limit.speed_mps < stopped_mps;
  const double braking_m = motion_.speed_mps() * motion_.speed_mps() / (2.0 * target_speed.braking_mps2);
  decision_.wants_base = order().horizon_left() && base_end_m < braking_m + base_warning_m;
  target_speed.braking_mps2 = limit.braking_mps2;
  return drive(limit.speed_mps, target_speed);
}

wire::Drive Agent::drive(double speed_mps, const zone::SpeedProfile& kinematics) {
  const auto milli = [](double value, double top) { return std::nearbyint(std::clamp(1000.0 * value, 0.0, top)); };
  const std::uint8_t branch = one_way_ ? 0 : choose_branch(zone_.circuit, estimator_, order());
  wire::Drive& drive = decision_.drive;
  drive = {static_cast<std::int16_t>(milli(speed_mps, 32767.0)),
           static_cast<std::uint16_t>(milli(kinematics.acceleration_mps2, 65535.0)),
           static_cast<std::uint16_t>(milli(kinematics.braking_mps2, 65535.0)), branch, false};
  drive.seek = estimator_.near_path() && (drive.speed_mmps > 0 || estimator_.off_path_estimator().manoeuvring());
  // PILS detects the floor at the body's actual pose, not at the estimated one: the nearest path need not be the
  // intended one.
  if (drive.seek)
    drive.goal = to_manoeuvre(inverse(estimator_.pose()) * zone_.circuit.pose_at(estimator_.track_position()));
  return drive;
}

double Agent::turn_rate_radps() const {
  if (estimator_.off_path_estimator().manoeuvring()) return motion_.manoeuvre_turn_radps();
  if (!estimator_.known() || estimator_.off_path()) return 0.0;
  const zone::TrackPosition here = estimator_.track_position();
  return motion_.speed_mps() * zone_.circuit.section(here.section).curvature_at(here.s_m);
}

}  // namespace cosiva::aiv
