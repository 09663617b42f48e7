#include "cosiva/virtual/server/orders/wait_analysis.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

/// A body that stops a vehicle by its obstacle sensor is no further ahead than this, nor further from the body's path.
/// Ahead: the stopping distance, the additional room required to continue, and the error of reports. To the side: the
/// tolerance within which the sensor counts an echo as in the path, which is its margin of 0.02 m plus the position
/// error of an echo from a beam's edge (0.12 rad at a range of 0.3 m), noise included.
constexpr double detected_ahead_m = aiv::clearance_m + 0.08;
constexpr double detected_off_path_m = 0.07;
constexpr double check_every_m = 0.03;
/// Clearance on all sides that a vehicle requires before it turns on the spot.
constexpr double detected_around_m = 0.06;
/// A base shorter than this is no reason to expect that the vehicle drives.
constexpr double base_left_m_min = 0.10;

}  // namespace

bool WaitAnalysis::is_stopped_without_reason(VehicleIndex vehicle) {
  COSIVA_EXPECT(sessions_[vehicle].is_running());
  const AivProxy& proxy = context_.registry[vehicle];
  const auto& track_position = positions_.reported(vehicle).position;
  auto& since = unresponsive_since_[vehicle];
  const wire::State& state = *proxy.state();
  const bool acts = std::ranges::any_of(state.action_states, [](const wire::ActionState& action) {
    return action.status == wire::ActionStatus::initializing || action.status == wire::ActionStatus::running ||
           action.status == wire::ActionStatus::paused;
  });
  // Third-party vehicles may have other reasons.
  const bool unresponsive = proxy.is_cosiva() && positions_.is_stopped(vehicle) && !state.field_violation && !acts &&
                            !state.paused && !proxy.settings.paused_for_body() && state.errors.empty() &&
                            state.e_stop == wire::EStop::none && track_position &&
                            context_.traffic.base_left_m(vehicle, *track_position).value_or(0.0) > base_left_m_min;
  if (!unresponsive) {
    since.reset();
    return false;
  }
  if (!since) since = context_.publisher.now();
  if (context_.publisher.now() - *since < context_.rules.unresponsive_for) return false;
  since.reset();
  return true;
}

void WaitAnalysis::add_waits(WaitGraph& graph) const {
  if (context_.map == nullptr) return;
  for (VehicleIndex v = 0; v < unresponsive_since_.size(); ++v) {
    if (!positions_.is_stopped(v)) continue;
    const WaitRecord& record = records_[v];
    const bool has_route = sessions_[v].is_running() || joins_.is_pending(v);
    if (has_route &&
        (context_.registry[v].state()->field_violation || context_.registry[v].settings.paused_for_body())) {
      // A wait at the end of its base matters only when the vehicle has arrived there.
      graph.add({v, detected_in_path(v), WaitReason::sensors, no_crossing});
      continue;
    }
    if (!record.since || record.blocker == no_vehicle) continue;
    graph.add({v, record.blocker, record.why, record.crossing.value_or(no_crossing)});
  }
}

VehicleIndex WaitAnalysis::detected_in_path(VehicleIndex vehicle) const {
  const auto& entry_point = positions_.entry_point(vehicle);
  const auto& track_position = positions_.reported(vehicle).position;
  const zone::VehicleShape& shape = context_.map->zone().vehicle;
  const zone::Circuit& circuit = context_.map->circuit();
  const Pose2 X_MB = positions_.body(vehicle);
  VehicleIndex found = no_vehicle;
  double nearest_m = std::numeric_limits<double>::infinity();
  const auto consider = [&](VehicleIndex other, double far_m) {
    if (far_m >= nearest_m) return;
    found = other;
    nearest_m = far_m;
  };
  aiv::EntrySweep sweep{shape};
  if (entry_point) sweep.take({X_MB, circuit.pose_at(*entry_point)});
  for (VehicleIndex other = 0; other < context_.registry.size(); ++other) {
    if (other == vehicle || !context_.registry[other].here()) continue;
    const Pose2 X_MO = positions_.body(other);
    if (entry_point) {
      if (sweep.near_body(X_MO, detected_off_path_m)) consider(other, distance(X_MB, X_MO));
      continue;
    }
    if (!track_position) continue;
    for (double ahead_m = 0.0; ahead_m < detected_ahead_m + check_every_m; ahead_m += check_every_m) {
      const Pose2 X_MV =
          circuit.pose_at(circuit.advance(*track_position, ahead_m, context_.traffic.remaining(vehicle)));
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

std::string WaitAnalysis::waits_for(VehicleIndex vehicle) const {
  if (vehicle >= unresponsive_since_.size() || context_.map == nullptr) return {};
  const WaitRecord& record = records_[vehicle];
  std::string text;
  if (record.crossing && *record.crossing < context_.map->crossing_count())
    text = context_.map->zone().crossings[*record.crossing].name;
  if (record.blocker != no_vehicle) {
    if (!text.empty()) text += ", ";
    text += context_.registry[record.blocker].name();
  }
  return text;
}

std::string WaitAnalysis::blocker_at_goal(VehicleIndex vehicle) const {
  const VehicleIndex blocker = records_[vehicle].blocker;
  const WaypointIndex goal = context_.missions.goal(vehicle);
  if (blocker == no_vehicle || goal == no_waypoint || context_.map == nullptr) return {};
  const ReportedPose& other = positions_.reported(blocker);
  const bool is_stopped = distance(position(other.X_MB), context_.map->point(goal)) <= context_.traffic.stopped_m();
  return is_stopped ? context_.registry[blocker].name() : std::string{};
}

std::string WaitAnalysis::sentence(const Wait& wait) const {
  const std::string& waiter = context_.registry[wait.waiter].name();
  const std::string& blocker = context_.registry[wait.blocker].name();
  const std::string crossing =
      wait.crossing < context_.map->crossing_count() ? context_.map->zone().crossings[wait.crossing].name : "";
  switch (wait.why) {
    case WaitReason::ahead:
      return crossing.empty() ? waiter + " waits for " + blocker + " ahead of it"
                              : waiter + " waits for room beyond " + crossing + ", where " + blocker + " is";
    case WaitReason::crossing: return waiter + " waits for " + crossing + ", which " + blocker + " holds";
    case WaitReason::turn: return waiter + " waits for its turn at " + crossing + " after " + blocker;
    case WaitReason::off_path: return waiter + " waits for " + blocker + ", which is too close to its path";
    case WaitReason::sensors: return waiter + " detects " + blocker + " in its path";
    case WaitReason::plan: return waiter + " waits until " + blocker + " has passed";
  }
  return {};
}

void WaitAnalysis::archive(Archive& archive) { archive(unresponsive_since_); }

}  // namespace cosiva::virtual_side
