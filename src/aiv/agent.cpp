#include "aiv/agent.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cosiva::aiv {
namespace {

constexpr double standing_mps = 0.01;
/// Readings in a row under that before the vehicle counts as standing: one alone may be a jerk's zero crossing.
constexpr int standing_readings = 2;
constexpr double off_circuit_m_max = 0.25;
/// Having stopped before an obstacle it goes on only when this much more room is there: echoes are noisy.
constexpr double resume_room_m = 0.05;
constexpr double base_warning_m = 0.30;
/// It says that it brakes for what it feels from this much on, and until it is less than that.
constexpr double felt_begins_mps = 0.01;
constexpr double felt_ends_mps = 0.002;

}  // namespace

std::string_view to_string(Hold hold) {
  switch (hold) {
    case Hold::paused: return "paused";
    case Hold::broker_lost: return "broker lost";
    case Hold::server_lost: return "server lost";
    case Hold::board_lost: return "board lost";
    case Hold::board_faulty: return "board faulty";
    case Hold::line_lost: return "line lost";
  }
  return "?";
}

Agent::Agent(const zone::TrafficZone& zone, std::unique_ptr<SpeedChooser> chooser)
    : zone_{zone},
      chooser_{chooser ? std::move(chooser) : std::make_unique<CrispSpeedChooser>()},
      estimator_{zone},
      order_{zone},
      corridor_{zone},
      envelope_{zone} {}

void Agent::advance_order(double distance_m) {
  auto traversed = order_.travelled(distance_m);
  std::ranges::move(traversed, std::back_inserter(traversed_));
}

void Agent::on_odometry(const wire::Odometry& odometry) {
  const double step_m = estimator_.on_odometry(odometry.distance_um);
  speed_mps_ = 0.001 * odometry.speed_mmps;
  slow_readings_ = std::fabs(speed_mps_) < standing_mps ? std::min(slow_readings_ + 1, standing_readings) : 0;
  standing_ = slow_readings_ >= standing_readings;
  hold(Hold::line_lost, odometry.line_lost);
  if (step_m != 0.0) advance_order(step_m);
}

void Agent::on_odometry_lost() {
  speed_mps_ = 0.0;
  slow_readings_ = standing_readings;
  standing_ = true;
}

void Agent::on_odometer_reset() { estimator_.on_odometer_reset(); }

PositionEstimator::Fix Agent::on_tag(const wire::TagRead& tag) {
  const auto fix = estimator_.on_tag(tag.number, 0.001 * tag.age_ms, speed_mps_);
  if (fix.kind == PositionEstimator::FixKind::corrected) advance_order(fix.correction_m);
  if (fix.kind == PositionEstimator::FixKind::relocated) {
    obstacle_.clear();
    if (order_.relocate(estimator_.place())) {
      advance_order(0.0);
    } else {
      order_.cancel();
      lost_order_ = true;
    }
  }
  return fix;
}

void Agent::on_ranges(const wire::Ranges& ranges) {
  if (!estimator_.known()) return;
  look_ = corridor_.look(estimator_.place(), ranges);
  obstacle_.add(look_.ahead_m, estimator_.travelled_m());
}

void Agent::stand_at(zone::Place place) { estimator_.place_at(place); }

Result<void> Agent::initialise_position(const Pose2& X_MB, std::string last_node_id) {
  if (order_.active() || !standing_)
    return fail("position.busy", "a position is initialised only while the vehicle stands without an order");
  const auto place = estimator_.on_circuit(X_MB, off_circuit_m_max);
  if (!place) {
    return fail("position.off_circuit",
                "no way of '" + zone_.name + "' passes within 0.25 m of the position in its direction");
  }
  estimator_.place_at(*place);
  order_.set_last_node(std::move(last_node_id));
  obstacle_.clear();
  return {};
}

Result<OrderBook::Verdict> Agent::take_order(const wire::Order& order) {
  if (cancelling_) return fail("orderUpdateError", "the order before it is being cancelled");
  const OrderBook::Standing standing{estimator_.known() ? estimator_.place() : zone::Place{}, estimator_.known()};
  auto verdict = order_.offer(order, standing);
  if (verdict && *verdict != OrderBook::Verdict::ignored_same) advance_order(0.0);
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

Agent::Plan Agent::plan(double room_m, double base_end_m) const {
  // Once it stands for something it goes on only when there is clearly more room.
  const double obstacle_m = blocked_ && room_m < stand_off_m + resume_room_m ? 0.0 : room_m;
  const bool may_drive = holds_ == 0 && !cancelling_ && estimator_.known();
  const Situation situation{.speed_mps = speed_mps_,
                            .obstacle_ahead_m = obstacle_m,
                            .end_of_base_m = base_end_m,
                            .crossing_ahead_m = crossing_ahead_m_,
                            .charge = charge_,
                            .imposed = imposed_};
  const Profile profile = may_drive ? chooser_->choose(situation) : Profile::stop;
  zone::SpeedProfile wish = kinematics(zone_.profiles, profile);
  if (speed_mps_max_) wish.speed_mps = std::min(wish.speed_mps, *speed_mps_max_);
  if (!estimator_.known()) return {wish, {0.0, wish.braking_mps2}};
  return {wish, envelope_.limit({estimator_.place(), speed_mps_, obstacle_m, order_}, wish)};
}

bool Agent::limited_by_felt(const Plan& plan, double sensed_m, double base_end_m) const {
  if (!(felt_m_ < sensed_m)) return false;
  const double free_mps = this->plan(sensed_m, base_end_m).limit.speed_mps;
  return plan.limit.speed_mps < free_mps - (braking_for_felt_ ? felt_ends_mps : felt_begins_mps);
}

wire::Drive Agent::decide() {
  if (cancelling_ && standing_) {
    order_.cancel();
    cancelling_ = false;
  }
  const double sensed_m = obstacle_.obstacle_ahead_m(estimator_.travelled_m());
  const double base_end_m = order_.distance_to_base_end_m();
  auto [wish, limit] = plan(std::min(sensed_m, felt_m_), base_end_m);
  if (!estimator_.known()) {
    blocked_ = false;
    braking_for_felt_ = false;
    wants_base_ = false;
    return drive(0.0, wish);
  }
  braking_for_felt_ = limited_by_felt({wish, limit}, sensed_m, base_end_m);
  crossing_ahead_m_ = limit.crossing_ahead_m;
  blocked_ = limit.by_obstacle && limit.speed_mps < standing_mps;
  const double braking_m = speed_mps_ * speed_mps_ / (2.0 * wish.braking_mps2);
  wants_base_ = order_.horizon_left() && base_end_m < braking_m + base_warning_m;
  wish.braking_mps2 = limit.braking_mps2;
  return drive(limit.speed_mps, wish);
}

wire::Drive Agent::drive(double speed_mps, const zone::SpeedProfile& kinematics) const {
  const auto milli = [](double value, double top) { return std::nearbyint(std::clamp(1000.0 * value, 0.0, top)); };
  return {static_cast<std::int16_t>(milli(speed_mps, 32767.0)),
          static_cast<std::uint16_t>(milli(kinematics.acceleration_mps2, 65535.0)),
          static_cast<std::uint16_t>(milli(kinematics.braking_mps2, 65535.0)), 0};
}

double Agent::turn_rate_radps() const {
  if (!estimator_.known()) return 0.0;
  const zone::Place here = estimator_.place();
  return speed_mps_ * zone_.circuit.section(here.section).curvature_at(here.s_m);
}

std::vector<wire::OrderNode> Agent::take_traversed() { return std::exchange(traversed_, {}); }

bool Agent::take_lost_order() { return std::exchange(lost_order_, false); }

}  // namespace cosiva::aiv
