#include "cosiva/virtual/server/orders/line_join.h"

#include <algorithm>
#include <chrono>
#include <utility>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

/// Spacing of the tried positions along the path, and their maximum distance from the nearest one.
constexpr double sample_every_m = 0.05;
constexpr double position_within_m = 0.45;
/// Distance ahead of the entry position within which the path has to be free.
constexpr double free_ahead_m = 0.5;
/// Sampling distance along a path for the search of off-path bodies.
constexpr double sample_m = 0.05;

}  // namespace

void LineJoin::find_neighbours() {
  neighbours_.clear();
  for (VehicleIndex v = 0; v < vehicles_.size(); ++v)
    if (context_.registry[v].here() &&
        (!positions_.reported(v).position || positions_.is_off_path(v) || is_in_others_crossing(context_.traffic, v)))
      neighbours_.push_back(v);
}

bool LineJoin::continue_joining(VehicleIndex vehicle) {
  const Vehicle& joining = vehicles_[vehicle];
  if (joining.handle == 0) return false;
  const InstantActionSender::PendingAction* pending_action = context_.action_sender.find(joining.handle);
  const wire::ActionStatus status =
      pending_action == nullptr ? wire::ActionStatus::failed : pending_action->actions.front().status;
  const bool over = status == wire::ActionStatus::finished || status == wire::ActionStatus::failed;
  if (!over && context_.publisher.now() - joining.sent_at < context_.rules.join_timeout) return true;
  if (status == wire::ActionStatus::failed && pending_action != nullptr)
    context_.publisher.log(
        'w', context_.registry[vehicle].name() + ": did not join the path: " + pending_action->actions.front().result);
  end(vehicle);
  return false;
}

void LineJoin::end(VehicleIndex vehicle) {
  positions_.clear_entry_point(vehicle);
  if (is_pending(vehicle)) context_.action_sender.drop(std::exchange(vehicles_[vehicle].handle, 0));
}

void LineJoin::try_other_positions(VehicleIndex vehicle) {
  const auto& since = waits_[vehicle].since;
  if (!since) return;
  const SimDuration waited = context_.publisher.now() - *since;
  if (waited >= context_.rules.other_position_after)
    join_elsewhere(vehicle, waited < context_.rules.make_room_after, position_within_m);
}

bool LineJoin::join_elsewhere(VehicleIndex vehicle, bool drives_on, double within_m) {
  if (!positions_.goes_onto_line(vehicle)) return false;
  for (const zone::TrackPosition position : positions_near(vehicle, within_m)) {
    const Pose2 X_MG = context_.map->circuit().pose_at(position);
    if (!drives_on && blocks_entry(waits_[vehicle].blocker, X_MG)) continue;
    if (!is_free_entry(vehicle, position, drives_on)) continue;
    COSIVA_EXPECT(!is_pending(vehicle));
    positions_.set_entry_point(vehicle, position);
    vehicles_[vehicle].sent_at = context_.publisher.now();
    vehicles_[vehicle].handle = context_.action_sender.send(
        context_.registry[vehicle], vehicle,
        {{"joinLine",
          {},
          {},
          wire::BlockingType::hard,
          {{"x", X_MG.x_m}, {"y", X_MG.y_m}, {"theta", zone::body_pose(context_.map->zone(), X_MG).heading_rad}}}},
        std::chrono::seconds{3}, true);
    return true;
  }
  return false;
}

std::vector<zone::TrackPosition> LineJoin::positions_near(VehicleIndex vehicle, double within_m) const {
  const zone::Circuit& circuit = context_.map->circuit();
  const auto entry_point = zone::snap_to_path(circuit, positions_.reported(vehicle).X_MB);
  if (!entry_point) return {};
  std::vector<zone::TrackPosition> positions{entry_point->position};
  for (int i = 1; i * sample_every_m <= within_m; ++i) {
    const double off_m = i * sample_every_m;
    positions.push_back(circuit.advance(entry_point->position, off_m));
    positions.push_back(circuit.advance(entry_point->position, -off_m));
  }
  return positions;
}

bool LineJoin::blocks_entry(VehicleIndex other, const Pose2& X_MB) const {
  if (other == no_vehicle || !positions_.goes_onto_line(other)) return false;
  const Pose2& X_MO = positions_.reported(other).X_MB;
  const auto entry_point = zone::snap_to_path(context_.map->circuit(), X_MO);
  if (!entry_point) return false;
  aiv::EntrySweep sweep{context_.map->zone().vehicle};
  sweep.take({X_MO, context_.map->circuit().pose_at(entry_point->position)});
  return sweep.near_body(X_MB);
}

bool LineJoin::is_free_entry(VehicleIndex vehicle, zone::TrackPosition position, bool drives_on) {
  if (obstructs_line_entry(vehicle, position) != no_vehicle) return false;
  context_.traffic.set_position(vehicle, position);
  context_.traffic.update();
  bool free = !is_in_others_crossing(context_.traffic, vehicle);
  if (free && drives_on) {
    const zone::TrackPosition before = *positions_.reported(vehicle).position;
    positions_.set_position(vehicle, position);
    free = context_.traffic.ahead_within(vehicle, free_ahead_m).vehicle == no_vehicle &&
           off_path_obstruction(vehicle, 0.0, free_ahead_m) == no_vehicle;
    positions_.set_position(vehicle, before);
  }
  if (!free) {
    context_.traffic.set_position(vehicle, std::nullopt);
    context_.traffic.update();
  }
  return free;
}

VehicleIndex LineJoin::obstructs_line_entry(VehicleIndex vehicle, zone::TrackPosition entry_point) const {
  const zone::VehicleShape& shape = context_.map->zone().vehicle;
  const aiv::LineEntry mine{positions_.reported(vehicle).X_MB, context_.map->circuit().pose_at(entry_point)};
  aiv::EntrySweep sweep{shape};
  sweep.take(mine);
  for (VehicleIndex other = 0; other < context_.registry.size(); ++other) {
    const AivProxy& proxy = context_.registry[other];
    if (other == vehicle || !proxy.here()) continue;
    const Pose2 X_MB = context_.simulator.image(*proxy.twin(), context_.publisher.now()).X_MB;
    if (sweep.near_body(X_MB)) return other;
    const auto& theirs = positions_.entry_point(other);
    // Another vehicle that is joining the path, or whose base leads over the entry position.
    if (theirs && (sessions_[other].is_running() || is_pending(other)) &&
        aiv::near_entry(mine, shape, {X_MB, context_.map->circuit().pose_at(*theirs)}))
      return other;
    const auto& track_position = context_.traffic.track_position(other);
    if (!track_position) continue;
    const double base_m = context_.traffic.base_left_m(other, *track_position).value_or(0.0);
    const Sections remaining = context_.traffic.remaining(other);
    for (double ahead_m = sample_m; ahead_m < base_m + sample_m; ahead_m += sample_m)
      if (sweep.near_body(context_.map->circuit().pose_at(
              context_.map->circuit().advance(*track_position, std::min(ahead_m, base_m), remaining))))
        return other;
    const double clear_m = shape.length_m + aiv::entry_clear_m;
    if (base_m > 0.0 &&
        context_.map->ahead(*track_position, entry_point, base_m + clear_m, context_.traffic.remaining(other)))
      return other;
  }
  return no_vehicle;
}

VehicleIndex LineJoin::off_path_obstruction(VehicleIndex vehicle, double from_m, double to_m) const {
  constexpr double clear_m = 0.04;  // not less than the clearance at which a vehicle's own obstacle sensor stops it
  const zone::TrackPosition track_position = *positions_.reported(vehicle).position;
  const zone::Circuit& circuit = context_.map->circuit();
  const zone::VehicleShape& shape = context_.map->zone().vehicle;
  const Sections remaining = context_.traffic.remaining(vehicle);
  aiv::EntrySweep sweep{shape};
  for (const VehicleIndex other : neighbours_) {
    if (other == vehicle) continue;
    const Pose2 X_MB = context_.simulator.image(*context_.registry[other].twin(), context_.publisher.now()).X_MB;
    const std::optional<zone::TrackPosition> entry_point = comes_onto_line_at(other);
    if (entry_point) sweep.take({X_MB, circuit.pose_at(*entry_point)});
    const auto in_path = [&](double ahead_m, double air_m) {
      const Pose2 X_MV = circuit.pose_at(circuit.advance(track_position, ahead_m, remaining));
      return entry_point ? sweep.near_body(X_MV, air_m) : aiv::near_bodies(shape, X_MV, X_MB, air_m);
    };
    // The vehicle may pass a body that is already next to it at the present clearance.
    const bool ahead = aiv::lies_ahead(shape, circuit.pose_at(track_position), X_MB);
    const double free_m = !ahead && in_path(0.0, clear_m) ? 0.0 : clear_m;
    // The vehicle stops before a body by itself, and the part of its base that it cannot drive would block the other
    // vehicle.
    const double end_m = to_m + aiv::clearance_m;
    for (double ahead_m = std::max(0.0, from_m); ahead_m < end_m; ahead_m += sample_m)
      if (in_path(ahead_m, free_m)) return other;
    if (in_path(end_m, free_m)) return other;
  }
  return no_vehicle;
}

std::optional<zone::TrackPosition> LineJoin::comes_onto_line_at(VehicleIndex vehicle) const {
  if (positions_.entry_point(vehicle)) return positions_.entry_point(vehicle);
  // A vehicle that waits to join the path is let in, but only for a limited time: it may be unable to join.
  const auto& since = waits_[vehicle].since;
  if (!since || context_.publisher.now() - *since > context_.rules.let_in_for || !positions_.goes_onto_line(vehicle))
    return {};
  const auto entry_point = zone::snap_to_path(context_.map->circuit(), positions_.reported(vehicle).X_MB);
  return entry_point ? std::optional{entry_point->position} : std::nullopt;
}

void LineJoin::archive(Archive& archive) { archive(vehicles_, neighbours_); }

}  // namespace cosiva::virtual_side
