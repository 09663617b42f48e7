// OrderManager: which vehicle waits for which, and why.
#include <algorithm>
#include <cmath>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/virtual/server/orders/order_manager.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

constexpr double stopped_mps = 0.01;
/// A body that stops a vehicle by its obstacle sensor is no further ahead than this, nor further from the body's path.
/// Ahead: the stopping distance, the additional room required to continue, and the error of reports. To the side: the
/// tolerance within which the sensor counts an echo as in the path, which is its margin of 0.02 m plus the position
/// error of an echo from a beam's edge (0.12 rad at a range of 0.3 m), noise included.
constexpr double detected_ahead_m = aiv::clearance_m + 0.08;
constexpr double detected_off_path_m = 0.07;
constexpr double check_every_m = 0.03;
/// Clearance on all sides that a vehicle requires before it turns on the spot.
constexpr double detected_around_m = 0.06;

}  // namespace

void OrderManager::wait_for(Plan& plan, VehicleIndex other, WaitReason why) {
  plan.waits_for_vehicle = other;
  plan.waits_why = why;
}

void OrderManager::record_waiting(Plan& plan, SimTime now) {
  // The vehicle is blocked now, not merely informed early that it will be.
  const bool waits = (plan.waits_for_crossing || plan.waits_for_vehicle != no_vehicle) && extension_.empty();
  if (!waits) {
    plan.waits_since.reset();
    return;
  }
  if (!plan.waits_since) plan.waits_since = now;
  longest_wait_ = std::max(longest_wait_, now - *plan.waits_since);
}

std::string OrderManager::waits_for(VehicleIndex vehicle) const {
  if (vehicle >= plans_.size() || map_ == nullptr) return {};
  const Plan& plan = plans_[vehicle];
  std::string text;
  if (plan.waits_for_crossing && *plan.waits_for_crossing < map_->crossing_count())
    text = map_->zone().crossings[*plan.waits_for_crossing].name;
  if (plan.waits_for_vehicle != no_vehicle) {
    if (!text.empty()) text += ", ";
    text += registry_[plan.waits_for_vehicle].name;
  }
  return text;
}

Pose2 OrderManager::body(VehicleIndex vehicle) const {
  return simulator_.image(*registry_[vehicle].twin, publisher_.now()).X_MB;
}

bool OrderManager::is_stopped(VehicleIndex vehicle) const {
  const AivProxy& proxy = registry_[vehicle];
  return proxy.here() && proxy.state && !proxy.state->driving &&
         std::fabs(simulator_.twin(*proxy.twin).speed_mps()) < stopped_mps;
}

bool OrderManager::is_stopped_without_reason(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  const AivProxy& proxy = registry_[vehicle];
  constexpr double distance_m_min = 0.10;
  const wire::State& state = *proxy.state;
  // Third-party vehicles may have other reasons.
  const bool unresponsive = proxy.is_cosiva() && is_stopped(vehicle) && !state.field_violation && !state.paused &&
                            !proxy.paused_for_body && state.errors.empty() && state.e_stop == wire::EStop::none &&
                            plan.reported.position &&
                            traffic_.base_left_m(vehicle, *plan.reported.position).value_or(0.0) > distance_m_min;
  if (!unresponsive) {
    plan.unresponsive_since.reset();
    return false;
  }
  if (!plan.unresponsive_since) plan.unresponsive_since = publisher_.now();
  if (publisher_.now() - *plan.unresponsive_since < rules_.unresponsive_for) return false;
  plan.unresponsive_since.reset();
  return true;
}

void OrderManager::add_waits(WaitGraph& graph) const {
  if (map_ == nullptr) return;
  for (VehicleIndex v = 0; v < plans_.size(); ++v) {
    if (!is_stopped(v)) continue;
    const Plan& plan = plans_[v];
    const bool has_route = plan.stage == Plan::Stage::running || plan.join_handle != 0;
    if (has_route && (registry_[v].state->field_violation || registry_[v].paused_for_body)) {
      // A wait at the end of its base matters only when the vehicle has arrived there.
      graph.add({v, detected_in_path(v), WaitReason::sensors, no_crossing});
      continue;
    }
    if (!plan.waits_since || plan.waits_for_vehicle == no_vehicle) continue;
    graph.add({v, plan.waits_for_vehicle, plan.waits_why, plan.waits_for_crossing.value_or(no_crossing)});
  }
}

VehicleIndex OrderManager::detected_in_path(VehicleIndex vehicle) const {
  const Plan& plan = plans_[vehicle];
  const zone::VehicleShape& shape = map_->zone().vehicle;
  const zone::Circuit& circuit = map_->circuit();
  const Pose2 X_MB = body(vehicle);
  VehicleIndex found = no_vehicle;
  double nearest_m = std::numeric_limits<double>::infinity();
  const auto consider = [&](VehicleIndex other, double far_m) {
    if (far_m >= nearest_m) return;
    found = other;
    nearest_m = far_m;
  };
  aiv::EntrySweep sweep{shape};
  if (plan.entry_point) sweep.take({X_MB, circuit.pose_at(*plan.entry_point)});
  for (VehicleIndex other = 0; other < registry_.size(); ++other) {
    if (other == vehicle || !registry_[other].here()) continue;
    const Pose2 X_MO = body(other);
    if (plan.entry_point) {
      if (sweep.near_body(X_MO, detected_off_path_m)) consider(other, distance(X_MB, X_MO));
      continue;
    }
    if (!plan.reported.position) continue;
    for (double ahead_m = 0.0; ahead_m < detected_ahead_m + check_every_m; ahead_m += check_every_m) {
      const Pose2 X_MV =
          circuit.pose_at(circuit.advance(*plan.reported.position, ahead_m, traffic_.remaining(vehicle)));
      if (!aiv::near_bodies(shape, X_MV, X_MO, detected_off_path_m)) continue;
      // A body already next to its side is not what the sensor detects.
      if (ahead_m > 0.0 || aiv::lies_ahead(shape, X_MB, X_MO)) consider(other, ahead_m);
      break;
    }
    // Half a metre: any body on the path is nearer than a body that only prevents turning.
    if (aiv::near_bodies(shape, X_MB, X_MO, detected_around_m)) consider(other, 0.5 + distance(X_MB, X_MO));
  }
  return found;
}

std::string OrderManager::sentence(const Wait& wait) const {
  const std::string& waiter = registry_[wait.waiter].name;
  const std::string& blocker = registry_[wait.blocker].name;
  const std::string crossing = wait.crossing < map_->crossing_count() ? map_->zone().crossings[wait.crossing].name : "";
  switch (wait.why) {
    case WaitReason::ahead:
      return crossing.empty() ? waiter + " waits for " + blocker + " ahead of it"
                              : waiter + " waits for room beyond " + crossing + ", where " + blocker + " is";
    case WaitReason::crossing: return waiter + " waits for " + crossing + ", which " + blocker + " holds";
    case WaitReason::turn: return waiter + " waits for its turn at " + crossing + " after " + blocker;
    case WaitReason::off_path: return waiter + " waits for " + blocker + ", which is too close to its path";
    case WaitReason::sensors: return waiter + " detects " + blocker + " in its path";
  }
  return {};
}

}  // namespace cosiva::virtual_side
