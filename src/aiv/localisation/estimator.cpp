#include "cosiva/aiv/localisation/estimator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

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
/// Minimum number of traversed sections that are stored.
constexpr std::size_t traversed_kept = 16;

}  // namespace

PositionEstimator::PositionEstimator(const zone::TrafficZone& zone, EstimatorModel model)
    : zone_{zone}, model_{model} {}

double PositionEstimator::sigma_m() const { return std::sqrt(variance_m2_); }

Outlook PositionEstimator::outlook() const {
  Outlook outlook{track_position(), course_.remaining()};
  if (X_MO_) outlook.X_MB = pose();
  return outlook;
}

void PositionEstimator::position_at(zone::TrackPosition track_position) {
  motion_ = AivMotion{zone_.circuit, track_position};
  known_ = true;
  near_path_ = false;
  X_MO_.reset();
  // A manoeuvre of PILS in progress began where the vehicle is.
  if (X_OB_) X_MO_ = pose();
  if (!course_.arrive(track_position.section)) course_.clear();
  variance_m2_ = model_.sigma_start_m * model_.sigma_start_m;
  doubt_.reset();
}

std::optional<zone::TrackPosition> PositionEstimator::on_circuit(const Pose2& X_MB, double distance_m_max) const {
  const auto located = zone_.circuit.locate(position(X_MB), X_MB.heading_rad);
  if (located.distance_m > distance_m_max) return std::nullopt;
  const double turned_rad = wrap_angle(zone_.circuit.pose_at(located.position).heading_rad - X_MB.heading_rad);
  if (std::fabs(turned_rad) > pi / 3.0) return std::nullopt;
  return located.position;
}

std::vector<zone::TrackPosition> PositionEstimator::same_positions() const {
  std::vector<zone::TrackPosition> positions;
  if (!known_ || off_path()) return positions;
  const Pose2 X_MB = pose();
  std::vector<zone::Circuit::Located> near;
  zone_.circuit.near(position(X_MB), same_position_m, near);
  for (const auto& [track_position, left_m, distance_m] : near) {
    const double across_rad = wrap_angle(zone_.circuit.pose_at(track_position).heading_rad - X_MB.heading_rad);
    if (track_position.section != motion_.current_section() && std::fabs(across_rad) <= same_position_rad)
      positions.push_back(track_position);
  }
  return positions;
}

void PositionEstimator::take_same_position(zone::TrackPosition track_position) {
  const double variance_m2 = variance_m2_;
  position_at(track_position);
  variance_m2_ = variance_m2;
}

void PositionEstimator::follow(const zone::Course& course) {
  if (course.here() != track_position().section) return course_.clear();
  // The sections actually traversed are more reliable than those assumed by an order.
  const bool driven = course_.here() == course.here() && !course_.traversed().empty();
  const auto traversed = driven ? course_.traversed() : course.traversed();
  const auto kept = traversed.last(std::min(traversed.size(), traversed_kept));
  const auto on = course.sections().subspan(course.traversed().size());
  std::vector<zone::SectionId> sections;
  sections.reserve(kept.size() + on.size());
  sections.insert(sections.end(), kept.begin(), kept.end());
  sections.insert(sections.end(), on.begin(), on.end());
  const std::size_t at = kept.size();
  course_ = zone::Course{std::move(sections), at};
}

double PositionEstimator::count(std::int64_t distance_um) {
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
  return step_m;
}

double PositionEstimator::on_odometry(std::int64_t distance_um) {
  const double step_m = count(distance_um);
  return known_ ? shift(step_m) : 0.0;
}

PositionEstimator::Rolled PositionEstimator::on_odometry(const wire::Odometry& odometry) {
  if (!odometry.manoeuvre && !off_path()) return {on_odometry(odometry.distance_um), FixKind::none};
  return off_path(count(odometry.distance_um), odometry);
}

void PositionEstimator::on_odometer_reset() {
  odometer_um_.reset();
  variance_m2_ += model_.sigma_reset_m * model_.sigma_reset_m;
}

// --- along the course -----------------------------------------------------------------------------------------------

double PositionEstimator::shift(double distance_m) {
  return distance_m < 0.0 ? shift_back(distance_m) : shift_on(distance_m);
}

double PositionEstimator::shift_on(double distance_m) {
  const zone::Circuit& circuit = zone_.circuit;
  double left_m = distance_m;
  for (;;) {
    const zone::SectionId here = motion_.current_section();
    const double length_m = circuit.section(here).length_m();
    if (motion_.mDTCS_m() + left_m <= length_m) {
      motion_.move(circuit, left_m);
      return distance_m;
    }
    left_m -= length_m - motion_.mDTCS_m();
    const zone::SectionLookAhead ahead = section_look_ahead(circuit, outlook());
    if (!ahead.decided() || bend_rad(circuit, here, ahead.next()) != 0.0) {
      motion_ = AivMotion{circuit, {here, length_m}};
      return distance_m - left_m;
    }
    enter(ahead.next());
  }
}

double PositionEstimator::shift_back(double distance_m) {
  const zone::Circuit& circuit = zone_.circuit;
  double left_m = -distance_m;
  for (;;) {
    const zone::SectionId here = motion_.current_section();
    const double length_m = circuit.section(here).length_m();
    const double ahead_m = length_m - motion_.mDTCS_m();
    if (ahead_m + left_m <= length_m) {
      motion_.shift(circuit, -left_m);
      return distance_m;
    }
    left_m -= length_m - ahead_m;
    const zone::SectionId before = section_before();
    if (before == zone::no_section || bend_rad(circuit, before, here) != 0.0) {
      motion_ = AivMotion{circuit, {here, 0.0}};
      return distance_m + left_m;
    }
    if (!course_.traversed().empty()) {
      course_.step_back();
    } else if (!course_.empty()) {
      std::vector<zone::SectionId> sections{before};
      sections.insert(sections.end(), course_.sections().begin(), course_.sections().end());
      course_ = zone::Course{std::move(sections)};
    }
    motion_ = AivMotion{circuit, {before, circuit.section(before).length_m()}};
  }
}

zone::SectionId PositionEstimator::section_before() const {
  if (!course_.traversed().empty()) return course_.traversed().back();
  const auto before = zone_.circuit.previous(motion_.current_section());
  return before.empty() ? zone::no_section : before.front();
}

void PositionEstimator::enter(zone::SectionId next) {
  if (!course_.empty()) {
    if (course_.remaining().empty()) course_.extend({&next, 1});
    course_.step();
    if (course_.traversed().size() >= 4 * traversed_kept) course_.forget_traversed(traversed_kept);
  }
  motion_ = AivMotion{zone_.circuit, {next, 0.0}};
}

double PositionEstimator::joint_gate_m() const { return std::max(model_.bend_gate_m, 3.0 * sigma_m()); }

double PositionEstimator::on_stuck() {
  if (!known_ || off_path()) return 0.0;
  const zone::Circuit& circuit = zone_.circuit;
  double end_m = -track_position().s_m;
  for (zone::SectionLookAhead ahead = section_look_ahead(circuit, outlook());; ahead.step()) {
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

// --- tags and beacons -----------------------------------------------------------------------------------------------

PositionEstimator::Fix PositionEstimator::on_tag(std::uint32_t number, double age_s, double speed_mps) {
  const double latency_m = speed_mps * (age_s + model_.reading_latency_s);
  if (const zone::Tag* tag = zone_.find_tag(number)) {
    last_tag_ = number;
    last_tag_travelled_m_ = travelled_m_ - latency_m;
    // Off the path a tag shows only that it is near; the manoeuvre's end will give a better fix.
    if (off_path()) return {};
    return on_landmark(tag->position, latency_m);
  }
  if (!zone_.beacons || off_path()) return {};
  const std::optional<Point2> beacon = zone_.beacons->find(number);
  return beacon && known_ ? on_beacon(*beacon, latency_m) : Fix{};
}

std::optional<double> PositionEstimator::offset_to(zone::TrackPosition track_position, double limit_m) const {
  const zone::TrackPosition here = motion_.track_position(zone_.circuit);
  const auto ahead_m = zone_.circuit.distance_ahead(here, track_position, limit_m, course_.remaining());
  const auto back_m = distance_back_m(track_position, limit_m);
  if (ahead_m && (!back_m || *ahead_m <= *back_m)) return *ahead_m;
  if (back_m) return -*back_m;
  return std::nullopt;
}

std::optional<double> PositionEstimator::distance_back_m(zone::TrackPosition track_position, double limit_m) const {
  const zone::Circuit& circuit = zone_.circuit;
  const zone::TrackPosition here = motion_.track_position(circuit);
  const auto traversed = course_.traversed();
  double back_m = here.s_m;  // to the end of gone[i − 1]
  for (std::size_t i = traversed.size(); i-- > 0 && back_m <= limit_m;
       back_m += circuit.section(traversed[i]).length_m()) {
    if (traversed[i] != track_position.section) continue;
    return circuit.distance_ahead(track_position, here, limit_m,
                                  course_.sections().subspan(i + 1, traversed.size() - i));
  }
  // The traversed sections are known further back than that, and the position is not on them.
  if (!traversed.empty() && back_m > limit_m && track_position.section != here.section) return std::nullopt;
  return circuit.distance_ahead(track_position, here, limit_m);
}

PositionEstimator::Fix PositionEstimator::jump_to(zone::TrackPosition track_position) {
  position_at(track_position);
  return {FixKind::relocated, 0.0};
}

PositionEstimator::Fix PositionEstimator::on_landmark(zone::TrackPosition track_position, double latency_m) {
  // The tag was read at the rim of the field that the vehicle drives into: ahead of the antenna, not under it.
  const zone::TrackPosition here = zone_.circuit.advance(track_position, latency_m - model_.antenna_range_m);
  if (!known_) return jump_to(here);
  const std::optional<double> offset_m = offset_to(here, model_.tag_gate_m);
  const Point2 tag = position(zone_.circuit.pose_at(track_position));
  if (!offset_m) {
    // On a crossing the antenna also reads the tag of the other lane: this tag shows where the vehicle is, but not on
    // which section.
    const bool crossed = distance(tag, position(pose())) <= under_vehicle_m;
    return crossed ? on_beacon(tag, latency_m) : jump_to(here);
  }
  // Likewise on the return along a lane driven in both directions: the tag's own section lies behind the vehicle, the
  // tag before it.
  const auto foot = foot_of(tag);
  if (foot && std::fabs(foot->offset_m + latency_m) + opposite_m < std::fabs(*offset_m))
    return on_beacon(tag, latency_m);
  const double moved_m = shift(*offset_m);
  variance_m2_ = model_.sigma_fix_m * model_.sigma_fix_m;
  doubt_.reset();
  return {FixKind::corrected, moved_m};
}

PositionEstimator::Fix PositionEstimator::on_beacon(Point2 beacon, double latency_m) {
  const auto foot = foot_of(beacon);
  if (!foot) return on_strange_beacon(beacon, latency_m);
  const double beside2_m2 = foot->beside_m * foot->beside_m;
  const double range_m = model_.antenna_range_m;
  const double rim_m = foot->beside_m < range_m ? std::sqrt(range_m * range_m - beside2_m2) : 0.0;
  const double moved_m = shift(foot->offset_m + latency_m - rim_m);
  variance_m2_ = model_.sigma_fix_m * model_.sigma_fix_m + beside2_m2 * 0.05;
  doubt_.reset();
  return {FixKind::corrected, moved_m};
}

std::optional<PositionEstimator::Foot> PositionEstimator::foot_of(Point2 fiducial) const {
  // Sections further along than the gate cannot contain the foot.
  const Near sections = sections_near(model_.beacon_gate_m);
  std::optional<Foot> best;
  double best_m = under_vehicle_m;
  for (const zone::SectionId id : sections.ids()) {
    const auto near = zone_.circuit.section(id).nearest(fiducial);
    if (near.distance_m >= best_m) continue;
    const auto offset_m = offset_to({id, near.s_m}, model_.beacon_gate_m);
    if (!offset_m) continue;
    best_m = near.distance_m;
    best = Foot{*offset_m, best_m};
  }
  return best;
}

void PositionEstimator::Near::sort() {
  const auto end = ids_.begin() + static_cast<std::ptrdiff_t>(count_);
  std::sort(ids_.begin(), end);
  count_ = static_cast<std::size_t>(std::unique(ids_.begin(), end) - ids_.begin());
}

PositionEstimator::Near PositionEstimator::sections_near(double reach_m) const {
  const zone::Circuit& circuit = zone_.circuit;
  const zone::TrackPosition here = track_position();
  Near near;
  double end_m = circuit.section(here.section).length_m() - here.s_m;
  for (zone::SectionLookAhead ahead = section_look_ahead(circuit, outlook());
       near.add(ahead.section()) && end_m <= reach_m && ahead.step();)
    end_m += circuit.section(ahead.section()).length_m();
  double start_m = here.s_m;
  std::size_t traversed = course_.traversed().size();
  zone::SectionId id = here.section;
  while (start_m <= reach_m && near.room()) {
    const auto before = circuit.previous(id);
    if (traversed > 0)
      id = course_.traversed()[--traversed];
    else if (before.size() == 1)
      id = before.front();
    else
      break;
    near.add(id);
    start_m += circuit.section(id).length_m();
  }
  // At a merge whose traversed branch is unknown all branches count.
  if (start_m <= reach_m)
    for (const zone::SectionId before : circuit.previous(id)) near.add(before);
  near.sort();
  return near;
}

PositionEstimator::Fix PositionEstimator::on_strange_beacon(Point2 beacon, double latency_m) {
  const std::optional<Sighting> before = doubt_;
  doubt_ = Sighting{beacon, travelled_m_};
  if (!before || before->beacon == beacon) return {FixKind::outlier, 0.0};
  const double distance_m = std::fabs(travelled_m_ - before->travelled_m);
  // A curved path is longer than the straight line between its ends, never shorter.
  const double apart_m = distance(before->beacon, beacon);
  if (apart_m > distance_m + agreement_m || distance_m > 1.6 * apart_m + agreement_m) return {FixKind::outlier, 0.0};
  const double heading_rad = det_atan2(beacon.y_m - before->beacon.y_m, beacon.x_m - before->beacon.x_m);
  const auto located = zone_.circuit.locate(beacon, heading_rad);
  if (located.distance_m > under_vehicle_m) return {FixKind::outlier, 0.0};
  return jump_to(zone_.circuit.advance(located.position, latency_m));
}

}  // namespace cosiva::aiv
