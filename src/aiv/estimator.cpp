#include "aiv/estimator.h"

#include <cmath>
#include <limits>

namespace cosiva::aiv {
namespace {

/// Over another lane's tag: the antenna reads what lies this near to the vehicle's middle, whichever way it belongs to.
constexpr double under_vehicle_m = 0.08;
/// Two beacons that contradict the belief agree with each other when the way between them fits the odometer this well.
constexpr double agreement_m = 0.10;

}  // namespace

PositionEstimator::PositionEstimator(const zone::TrafficZone& zone, EstimatorModel model)
    : zone_{zone}, model_{model} {}

double PositionEstimator::sigma_m() const { return std::sqrt(variance_m2_); }

void PositionEstimator::place_at(zone::Place place) {
  motion_ = AivMotion{zone_.circuit, place};
  known_ = true;
  variance_m2_ = model_.sigma_start_m * model_.sigma_start_m;
  doubt_.reset();
}

std::optional<zone::Place> PositionEstimator::on_circuit(const Pose2& X_MB, double distance_m_max) const {
  const auto located = zone_.circuit.locate(position(X_MB), X_MB.heading_rad);
  if (located.distance_m > distance_m_max) return std::nullopt;
  const double turned_rad = wrap_angle(zone_.circuit.pose_at(located.place).heading_rad - X_MB.heading_rad);
  if (std::fabs(turned_rad) > pi / 3.0) return std::nullopt;
  return located.place;
}

double PositionEstimator::on_odometry(std::int64_t distance_um) {
  const auto before_um = odometer_um_;
  odometer_um_ = distance_um;
  if (!before_um) return 0.0;
  // Unsigned, because a damaged counter may jump from one end to the other.
  const auto step_um =
      static_cast<std::int64_t>(static_cast<std::uint64_t>(distance_um) - static_cast<std::uint64_t>(*before_um));
  const double step_m = static_cast<double>(step_um) * 1e-6;
  if (std::fabs(step_m) > model_.odometry_step_m_max) return 0.0;
  travelled_m_ += step_m;
  variance_m2_ += model_.variance_per_m * std::fabs(step_m);
  return known_ ? motion_.shift(zone_.circuit, step_m) : 0.0;
}

void PositionEstimator::on_odometer_reset() {
  odometer_um_.reset();
  variance_m2_ += model_.sigma_reset_m * model_.sigma_reset_m;
}

PositionEstimator::Fix PositionEstimator::on_tag(std::uint32_t number, double age_s, double speed_mps) {
  const double latency_m = speed_mps * (age_s + model_.reading_latency_s);
  if (const zone::Tag* tag = zone_.find_tag(number)) {
    last_tag_ = number;
    last_tag_travelled_m_ = travelled_m_ - latency_m;
    return on_landmark(tag->place, latency_m);
  }
  if (!zone_.beacons) return {};
  const std::optional<Point2> beacon = zone_.beacons->find(number);
  return beacon && known_ ? on_beacon(*beacon, latency_m) : Fix{};
}

std::optional<double> PositionEstimator::offset_to(zone::Place place, double limit_m) const {
  const zone::Place here = motion_.place(zone_.circuit);
  const auto ahead_m = zone_.circuit.distance_ahead(here, place, limit_m);
  const auto back_m = zone_.circuit.distance_ahead(place, here, limit_m);
  if (ahead_m && (!back_m || *ahead_m <= *back_m)) return *ahead_m;
  if (back_m) return -*back_m;
  return std::nullopt;
}

PositionEstimator::Fix PositionEstimator::jump_to(zone::Place place) {
  place_at(place);
  return {FixKind::relocated, 0.0};
}

PositionEstimator::Fix PositionEstimator::on_landmark(zone::Place place, double latency_m) {
  // It was read at the rim of the field that the vehicle drives into: ahead of the antenna, not under it.
  const zone::Place here = zone_.circuit.advance(place, latency_m - model_.antenna_range_m);
  if (!known_) return jump_to(here);
  const std::optional<double> offset_m = offset_to(here, model_.tag_gate_m);
  if (!offset_m) {
    // On a crossing the antenna also reads the tag of the lane it crosses: that one tells where we are, not on which
    // way.
    const Point2 tag = position(zone_.circuit.pose_at(place));
    const bool crossed = distance(tag, position(pose())) <= under_vehicle_m;
    return crossed ? on_beacon(tag, latency_m) : jump_to(here);
  }
  const double moved_m = motion_.shift(zone_.circuit, *offset_m);
  variance_m2_ = model_.sigma_fix_m * model_.sigma_fix_m;
  doubt_.reset();
  return {FixKind::corrected, moved_m};
}

PositionEstimator::Fix PositionEstimator::on_beacon(Point2 beacon, double latency_m) {
  // The foot of the beacon on the way near the belief. Sections further along than the gate cannot hold it.
  const zone::Circuit& circuit = zone_.circuit;
  std::optional<double> best_offset_m;
  double best_distance_m = under_vehicle_m;
  for (zone::SectionId id = 0; id < circuit.size(); ++id) {
    const auto near = circuit.section(id).nearest(beacon);
    if (near.distance_m >= best_distance_m) continue;
    const auto offset_m = offset_to({id, near.s_m}, model_.beacon_gate_m);
    if (!offset_m) continue;
    best_distance_m = near.distance_m;
    best_offset_m = offset_m;
  }
  if (!best_offset_m) return on_strange_beacon(beacon, latency_m);
  const double range_m = model_.antenna_range_m;
  const double rim_m =
      best_distance_m < range_m ? std::sqrt(range_m * range_m - best_distance_m * best_distance_m) : 0.0;
  const double moved_m = motion_.shift(circuit, *best_offset_m + latency_m - rim_m);
  variance_m2_ = model_.sigma_fix_m * model_.sigma_fix_m + best_distance_m * best_distance_m * 0.05;
  doubt_.reset();
  return {FixKind::corrected, moved_m};
}

PositionEstimator::Fix PositionEstimator::on_strange_beacon(Point2 beacon, double latency_m) {
  const std::optional<Sighting> before = doubt_;
  doubt_ = Sighting{beacon, travelled_m_};
  if (!before || before->beacon == beacon) return {FixKind::outlier, 0.0};
  const double way_m = std::fabs(travelled_m_ - before->travelled_m);
  // A curved way is longer than the straight line between its ends, never shorter.
  const double apart_m = distance(before->beacon, beacon);
  if (apart_m > way_m + agreement_m || way_m > 1.6 * apart_m + agreement_m) return {FixKind::outlier, 0.0};
  const double heading_rad = det_atan2(beacon.y_m - before->beacon.y_m, beacon.x_m - before->beacon.x_m);
  const auto located = zone_.circuit.locate(beacon, heading_rad);
  if (located.distance_m > under_vehicle_m) return {FixKind::outlier, 0.0};
  return jump_to(zone_.circuit.advance(located.place, latency_m));
}

}  // namespace cosiva::aiv
