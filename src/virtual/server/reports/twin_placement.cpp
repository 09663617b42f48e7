#include "cosiva/virtual/server/reports/twin_placement.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

double speed_mps(const MotionReport& report) { return norm(report.vx_mps.value_or(0.0), report.vy_mps); }

/// How much further a report is from the one before than the vehicle can have driven meanwhile; 0 after a gap, in which
/// it may have driven otherwise.
double shift_m(const MotionReport& before, const MotionReport& after) {
  const SimDuration dt = after.at - before.at;
  if (dt < SimDuration::zero() || dt > TwinLink::shift_kept) return 0.0;
  const double driven_m = std::max(speed_mps(before), speed_mps(after)) * to_seconds(dt);
  return std::max(0.0, distance(before.X_MB, after.X_MB) - driven_m);
}

}  // namespace

void TwinPlacement::put(VehicleIndex vehicle, SimTime at, const Pose2& pose,
                        const std::optional<wire::Velocity>& velocity) {
  AivProxy& proxy = context_.registry[vehicle];
  if (!proxy.twin()) {
    proxy.twin_link.on_appeared(context_.simulator.appear(proxy.name(), proxy.identity.number(), proxy.augmented(),
                                                          context_.options.lost_after, step_recorder(context_)));
    record_event(proxy, PhysicalEvent::arrival, at);
    apply_base_end(vehicle);
  }
  COSIVA_EXPECT(proxy.twin().has_value());
  // Vehicles report body frames, twins move in travel frames.
  const bool indirect = context_.simulator.zone() && context_.simulator.zone()->circuit.indirect();
  const Pose2 X_MB{pose.x_m, pose.y_m, wrap_angle(pose.heading_rad)};
  MotionReport report{at, indirect ? turned_round(X_MB) : X_MB, {}, 0.0, 0.0};
  if (velocity) {
    report.vx_mps = indirect ? -velocity->vx_mps : velocity->vx_mps;
    report.vy_mps = indirect ? -velocity->vy_mps : velocity->vy_mps;
    report.omega_radps = velocity->omega_radps;
  }
  // All control areas use one frame: a pose on the map of another area is valid on this map as well.
  const std::string& map_id = proxy.position.map_id();
  report.on_map = !map_ || map_id.empty() || map_id == map_->zone().name || context_.areas.has_map(map_id);
  const Twin& twin = context_.simulator.twin(*proxy.twin());
  if (twin.on_circuit()) proxy.twin_link.on_shift(context_.now, shift_m(twin.last_report(), report));
  report.at_crossing = at_crossing(twin);
  context_.simulator.report(*proxy.twin(), context_.now, report, step_recorder(context_),
                            [&](const Twin& its) { return forecast_.expectation_of(vehicle, its); });
  if (map_)
    master_.orders.set_reported_pose(
        vehicle, {twin.reported_position(), twin.reported_off_m(), twin.heading_off_rad(), report.X_MB});
}

bool TwinPlacement::at_crossing(const Twin& twin) {
  constexpr double near_m = 0.6;
  if (!map_ || !twin.on_circuit()) return false;
  crossings_near_.clear();
  const zone::TrackPosition here = twin.reported_position();
  map_->crossings_on(here, near_m, crossings_near_, twin.remaining(here.section));
  return !crossings_near_.empty();
}

void TwinPlacement::apply_base_end(VehicleIndex vehicle) {
  AivProxy& proxy = context_.registry[vehicle];
  if (!proxy.twin() || !proxy.state() || !map_) return;
  const wire::State& state = *proxy.state();
  std::optional<zone::TrackPosition> end;
  if (!state.node_states.empty()) {
    const auto released =
        std::ranges::find_if(state.node_states.rbegin(), state.node_states.rend(), &wire::NodeState::released);
    const std::string& id = released == state.node_states.rend() ? state.last_node_id : released->node_id;
    // Of several waypoints of that id, the one that the order ends at is meant.
    const WaypointIndex sent = master_.traffic.base_end(vehicle);
    const auto known = map_->find(id);
    if (sent != no_waypoint && map_->waypoint(sent).id == id)
      end = map_->waypoint(sent).position;
    else if (!known.empty())
      end = map_->waypoint(known.front()).position;
  }
  proxy.twin_link.on_base(end);
  context_.simulator.set_base_end(*proxy.twin(), end);
}

void TwinPlacement::set_present(AivProxy& proxy) {
  if (proxy.twin_link.present()) return;
  proxy.twin_link.on_present();
  if (!proxy.augmented()) context_.simulator.monitor().set_physical(proxy.twin_link.entity(), true);
}

void TwinPlacement::record_event(const AivProxy& proxy, PhysicalEvent kind, SimTime reported_at) {
  if (!proxy.augmented())
    context_.simulator.monitor().event(kind, to_milliseconds_by_seconds(context_.now - reported_at));
}

}  // namespace cosiva::virtual_side
