// OrderManager: the nearest position on the path is not free, so an off-path vehicle drives to another one.
#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/virtual/server/orders/order_manager.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

/// Spacing of the tried positions along the path, and their maximum distance from the nearest one.
constexpr double sample_every_m = 0.05;
constexpr double position_within_m = 0.45;
/// Distance ahead of the entry position within which the path has to be free.
constexpr double free_ahead_m = 0.5;

}  // namespace

bool OrderManager::joining(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  if (plan.join_handle == 0) return false;
  const InstantActionSender::PendingAction* pending_action = action_sender_.find(plan.join_handle);
  const wire::ActionStatus status =
      pending_action == nullptr ? wire::ActionStatus::failed : pending_action->actions.front().status;
  const bool over = status == wire::ActionStatus::finished || status == wire::ActionStatus::failed;
  if (!over && publisher_.now() - plan.join_sent_at < rules_.join_timeout) return true;
  if (status == wire::ActionStatus::failed && pending_action != nullptr)
    publisher_.log('w', registry_[vehicle].name + ": did not join the path: " + pending_action->actions.front().result);
  end_join(vehicle);
  return false;
}

void OrderManager::end_join(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  plan.entry_point.reset();
  if (plan.join_handle != 0) action_sender_.drop(std::exchange(plan.join_handle, 0));
}

void OrderManager::try_other_positions(VehicleIndex vehicle) {
  const Plan& plan = plans_[vehicle];
  if (!plan.waits_since) return;
  const SimDuration waited = publisher_.now() - *plan.waits_since;
  if (waited >= rules_.other_position_after)
    join_elsewhere(vehicle, waited < rules_.make_room_after, position_within_m);
}

bool OrderManager::join_elsewhere(VehicleIndex vehicle, bool drives_on, double within_m) {
  Plan& plan = plans_[vehicle];
  if (!goes_onto_line(vehicle)) return false;
  for (const zone::TrackPosition position : positions_near(vehicle, within_m)) {
    const Pose2 X_MG = map_->circuit().pose_at(position);
    if (!drives_on && blocks_entry(plan.waits_for_vehicle, X_MG)) continue;
    if (!is_free_entry(vehicle, position, drives_on)) continue;
    plan.entry_point = position;
    plan.reported.position = position;
    plan.join_sent_at = publisher_.now();
    plan.join_handle = action_sender_.send(registry_[vehicle], vehicle,
                                           {{"joinLine",
                                             {},
                                             {},
                                             wire::BlockingType::hard,
                                             {{"x", X_MG.x_m}, {"y", X_MG.y_m}, {"theta", X_MG.heading_rad}}}},
                                           std::chrono::seconds{3}, true);
    return true;
  }
  return false;
}

std::vector<zone::TrackPosition> OrderManager::positions_near(VehicleIndex vehicle, double within_m) const {
  const zone::Circuit& circuit = map_->circuit();
  const auto entry_point = zone::snap_to_path(circuit, plans_[vehicle].reported.X_MB);
  if (!entry_point) return {};
  std::vector<zone::TrackPosition> positions{entry_point->position};
  for (int i = 1; i * sample_every_m <= within_m; ++i) {
    const double off_m = i * sample_every_m;
    positions.push_back(circuit.advance(entry_point->position, off_m));
    positions.push_back(circuit.advance(entry_point->position, -off_m));
  }
  return positions;
}

bool OrderManager::blocks_entry(VehicleIndex other, const Pose2& X_MB) const {
  if (other == no_vehicle || !goes_onto_line(other)) return false;
  const Pose2& X_MO = plans_[other].reported.X_MB;
  const auto entry_point = zone::snap_to_path(map_->circuit(), X_MO);
  if (!entry_point) return false;
  aiv::EntrySweep sweep{map_->zone().vehicle};
  sweep.take({X_MO, map_->circuit().pose_at(entry_point->position)});
  return sweep.near_body(X_MB);
}

bool OrderManager::is_free_entry(VehicleIndex vehicle, zone::TrackPosition position, bool drives_on) {
  if (obstructs_line_entry(vehicle, position) != no_vehicle) return false;
  traffic_.set_position(vehicle, position);
  traffic_.update();
  bool free = !traffic_.is_in_others_crossing(vehicle);
  if (free && drives_on) {
    const zone::TrackPosition before = std::exchange(*plans_[vehicle].reported.position, position);
    free = traffic_.ahead_within(vehicle, free_ahead_m).vehicle == no_vehicle &&
           off_path_obstruction(vehicle, 0.0, free_ahead_m) == no_vehicle;
    plans_[vehicle].reported.position = before;
  }
  if (!free) {
    traffic_.set_position(vehicle, std::nullopt);
    traffic_.update();
  }
  return free;
}

}  // namespace cosiva::virtual_side
