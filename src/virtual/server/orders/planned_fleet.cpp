#include "cosiva/virtual/server/orders/planned_fleet.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/zone/check/deadlock.h"

namespace cosiva::virtual_side {
namespace {

using planning::StateId;

constexpr double at_state_m = 0.05;  // a stopped vehicle nearer than this to a state's position is there
constexpr double moved_m = 0.02;
constexpr double moved_rad = 0.05;
constexpr SimDuration aside_after = std::chrono::seconds{8};
constexpr SimDuration obstructions_period = std::chrono::seconds{1};
constexpr std::uint64_t seed = 1;

bool has_two_way_tracks(const zone::TrafficZone& zone) {
  return std::ranges::any_of(zone::opposites(zone), [](zone::SectionId other) { return other != zone::no_section; });
}

}  // namespace

void PlannedFleet::set_map(const WaypointGraph* map) {
  fleet_.reset();
  for (Vehicle& vehicle : vehicles_) vehicle = {};
  if (map == nullptr || !has_two_way_tracks(map->zone())) return;
  fleet_ = std::make_unique<planning::TrackFleet>(map->zone(), planning::FleetPlanOptions{}, seed);
  fleet_->resize(vehicles_.size());
}

void PlannedFleet::resize(std::size_t vehicles) {
  vehicles_.resize(vehicles);
  if (in_force()) fleet_->resize(vehicles);
}

void PlannedFleet::forget(VehicleIndex vehicle) {
  vehicles_[vehicle] = {};
  if (in_force()) fleet_->leave(vehicle);
}

void PlannedFleet::update() {
  COSIVA_EXPECT(in_force());
  bool changed = false;
  for (VehicleIndex vehicle = 0; vehicle < vehicles_.size(); ++vehicle) {
    const bool took_part = fleet_->takes_part(vehicle);
    if (took_part) record_arrivals(vehicle);
    if (took_part && is_elsewhere(vehicle)) fleet_->leave(vehicle);
    if (!fleet_->takes_part(vehicle)) join_where_stopped(vehicle);
    if (fleet_->takes_part(vehicle)) set_aside_or_take_back(vehicle);
    changed = changed || took_part != fleet_->takes_part(vehicle);
  }
  if (changed || context_.publisher.now() - obstructions_at_ >= obstructions_period) find_obstructions();
}

// --- joining --------------------------------------------------------------------------------------------------------

StateId PlannedFleet::straight_on(StateId state) const {
  // A pose at a node does not show whether the vehicle has reached the node or begins the next section there: straight
  // on it can drive in both cases.
  const planning::TrackFloor& track = fleet_->track();
  const zone::TrackPosition at = track.position(state);
  for (const zone::SectionId next : context_.map->circuit().next(at.section)) {
    if (at.s_m == 0.0 || context_.map->circuit().turn_at(at.section, next) != 0.0) continue;
    if (const auto beginning = track.state_at({next, 0.0}); beginning) return *beginning;
  }
  return state;
}

std::vector<StateId> PlannedFleet::states_around(zone::TrackPosition position) const {
  const planning::TrackFloor& track = fleet_->track();
  if (const auto state = track.state_at(position, at_state_m)) return {straight_on(*state)};
  if (const auto before = track.state_before(position)) {
    // Beyond the last state of a section, all moves lead to its end.
    const auto next = track.floor().successors(*before);
    return next.empty() ? std::vector<StateId>{} : std::vector{*before, next.front()};
  }
  const auto after = track.state_after(position, {});
  if (!after) return {};
  for (const StateId before : track.floor().predecessors(*after))
    if (std::ranges::find(track.sections(before, *after), position.section) != track.sections(before, *after).end())
      return {before, *after};
  return {*after};
}

void PlannedFleet::join_where_stopped(VehicleIndex vehicle) {
  const auto& position = positions_.reported(vehicle).position;
  if (!context_.registry[vehicle].here() || sessions_[vehicle].stage() != OrderSession::Stage::none || !position ||
      !positions_.is_stopped(vehicle) || !follower_.may_extend(vehicle))
    return;
  const auto states = states_around(*position);
  if (states.empty() || !fleet_->join(vehicle, states)) return;
  vehicles_[vehicle].could_drive = true;
  begin_move(vehicle);
}

// --- driving --------------------------------------------------------------------------------------------------------

bool PlannedFleet::waits_at_state(VehicleIndex vehicle) const {
  return fleet_->granted_moves(vehicle) == 0 && positions_.is_stopped(vehicle);
}

bool PlannedFleet::has_reached(VehicleIndex vehicle, StateId state) const {
  const auto& reported = positions_.reported(vehicle).position;
  if (!reported) return false;
  const planning::TrackFloor& track = fleet_->track();
  const zone::TrackPosition end = track.position(state);
  // A vehicle that stops short of a node by little, or has ended its order there, does not drive on to it.
  const bool ends = positions_.is_stopped(vehicle) || sessions_[vehicle].stage() == OrderSession::Stage::none;
  const double short_m = ends ? at_state_m : 0.0;
  if (reported->section == end.section) return reported->s_m >= end.s_m - short_m;
  const auto& states = fleet_->states(vehicle);
  const auto leads_over = [&](std::size_t move) {
    const auto sections = track.sections(states[move], states[move + 1]);
    return std::ranges::find(sections, reported->section) != sections.end();
  };
  // Still at the first state, or in its first move; on the first state's section, but before it, only on the return.
  const zone::TrackPosition begin = track.position(states[0]);
  if ((reported->section == begin.section && reported->s_m >= begin.s_m - at_state_m) || leads_over(0)) return false;
  // Beyond it: on a section of the moves after it, or at the beginning of any section that follows.
  for (std::size_t move = 1; move < fleet_->granted_moves(vehicle); ++move)
    if (leads_over(move)) return true;
  const auto next = context_.map->circuit().next(end.section);
  return reported->s_m < at_state_m && std::ranges::find(next, reported->section) != next.end();
}

void PlannedFleet::record_arrivals(VehicleIndex vehicle) {
  while (fleet_->granted_moves(vehicle) > 0 && has_reached(vehicle, fleet_->states(vehicle)[1])) {
    fleet_->arrive(vehicle);
    begin_move(vehicle);
  }
  const auto& reported = positions_.reported(vehicle).position;
  if (fleet_->granted_moves(vehicle) == 0 || !reported) return;
  const StateId from = fleet_->states(vehicle)[0];
  const StateId to = fleet_->states(vehicle)[1];
  if (fleet_->track().driven_m(from, to, *reported) >= fleet_->track().clear_m(from, to)) fleet_->clear(vehicle);
}

void PlannedFleet::begin_move(VehicleIndex vehicle) {
  vehicles_[vehicle].moved_at = context_.publisher.now();
  vehicles_[vehicle].drove_at = context_.publisher.now();
}

bool PlannedFleet::is_elsewhere(VehicleIndex vehicle) const {
  if (!context_.registry[vehicle].here()) return true;
  const auto& position = positions_.reported(vehicle).position;
  if (!position || sessions_[vehicle].stage() != OrderSession::Stage::none || !positions_.is_stopped(vehicle))
    return false;
  const planning::TrackFloor& track = fleet_->track();
  const auto& states = fleet_->states(vehicle);
  const auto is_at = [&](StateId state) {
    const Pose2 X_MS = context_.map->circuit().pose_at(track.position(state));
    return distance(X_MS, positions_.reported(vehicle).X_MB) <= context_.rules.on_circuit_m;
  };
  if (is_at(states[0])) return false;
  for (std::size_t move = 0; move < fleet_->granted_moves(vehicle); ++move) {
    const auto sections = track.sections(states[move], states[move + 1]);
    const bool on_its_move = position->section == track.position(states[move]).section ||
                             std::ranges::find(sections, position->section) != sections.end();
    if (on_its_move || is_at(states[move + 1])) return false;
  }
  return true;
}

void PlannedFleet::set_aside_or_take_back(VehicleIndex vehicle) {
  Vehicle& known = vehicles_[vehicle];
  const bool can_drive = follower_.may_extend(vehicle);
  // What a vehicle reports of its driving is not enough: its wheels may turn in vain, or its last report may be old.
  const Pose2& X_MB = pose(vehicle);
  const bool moved = distance(known.X_MB, X_MB) > moved_m ||
                     std::fabs(wrap_angle(known.X_MB.heading_rad - X_MB.heading_rad)) > moved_rad;
  const bool drives = moved || (can_drive && !known.could_drive);
  if (moved) known.X_MB = X_MB;
  if (drives || (can_drive && fleet_->granted_moves(vehicle) == 0)) known.drove_at = context_.publisher.now();
  known.could_drive = can_drive;
  const bool late = context_.publisher.now() - known.drove_at > aside_after;
  if (late && !fleet_->is_set_aside(vehicle)) {
    fleet_->set_aside(vehicle, true);
    context_.publisher.log('i',
                           context_.registry[vehicle].name() + ": does not drive on; the others' plan leads around it");
  } else if (!late && fleet_->is_set_aside(vehicle)) {
    fleet_->set_aside(vehicle, false);
  }
}

// --- obstructions ---------------------------------------------------------------------------------------------------

void PlannedFleet::obstruct_by(VehicleIndex vehicle, planning::SweptArea& area) const {
  area.add_pose(positions_.body(vehicle));
  const auto& position = context_.traffic.track_position(vehicle);
  if (!sessions_[vehicle].is_running() || !position) return;
  // The vehicle may drive to the end of its base.
  double left_m = context_.traffic.base_left_m(vehicle, *position).value_or(0.0);
  zone::TrackPosition at = *position;
  for (const zone::SectionId next : context_.traffic.remaining(vehicle)) {
    const double end_m = context_.map->circuit().section(at.section).length_m();
    if (at.s_m + left_m <= end_m) break;
    area.add_drive(context_.map->circuit(), at.section, at.s_m, end_m);
    left_m -= end_m - at.s_m;
    at = {next, 0.0};
  }
  const double end_m = std::min(at.s_m + left_m, context_.map->circuit().section(at.section).length_m());
  area.add_drive(context_.map->circuit(), at.section, at.s_m, end_m);
}

void PlannedFleet::find_obstructions() {
  obstructions_at_ = context_.publisher.now();
  planning::SweptArea area = fleet_->track().empty_area();
  for (VehicleIndex vehicle = 0; vehicle < vehicles_.size(); ++vehicle)
    if (context_.registry[vehicle].here() && !fleet_->takes_part(vehicle)) obstruct_by(vehicle, area);
  planning::Obstruction obstruction = fleet_->track().obstructed(area);
  const auto closed = fleet_->track().moves_into(context_.missions.closed().all());
  obstruction.moves.insert(obstruction.moves.end(), closed.begin(), closed.end());
  std::sort(obstruction.moves.begin(), obstruction.moves.end());
  fleet_->obstruct(std::move(obstruction));
}

void PlannedFleet::archive(Archive& archive) {
  archive(vehicles_, obstructions_at_);
  if (in_force()) archive(*fleet_);
}

}  // namespace cosiva::virtual_side
