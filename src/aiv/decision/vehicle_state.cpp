#include "cosiva/aiv/decision/vehicle_state.h"

#include <cmath>
#include <string>
#include <utility>

#include "cosiva/aiv/motion/manoeuvre.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::aiv {
namespace {

constexpr double off_circuit_m_max = 0.25;
/// Largest distance to the pose at which to join a path, and largest distance of that pose from the path.
constexpr double join_within_m = 0.70;
constexpr double join_off_m_max = 0.02;

/// Whether the vehicle is on a path, followed or not.
bool on_line(const PositionEstimator& estimator, const zone::Circuit& circuit) {
  if (!estimator.known()) return false;
  if (!estimator.off_path()) return true;
  // The zone was switched, and a path of the new zone is under the vehicle by chance.
  const Pose2 X_BP = inverse(estimator.pose()) * circuit.pose_at(estimator.track_position());
  return estimator.near_path() && !estimator.off_path_estimator().manoeuvring() && to_stay(to_manoeuvre(X_BP)) &&
         std::fabs(X_BP.heading_rad) <= on_line_rad;
}

/// The position of the pose at which a vehicle at X_MB is to join a path.
Result<zone::TrackPosition> entry_position(const zone::TrafficZone& zone, const Pose2& X_MB, const Pose2& X_MG) {
  const double far_m = distance(X_MB, X_MG);
  if (!(far_m <= join_within_m)) {
    return fail("join.too_far", "the pose is " + std::to_string(far_m) + " m away, further than " +
                                    std::to_string(join_within_m) + " m");
  }
  const auto line = zone::snap_to_path(zone.circuit, X_MG, join_off_m_max);
  if (!line || std::fabs(wrap_angle(zone.circuit.pose_at(line->position).heading_rad - X_MG.heading_rad)) > on_line_rad)
    return fail("join.no_line", "no path of '" + zone.name + "' passes there in that direction");
  return line->position;
}

}  // namespace

VehicleState::VehicleState(const zone::TrafficZone& zone, bool one_way, ActionCatalogue catalogue)
    : zone_{zone}, one_way_{one_way}, estimator_{zone}, progress_{zone, std::move(catalogue)}, watch_{zone, one_way} {}

void VehicleState::on_odometry(const wire::Odometry& odometry, bool driving) {
  COSIVA_EXPECT(!back_up_.active() || !order().active());
  const auto rolled = estimator_.on_odometry(odometry);
  motion_.on_odometry(odometry);
  // Off the path there need not be a line.
  hold(Hold::line_lost, odometry.line_lost && !estimator_.off_path());
  // Without an order a distance backed up is not part of a remaining route.
  if (rolled.step_m > 0.0 || (rolled.step_m < 0.0 && order().active())) progress_.advance(rolled.step_m);
  if (rolled.kind == FixKind::relocated) on_relocated();
  joining_ = joining_ && estimator_.near_path();
  if (back_up_.active()) back_up_.on_odometry(estimator_.travelled_m(), on_line(estimator_, zone_.circuit));
  // Driving is commanded and the vehicle does not move: PILS waits at the end of the commanded route.
  if (!motion_.stuck(driving && !holds_.has(Hold::line_lost), estimator_.travelled_m())) return;
  if (const double correction_m = estimator_.on_stuck(); correction_m != 0.0) progress_.advance(correction_m);
}

PositionFix VehicleState::on_tag(const wire::TagRead& tag) {
  // When driving backwards the antenna's field comes from the other side; so short a distance needs no fix.
  if (back_up_.active()) return {};
  const auto fix = estimator_.on_tag(tag.number, 0.001 * tag.age_ms, motion_.speed_mps());
  if (fix.kind == FixKind::corrected) progress_.advance(fix.correction_m);
  if (fix.kind == FixKind::relocated) on_relocated();
  return fix;
}

void VehicleState::on_relocated() {
  watch_.clear_ahead();
  const zone::TrackPosition position = estimator_.known() ? estimator_.track_position() : zone::TrackPosition{};
  if (!progress_.relocate(estimator_.known() ? &position : nullptr)) return;
  follow_order();
  progress_.advance(0.0);
}

void VehicleState::on_ranges(const wire::Ranges& ranges) {
  if (estimator_.known()) watch_.on_ranges(estimator_, ranges);
}

Result<void> VehicleState::initialise_position(const Pose2& X_MB, std::string last_node_id) {
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

Result<void> VehicleState::join_line(const Pose2& X_MG) {
  if (!estimator_.near_path()) return fail("join.on_line", "the vehicle is not off-path");
  if (!estimator_.off_path_estimator().manoeuvring()) {
    const auto position = entry_position(zone_, estimator_.pose(), X_MG);
    if (!position) return tl::unexpected(position.error());
    estimator_.aim(*position);
  } else if (joining_ || order().active() || progress_.cancelling()) {
    return fail("join.busy", "the vehicle is joining a path already");
  }
  watch_.clear_entry();
  joining_ = true;
  return {};
}

Result<void> VehicleState::begin_back_up(double distance_m) {
  if (!(distance_m >= 0.0 && distance_m <= BackUp::distance_m_max)) {
    return fail("back_up.distance", "a vehicle backs up at most " + std::to_string(BackUp::distance_m_max) +
                                        " m, not " + std::to_string(distance_m) + " m");
  }
  if (distance_m == 0.0) {
    back_up_.end();
    return {};
  }
  if (!on_line(estimator_, zone_.circuit)) return fail("back_up.off_path", "the vehicle is not on a path");
  if (order().active() || progress_.cancelling())
    return fail("back_up.order", "the vehicle has an order, which has to be cancelled first");
  back_up_.begin(distance_m, estimator_.travelled_m());
  return {};
}

Result<OrderBook::Verdict> VehicleState::take_order(const wire::Order& order, bool actions_left) {
  // A pending cancelOrder refuses any order, wherever the vehicle is.
  if (progress_.cancelling()) return progress_.offer(order, {});
  if (estimator_.pose_known() && !estimator_.known()) {
    return fail("noRouteError", "the nearest path of '" + zone_.name + "' passes " +
                                    std::to_string(estimator_.off_path_estimator().off_by_m()) +
                                    " m from the vehicle, further than " + std::to_string(zone::snap_within_m) + " m");
  }
  OrderBook::StartState reference{
      estimator_.known() ? estimator_.track_position() : zone::TrackPosition{}, estimator_.known(), {}, actions_left};
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

void VehicleState::end_cancel() {
  COSIVA_EXPECT(motion_.stopped());
  progress_.end_cancel();
  if (!one_way_ && estimator_.known()) follow_order();
}

void VehicleState::take_over(const VehicleState& before) {
  estimator_.take_over(before.estimator_);
  progress_.take_over_ids(before.progress_);
  motion_.take_over(before.motion_);
  holds_ = before.holds_;
  hold(Hold::zone_change, false);
  hold(Hold::action, false);
  if (estimator_.off_path()) hold(Hold::line_lost, false);
}

double VehicleState::turn_rate_radps() const {
  if (estimator_.off_path_estimator().manoeuvring()) return motion_.manoeuvre_turn_radps();
  if (!estimator_.known() || estimator_.off_path()) return 0.0;
  const zone::TrackPosition here = estimator_.track_position();
  return motion_.speed_mps() * zone_.circuit.section(here.section).curvature_at(here.s_m);
}

void VehicleState::archive(Archive& archive) {
  archive(estimator_, progress_, watch_, motion_, holds_, back_up_, joining_);
}

}  // namespace cosiva::aiv
