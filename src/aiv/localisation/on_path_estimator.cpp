#include "cosiva/aiv/localisation/on_path_estimator.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "cosiva/aiv/motion/outlook.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {
namespace {

/// Over another lane's tag: the antenna reads a tag this near to the body origin, whatever section the tag belongs to.
constexpr double under_vehicle_m = 0.08;
/// A tag whose own section is this much further off than the section below the vehicle lies on a lane driven in both
/// directions.
constexpr double opposite_m = 0.10;
/// Two beacons that contradict the estimate agree when the distance between them fits the odometer this well.
constexpr double agreement_m = 0.10;
/// Positions this near to each other, with directions this similar, are one position to a stopped vehicle.
constexpr double same_position_m = 0.05;
constexpr double same_position_rad = 0.2;

}  // namespace

double OnPathEstimator::sigma_m() const { return std::sqrt(variance_m2_); }

void OnPathEstimator::position_at(zone::TrackPosition track_position) {
  path_.jump_to(track_position);
  known_ = true;
  variance_m2_ = model_.sigma_start_m * model_.sigma_start_m;
  doubt_.reset();
}

void OnPathEstimator::take_same_position(zone::TrackPosition track_position) {
  const double variance_m2 = variance_m2_;
  position_at(track_position);
  variance_m2_ = variance_m2;
}

void OnPathEstimator::leave_path(std::optional<zone::TrackPosition> entry_point) {
  doubt_.reset();
  known_ = entry_point.has_value();
  if (entry_point)
    path_.jump_without_course(*entry_point);
  else
    path_.clear_course();
  variance_m2_ = std::max(variance_m2_, model_.sigma_start_m * model_.sigma_start_m);
}

void OnPathEstimator::land_on(zone::TrackPosition track_position) {
  const double variance_m2 = variance_m2_;
  position_at(track_position);
  variance_m2_ = std::max(variance_m2, variance_m2_);
}

double OnPathEstimator::joint_gate_m() const { return std::max(model_.bend_gate_m, 3.0 * sigma_m()); }

double OnPathEstimator::on_stuck() {
  const zone::Circuit& circuit = path_.circuit();
  double end_m = -path_.track_position().s_m;
  for (zone::SectionLookAhead ahead = section_look_ahead(circuit, path_.outlook());; ahead.step()) {
    const zone::SectionId id = ahead.section();
    end_m += circuit.section(id).length_m();
    if (end_m > joint_gate_m()) return 0.0;
    const bool only_branch = circuit.next(id).size() == 1 && bend_rad(circuit, id, ahead.next()) == 0.0;
    if (!only_branch) break;
  }
  // Slightly less, so that rounding does not carry the estimate over the joint.
  constexpr double hair_m = 1e-6;
  variance_m2_ = model_.sigma_start_m * model_.sigma_start_m;
  return end_m > hair_m ? shift(end_m - hair_m) : 0.0;
}

double OnPathEstimator::on_turn_begun() {
  // The vehicle turns where the path bends, and is therefore at the bend.
  const zone::Circuit& circuit = path_.circuit();
  double end_m = -path_.track_position().s_m;
  for (zone::SectionLookAhead ahead = section_look_ahead(circuit, path_.outlook());;) {
    const zone::SectionId id = ahead.section();
    end_m += circuit.section(id).length_m();
    if (end_m > joint_gate_m()) return 0.0;
    const auto bends = [&](zone::SectionId to) { return bend_rad(circuit, id, to) != 0.0; };
    if (ahead.decided() ? bends(ahead.next()) : std::ranges::any_of(circuit.next(id), bends)) {
      constexpr double hair_m = 1e-6;  // the joint itself stops the estimate
      return shift(end_m + hair_m);
    }
    if (!ahead.decided() || !ahead.step()) return 0.0;
  }
}

std::optional<FixKind> OnPathEstimator::on_turn_ended(double turned_rad) {
  const zone::Circuit& circuit = path_.circuit();
  const auto to = turned_to(turned_rad);
  if (!to || path_.track_position().s_m < circuit.section(path_.motion().current_section()).length_m())
    return std::nullopt;
  // PILS may take another branch than the commanded one.
  const auto remaining = path_.course().remaining();
  const FixKind kind = !remaining.empty() && remaining.front() != *to ? FixKind::relocated : FixKind::none;
  path_.enter_branch(*to);
  variance_m2_ = model_.sigma_fix_m * model_.sigma_fix_m;
  doubt_.reset();
  return kind;
}

std::optional<zone::SectionId> OnPathEstimator::turned_to(double turned_rad) const {
  const zone::Circuit& circuit = path_.circuit();
  const zone::SectionId here = path_.motion().current_section();
  const auto misfit_rad = [&](zone::SectionId to) {
    const double bend = bend_rad(circuit, here, to);
    return bend == 0.0 ? pi : std::fabs(wrap_angle(bend - turned_rad));
  };
  const auto remaining = path_.course().remaining();
  if (!remaining.empty() && misfit_rad(remaining.front()) <= model_.landed_rad) return remaining.front();
  const auto branches = circuit.next(here);
  const auto best = std::ranges::min_element(branches, {}, misfit_rad);
  return best != branches.end() && misfit_rad(*best) <= model_.landed_rad ? std::optional{*best} : std::nullopt;
}

// --- tags and beacons -----------------------------------------------------------------------------------------------

PositionFix OnPathEstimator::jump_to(zone::TrackPosition track_position) {
  position_at(track_position);
  return {FixKind::relocated, 0.0};
}

PositionFix OnPathEstimator::on_tag(zone::TrackPosition tag_position, double latency_m, double travelled_m) {
  const zone::Circuit& circuit = path_.circuit();
  // The tag was read at the rim of the field that the vehicle drives into: ahead of the antenna, not under it.
  const zone::TrackPosition here = circuit.advance(tag_position, latency_m - model_.antenna_range_m);
  if (!known_) return jump_to(here);
  const std::optional<double> offset_m = path_.offset_to(here, model_.tag_gate_m);
  const Point2 tag = position(circuit.pose_at(tag_position));
  if (!offset_m) {
    // On a crossing the antenna also reads the tag of the other lane: this tag shows where the vehicle is, but not on
    // which section.
    const bool crossed = distance(tag, position(path_.pose())) <= under_vehicle_m;
    return crossed ? on_beacon(tag, latency_m, travelled_m) : jump_to(here);
  }
  // Likewise on the return along a lane driven in both directions: the tag's own section lies behind the vehicle, the
  // tag before it.
  const auto foot = path_.foot_of(tag, model_.beacon_gate_m, under_vehicle_m);
  if (foot && std::fabs(foot->offset_m + latency_m) + opposite_m < std::fabs(*offset_m))
    return on_beacon(tag, latency_m, travelled_m);
  const double moved_m = shift(*offset_m);
  variance_m2_ = model_.sigma_fix_m * model_.sigma_fix_m;
  doubt_.reset();
  return {FixKind::corrected, moved_m};
}

PositionFix OnPathEstimator::on_beacon(Point2 beacon, double latency_m, double travelled_m) {
  COSIVA_EXPECT(known_);
  const auto foot = path_.foot_of(beacon, model_.beacon_gate_m, under_vehicle_m);
  if (!foot) return on_strange_beacon(beacon, latency_m, travelled_m);
  const double beside2_m2 = foot->beside_m * foot->beside_m;
  const double range_m = model_.antenna_range_m;
  const double rim_m = foot->beside_m < range_m ? std::sqrt(range_m * range_m - beside2_m2) : 0.0;
  const double moved_m = shift(foot->offset_m + latency_m - rim_m);
  variance_m2_ = model_.sigma_fix_m * model_.sigma_fix_m + beside2_m2 * 0.05;
  doubt_.reset();
  return {FixKind::corrected, moved_m};
}

PositionFix OnPathEstimator::on_strange_beacon(Point2 beacon, double latency_m, double travelled_m) {
  const std::optional<Sighting> before = doubt_;
  doubt_ = Sighting{beacon, travelled_m};
  if (!before || before->beacon == beacon) return {FixKind::outlier, 0.0};
  const double distance_m = std::fabs(travelled_m - before->travelled_m);
  // A curved path is longer than the straight line between its ends, never shorter.
  const double apart_m = distance(before->beacon, beacon);
  if (apart_m > distance_m + agreement_m || distance_m > 1.6 * apart_m + agreement_m) return {FixKind::outlier, 0.0};
  const double heading_rad = det_atan2(beacon.y_m - before->beacon.y_m, beacon.x_m - before->beacon.x_m);
  const zone::Circuit& circuit = path_.circuit();
  const auto located = circuit.locate(beacon, heading_rad);
  if (located.distance_m > under_vehicle_m) return {FixKind::outlier, 0.0};
  return jump_to(circuit.advance(located.position, latency_m));
}

// --- poses and coinciding positions ---------------------------------------------------------------------------------

std::optional<zone::TrackPosition> position_on_circuit(const zone::Circuit& circuit, const Pose2& X_MB,
                                                       double distance_m_max) {
  const auto located = circuit.locate(position(X_MB), X_MB.heading_rad);
  if (located.distance_m > distance_m_max) return std::nullopt;
  const double turned_rad = wrap_angle(circuit.pose_at(located.position).heading_rad - X_MB.heading_rad);
  if (std::fabs(turned_rad) > pi / 3.0) return std::nullopt;
  return located.position;
}

std::vector<zone::TrackPosition> same_positions(const zone::Circuit& circuit, zone::TrackPosition here) {
  std::vector<zone::TrackPosition> positions;
  const Pose2 X_MB = circuit.pose_at(here);
  std::vector<zone::Circuit::Located> near;
  circuit.near(position(X_MB), same_position_m, near);
  for (const auto& [track_position, left_m, distance_m] : near) {
    const double across_rad = wrap_angle(circuit.pose_at(track_position).heading_rad - X_MB.heading_rad);
    if (track_position.section != here.section && std::fabs(across_rad) <= same_position_rad)
      positions.push_back(track_position);
  }
  return positions;
}

void OnPathEstimator::archive(Archive& archive) { archive(known_, path_, variance_m2_, doubt_); }

}  // namespace cosiva::aiv
