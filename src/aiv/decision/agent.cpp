#include "cosiva/aiv/decision/agent.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/zone/circuit/anchor.h"

namespace cosiva::aiv {
namespace {

/// Readings in a row under that before the vehicle counts as standing: one alone may be a jerk's zero crossing.
constexpr int standing_readings = 2;
constexpr double off_circuit_m_max = 0.25;
/// What stands before it and what says that it drives there are one body when they are no further apart: two positions'
/// errors, and what the other drove since it spoke.
constexpr double same_body_m = 0.10;
/// Having stopped before an obstacle it goes on only when this much more room is there: echoes are noisy.
constexpr double resume_room_m = 0.05;
constexpr double base_warning_m = 0.30;
/// It says that it brakes for what it feels from this much on, and until it is less than that.
constexpr double felt_begins_mps = 0.01;
constexpr double felt_ends_mps = 0.002;
/// Readings in a row without any progress before a manoeuvre counts as interrupted.
constexpr int still_readings_max = 5;
/// And before a vehicle that is told to drive counts as waiting at a joint.
constexpr int stuck_readings_max = 25;
constexpr double stuck_m = 0.0005;
/// Air around a body that turns on the spot.
constexpr double sweep_margin_m = 0.05;
/// So far it goes to join a line, and so near to the pose that it was told the line must lie.
constexpr double join_within_m = 0.70;
constexpr double join_off_m_max = 0.02;
/// It backs up so fast, for so many readings (50 a second) at most, and stops so much before the end.
constexpr double back_up_mps = 0.10;
constexpr int back_readings_max = 750;
constexpr double back_ends_m = 0.005;
/// A bend this near ahead may begin at any moment.
constexpr double bend_near_m = 0.03;
/// A fork counts as the next until the vehicle is so far beyond it: its body may be behind its belief.
constexpr double fork_passed_m = 0.10;
/// Forks further ahead than this are not looked for.
constexpr double fork_ahead_m = 3.0;
/// Rounding between the order's way and the joint's.
constexpr double rounding_m = 0.005;

}  // namespace

std::string_view to_string(Hold hold) {
  switch (hold) {
    case Hold::paused: return "paused";
    case Hold::broker_lost: return "broker lost";
    case Hold::server_lost: return "server lost";
    case Hold::board_lost: return "board lost";
    case Hold::board_faulty: return "board faulty";
    case Hold::line_lost: return "line lost";
    case Hold::zone_change: return "zone change";
  }
  return "?";
}

Agent::Agent(const zone::TrafficZone& zone, std::unique_ptr<SpeedChooser> chooser, Lateness late)
    : zone_{zone},
      chooser_{chooser ? std::move(chooser) : std::make_unique<CrispSpeedChooser>()},
      estimator_{zone},
      order_{zone},
      corridor_{zone},
      envelope_{zone, late},
      sweep_{zone.vehicle},
      one_way_{one_way_only(zone.circuit)} {}

void Agent::advance_order(double distance_m) {
  auto traversed = order_.travelled(distance_m);
  std::ranges::move(traversed, std::back_inserter(traversed_));
}

void Agent::on_odometry(const wire::Odometry& odometry) {
  const auto rolled = estimator_.on_odometry(odometry);
  note_motion(odometry);
  // Off the line there need not be one.
  hold(Hold::line_lost, odometry.line_lost && !estimator_.off_line());
  // Without an order what it backs up is no way that it has left to go.
  if (rolled.step_m > 0.0 || (rolled.step_m < 0.0 && order_.active())) advance_order(rolled.step_m);
  if (rolled.kind == PositionEstimator::FixKind::relocated) on_relocated();
  joining_ = joining_ && estimator_.beside();
  note_backing_up();
  note_stuck();
}

void Agent::note_motion(const wire::Odometry& odometry) {
  speed_mps_ = 0.001 * odometry.speed_mmps;
  slow_readings_ = std::fabs(speed_mps_) < standing_mps ? std::min(slow_readings_ + 1, standing_readings) : 0;
  turn_radps_ = 0.0;
  if (odometry.manoeuvre) {
    const bool still = manoeuvre_ == odometry.manoeuvre;
    still_readings_ = still ? std::min(still_readings_ + 1, still_readings_max) : 0;
    const std::uint32_t since_ms = odometry.board_ms - manoeuvre_ms_;
    if (manoeuvre_ && since_ms > 0 && since_ms < 1000)
      turn_radps_ = (odometry.manoeuvre->turned_mrad - manoeuvre_->turned_mrad) / static_cast<double>(since_ms);
    manoeuvre_ms_ = odometry.board_ms;
  }
  manoeuvre_ = odometry.manoeuvre;
  standing_ = slow_readings_ >= standing_readings && (!manoeuvre_ || still_readings_ >= still_readings_max);
}

void Agent::note_stuck() {
  const bool waits = told_.speed_mmps > 0 && !told_.seek && !manoeuvre_ && !holds(Hold::line_lost) &&
                     std::fabs(estimator_.travelled_m() - stuck_travelled_m_) < stuck_m;
  if (!waits) stuck_travelled_m_ = estimator_.travelled_m();
  stuck_readings_ = waits ? stuck_readings_ + 1 : 0;
  if (stuck_readings_ < stuck_readings_max) return;
  stuck_readings_ = 0;
  if (const double correction_m = estimator_.on_stuck(); correction_m != 0.0) advance_order(correction_m);
}

void Agent::on_odometry_lost() {
  speed_mps_ = 0.0;
  turn_radps_ = 0.0;
  slow_readings_ = standing_readings;
  still_readings_ = still_readings_max;
  standing_ = true;
}

void Agent::on_odometer_reset() { estimator_.on_odometer_reset(); }

PositionEstimator::Fix Agent::on_tag(const wire::TagRead& tag) {
  // Driving backwards the antenna's field comes from the other side; so short a way needs no fix.
  if (back_to_m_) return {};
  const auto fix = estimator_.on_tag(tag.number, 0.001 * tag.age_ms, speed_mps_);
  if (fix.kind == PositionEstimator::FixKind::corrected) advance_order(fix.correction_m);
  if (fix.kind == PositionEstimator::FixKind::relocated) on_relocated();
  return fix;
}

void Agent::on_relocated() {
  obstacle_.clear();
  if (!order_.active()) return;
  if (estimator_.known() && order_.relocate(estimator_.place())) {
    follow_order();
    advance_order(0.0);
  } else {
    order_.cancel();
    lost_order_ = true;
  }
}

void Agent::on_ranges(const wire::Ranges& ranges) {
  if (!estimator_.known()) return;
  look_ = corridor_.look(estimator_.outlook(), ranges);
  obstacle_.add(look_.ahead_m, estimator_.travelled_m());
  if (!one_way_ || estimator_.off_line()) around_.add(corridor_.nearest_m(ranges), 0.0);
  if (estimator_.beside()) entry_.add(in_entry(ranges) ? 0.0 : std::numeric_limits<double>::infinity(), 0.0);
}

void Agent::stand_at(zone::Place place) { estimator_.place_at(place); }

void Agent::stand_off(const Pose2& X_MB) { estimator_.stand_off(X_MB); }

Result<void> Agent::initialise_position(const Pose2& X_MB, std::string last_node_id) {
  if (order_.active() || !standing_)
    return fail("position.busy", "a position is initialised only while the vehicle stands without an order");
  const auto place = estimator_.on_circuit(X_MB, off_circuit_m_max);
  if (!place) {
    return fail("position.off_circuit",
                "no way of '" + zone_.name + "' passes within 0.25 m of the position in its direction");
  }
  // Where its sensors see no line it stands beside the one that it was told.
  if (holds(Hold::line_lost) || estimator_.off_line())
    estimator_.stand_off(X_MB);
  else
    estimator_.place_at(*place);
  order_.set_last_node(std::move(last_node_id));
  obstacle_.clear();
  return {};
}

Result<void> Agent::join_line(const Pose2& X_MG) {
  if (!estimator_.beside()) return fail("join.on_line", "it does not stand beside a line");
  if (estimator_.manoeuvring()) return fail("join.busy", "it is on its way to a line already");
  const double far_m = distance(estimator_.pose(), X_MG);
  if (!(far_m <= join_within_m)) {
    return fail("join.too_far",
                "that is " + std::to_string(far_m) + " m away, further than " + std::to_string(join_within_m) + " m");
  }
  const auto line = zone::anchor_of(zone_.circuit, X_MG, join_off_m_max);
  if (!line || std::fabs(wrap_angle(zone_.circuit.pose_at(line->place).heading_rad - X_MG.heading_rad)) > on_line_rad)
    return fail("join.no_line", "no way of '" + zone_.name + "' passes there in that direction");
  estimator_.aim(line->place);
  entry_.clear();
  joining_ = true;
  return {};
}

Result<void> Agent::back_up(double distance_m) {
  if (!(distance_m >= 0.0 && distance_m <= back_up_m_max)) {
    return fail("back_up.distance", "it backs up at most " + std::to_string(back_up_m_max) + " m, not " +
                                        std::to_string(distance_m) + " m");
  }
  if (distance_m == 0.0) {
    back_to_m_.reset();
    return {};
  }
  if (!on_line()) return fail("back_up.off_line", "it does not stand on a line");
  if (order_.active() || cancelling_) return fail("back_up.order", "it has an order; cancel that first");
  back_to_m_ = estimator_.travelled_m() - distance_m;
  back_readings_ = 0;
  backed_up_ = false;
  return {};
}

bool Agent::on_line() const {
  if (!estimator_.known()) return false;
  if (!estimator_.off_line()) return true;
  // The zone was switched, and the line is under it by chance.
  const Pose2 X_BP = inverse(estimator_.pose()) * zone_.circuit.pose_at(estimator_.place());
  return estimator_.beside() && !estimator_.manoeuvring() && to_stay(to_manoeuvre(X_BP)) &&
         std::fabs(X_BP.heading_rad) <= on_line_rad;
}

void Agent::note_backing_up() {
  if (!back_to_m_) return;
  const bool there = estimator_.travelled_m() <= *back_to_m_ + back_ends_m;
  if (there || !on_line() || ++back_readings_ > back_readings_max) {
    backed_up_ = there;
    back_to_m_.reset();
  }
}

wire::Drive Agent::decide_backwards() {
  blocked_ = braking_for_felt_ = wants_base_ = false;
  const zone::SpeedProfile& slow = zone_.profiles.slow;
  // v = √(2bs) stops at the end; no faster than it may go forwards.
  const double left_m = std::max(0.0, estimator_.travelled_m() - *back_to_m_);
  double speed_mps = std::min({back_up_mps, slow.speed_mps, std::sqrt(2.0 * slow.braking_mps2 * left_m)});
  if (speed_mps_max_) speed_mps = std::min(speed_mps, *speed_mps_max_);
  told_ = drive(holds_ == 0 ? speed_mps : 0.0, slow);
  told_.speed_mmps = static_cast<std::int16_t>(-told_.speed_mmps);
  told_.seek = false;
  told_.goal.reset();
  return told_;
}

Result<OrderBook::Verdict> Agent::take_order(const wire::Order& order) {
  if (cancelling_) return fail("orderUpdateError", "the order before it is being cancelled");
  if (estimator_.away()) {
    return fail("noRouteError", "the nearest way of '" + zone_.name + "' passes " +
                                    std::to_string(estimator_.off_by_m()) + " m from the vehicle, further than " +
                                    std::to_string(zone::anchor_within_m) + " m");
  }
  OrderBook::Standing standing{estimator_.known() ? estimator_.place() : zone::Place{}, estimator_.known()};
  // With a base before it, where it stands does not matter.
  const bool needs_place = !one_way_ && !order_.base_left();
  if (needs_place) standing.also = estimator_.same_places();
  auto verdict = order_.offer(order, standing);
  if (verdict && *verdict != OrderBook::Verdict::ignored_same) {
    back_to_m_.reset();
    if (needs_place && !(order_.accepted_at() == standing.place)) estimator_.take_same_place(order_.accepted_at());
    follow_order();
    advance_order(0.0);
  }
  return verdict;
}

void Agent::hold(Hold reason, bool on) {
  const auto bit = static_cast<std::uint8_t>(reason);
  holds_ = static_cast<std::uint8_t>(on ? holds_ | bit : holds_ & ~bit);
}

bool Agent::begin_cancel() {
  if (cancelling_) return true;
  if (!order_.active()) return false;
  cancelling_ = true;
  return true;
}

void Agent::take_over(const Agent& before) {
  estimator_.take_over(before.estimator_);
  order_.take_over_ids(before.order_);
  speed_mps_ = before.speed_mps_;
  slow_readings_ = before.slow_readings_;
  standing_ = before.standing_;
  manoeuvre_ = before.manoeuvre_;
  manoeuvre_ms_ = before.manoeuvre_ms_;
  still_readings_ = before.still_readings_;
  charge_ = before.charge_;
  holds_ = before.holds_;
  imposed_ = before.imposed_;
  speed_mps_max_ = before.speed_mps_max_;
  hold(Hold::zone_change, false);
  if (estimator_.off_line()) hold(Hold::line_lost, false);
}

Agent::Plan Agent::plan(double room_m, double base_end_m) const {
  // Once it stands for something it goes on only when there is clearly more room.
  const double obstacle_m = blocked_ && room_m < stand_off_m + resume_room_m ? 0.0 : room_m;
  const bool may_drive = holds_ == 0 && !cancelling_ && estimator_.known();
  const bool leader_seen = others_.leader_mps && std::fabs(others_.leader_gap_m - room_m) <= same_body_m;
  const auto closing_mps = leader_seen ? std::optional{speed_mps_ - *others_.leader_mps} : std::nullopt;
  const Situation situation{.speed_mps = speed_mps_,
                            .obstacle_ahead_m = obstacle_m,
                            .end_of_base_m = base_end_m,
                            .crossing_ahead_m = crossing_ahead_m_,
                            .charge = charge_,
                            .imposed = imposed_,
                            .closing_mps = closing_mps,
                            .crossing_margin_s = others_.crossing_margin_s,
                            .crossing_priority = others_.crossing_priority,
                            .present = chosen_};
  const Profile profile = may_drive ? chooser_->choose(situation) : Profile::stop;
  zone::SpeedProfile wish = kinematics(zone_.profiles, profile);
  if (speed_mps_max_) wish.speed_mps = std::min(wish.speed_mps, *speed_mps_max_);
  if (!estimator_.known()) return {wish, {0.0, wish.braking_mps2}, std::nullopt};
  if (estimator_.beside() && wish.speed_mps > zone_.profiles.slow.speed_mps) wish = zone_.profiles.slow;
  // On its way to the line no order leads it, and its speed is the manoeuvre's.
  Limit limit = joining_ ? envelope_.limit_off_line(obstacle_m, wish)
                         : envelope_.limit({estimator_.outlook(), speed_mps_, obstacle_m, order_}, wish);
  if (limit.speed_mps > 0.0 && !may_sweep(limit)) {
    limit.speed_mps = 0.0;
    limit.by_obstacle = true;
  }
  return {wish, limit, may_drive ? std::optional{profile} : std::nullopt};
}

bool Agent::in_entry(const wire::Ranges& ranges) {
  const Pose2 X_MG = zone_.circuit.pose_at(estimator_.place());
  if (estimator_.manoeuvred() && estimator_.left_line_at())
    sweep_.take_rest({*estimator_.left_line_at(), X_MG}, *estimator_.manoeuvred());
  else
    sweep_.take({estimator_.pose(), X_MG});
  return corridor_.any_echo(ranges, [&](Point2 p_B) { return sweep_.over(estimator_.pose() * p_B); });
}

bool Agent::may_sweep(const Limit& limit) const {
  if (estimator_.beside()) return entry_.obstacle_ahead_m(0.0) > 0.0;
  if (one_way_ && !estimator_.off_line()) return true;
  if (!estimator_.off_line() && limit.bend_ahead_m > bend_near_m) return true;
  const double corner_m = 0.5 * norm(zone_.vehicle.length_m, zone_.vehicle.width_m);
  return around_.obstacle_ahead_m(0.0) > corner_m + sweep_margin_m;
}

bool Agent::limited_by_felt(const Plan& plan, double sensed_m, double base_end_m) const {
  if (!(felt_m_ < sensed_m)) return false;
  const double free_mps = this->plan(sensed_m, base_end_m).limit.speed_mps;
  return plan.limit.speed_mps < free_mps - (braking_for_felt_ ? felt_ends_mps : felt_begins_mps);
}

wire::Drive Agent::decide() {
  if (cancelling_ && standing_) {
    order_.cancel();
    if (!one_way_ && estimator_.known()) follow_order();
    cancelling_ = false;
  }
  if (back_to_m_) return decide_backwards();
  constexpr double nothing = std::numeric_limits<double>::infinity();
  // What stands on the line matters to one that is on it.
  const double sensed_m = estimator_.beside() ? nothing : obstacle_.obstacle_ahead_m(estimator_.travelled_m());
  const double base_end_m = joining_ ? nothing : order_.distance_to_base_end_m();
  const Plan plan = this->plan(std::min(sensed_m, felt_m_), base_end_m);
  auto [wish, limit, chosen] = plan;
  if (!estimator_.known()) {
    chosen_.reset();
    blocked_ = false;
    braking_for_felt_ = false;
    wants_base_ = false;
    return drive(0.0, wish);
  }
  braking_for_felt_ = limited_by_felt(plan, sensed_m, base_end_m);
  chosen_ = chosen;
  crossing_ahead_m_ = limit.crossing_ahead_m;
  blocked_ = limit.by_obstacle && limit.speed_mps < standing_mps;
  const double braking_m = speed_mps_ * speed_mps_ / (2.0 * wish.braking_mps2);
  wants_base_ = order_.horizon_left() && base_end_m < braking_m + base_warning_m;
  wish.braking_mps2 = limit.braking_mps2;
  return drive(limit.speed_mps, wish);
}

wire::Drive Agent::drive(double speed_mps, const zone::SpeedProfile& kinematics) {
  const auto milli = [](double value, double top) { return std::nearbyint(std::clamp(1000.0 * value, 0.0, top)); };
  told_ = {static_cast<std::int16_t>(milli(speed_mps, 32767.0)),
           static_cast<std::uint16_t>(milli(kinematics.acceleration_mps2, 65535.0)),
           static_cast<std::uint16_t>(milli(kinematics.braking_mps2, 65535.0)), branch(), false};
  told_.seek = estimator_.beside() && (told_.speed_mmps > 0 || estimator_.manoeuvring());
  // PILS sees the floor where the body is, not where it is believed: the nearest line need not be the one meant.
  if (told_.seek) told_.goal = to_manoeuvre(inverse(estimator_.pose()) * zone_.circuit.pose_at(estimator_.place()));
  return told_;
}

std::uint8_t Agent::branch() const {
  if (one_way_) return 0;
  if (!estimator_.known()) return wire::no_branch;
  const zone::Circuit& circuit = zone_.circuit;
  const auto number = [&](zone::SectionId from, zone::SectionId to) {
    const auto ways = circuit.next(from);
    const auto index = std::ranges::find(ways, to) - ways.begin();
    return static_cast<std::uint8_t>(std::min<std::ptrdiff_t>(index, wire::no_branch - 1));
  };

  const Outlook outlook = estimator_.outlook();
  const double base_m = order_.distance_to_base_end_m();
  zone::SectionsAhead ahead = sections_ahead(circuit, outlook);
  double end_m = -outlook.here.s_m;
  std::uint8_t next = wire::no_branch;
  for (;;) {
    const zone::SectionId from = ahead.section();
    end_m += circuit.section(from).length_m();
    const bool decides = circuit.next(from).size() != 1 || bend_rad(circuit, from, ahead.next()) != 0.0;
    if (decides && ahead.decided() && base_m > end_m + rounding_m) next = number(from, ahead.next());
    if (decides || end_m > fork_ahead_m || !ahead.step()) break;
  }

  // The last one rolled over, as long as it is near.
  double back_m = outlook.here.s_m;
  zone::SectionId to = outlook.here.section;
  const auto gone = estimator_.course().gone();
  for (std::size_t i = gone.size(); i-- > 0 && back_m < std::min(fork_passed_m, 0.5 * (back_m + end_m));) {
    const zone::SectionId from = gone[i];
    if (bend_rad(circuit, from, to) != 0.0) break;  // turned: that is done
    if (circuit.next(from).size() > 1) return number(from, to);
    back_m += circuit.section(from).length_m();
    to = from;
  }
  return next;
}

double Agent::turn_rate_radps() const {
  if (estimator_.manoeuvring()) return turn_radps_;
  if (!estimator_.known() || estimator_.off_line()) return 0.0;
  const zone::Place here = estimator_.place();
  return speed_mps_ * zone_.circuit.section(here.section).curvature_at(here.s_m);
}

std::vector<wire::OrderNode> Agent::take_traversed() { return std::exchange(traversed_, {}); }

bool Agent::take_lost_order() { return std::exchange(lost_order_, false); }

}  // namespace cosiva::aiv
