#include "cosiva/virtual/server/orders/route_follower.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/math.h"
#include "cosiva/virtual/server/orders/base_reach.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

/// With a heading error beyond this a vehicle is not aligned with its section and cannot follow it.
constexpr double heading_off_rad_max = pi / 3.0;
/// A first node within this distance ahead is preferred to a node far behind.
constexpr double node_ahead_m = 0.10;
constexpr double node_far_behind_m = 1.0;

}  // namespace

bool RouteFollower::may_extend(VehicleIndex vehicle) const {
  const AivProxy& proxy = context_.registry[vehicle];
  const ReportedPose& reported = positions_.reported(vehicle);
  if (!proxy.state() || !proxy.reported_state.in_session() || !proxy.online() || proxy.settings.no_orders() ||
      proxy.lost(context_.publisher.now(), context_.lost_after))
    return false;
  const wire::State& state = *proxy.state();
  const bool this_map = proxy.position.map_id().empty() || proxy.position.map_id() == context_.map->zone().name;
  const bool along = std::fabs(reported.heading_off_rad) <= heading_off_rad_max || positions_.goes_onto_line(vehicle);
  return proxy.position.known() && this_map && reported.position && reported.off_m <= context_.rules.on_circuit_m &&
         along && state.operating_mode == wire::OperatingMode::automatic && !state.paused &&
         state.e_stop == wire::EStop::none;
}

std::optional<BaseExtension> RouteFollower::extend(VehicleIndex vehicle) {
  base_.clear();
  horizon_.clear();
  leads_on_.reset();
  const bool is_new = !sessions_[vehicle].is_running();
  const auto from = is_new ? first_node(vehicle) : end_of_base(vehicle);
  if (!from) return std::nullopt;
  extend_from(vehicle, *from);
  if (base_.empty() && !leads_too_far(vehicle)) return std::nullopt;
  announce(vehicle, *from);
  const double to_first_m = is_new ? std::fabs(from->reach_m) + positions_.reported(vehicle).off_m : 0.0;
  return BaseExtension{from->from, to_first_m, base_, horizon_};
}

std::optional<RouteFollower::Start> RouteFollower::end_of_base(VehicleIndex vehicle) {
  OrderSession& session = sessions_[vehicle];
  const zone::TrackPosition track_position = *positions_.reported(vehicle).position;
  const bool on_course = context_.traffic.on_course(vehicle) || planner_.regain(vehicle);
  const auto left_m = on_course ? context_.traffic.base_left_m(vehicle, track_position) : std::nullopt;
  if (!left_m) {
    context_.publisher.log(
        'w', context_.registry[vehicle].name() + ": is not on the route of its order; cancelled, a new one follows");
    session.cancel_and_pause();
    return std::nullopt;
  }
  if (planner_.is_outdated(vehicle) && !planner_.plan_beyond_base(vehicle)) return std::nullopt;
  planner_.begin_route_beyond_base(vehicle, track_position);
  return Start{session.base_end(), *left_m};
}

std::optional<RouteFollower::Start> RouteFollower::first_node(VehicleIndex vehicle) {
  if (positions_.goes_onto_line(vehicle) && !go_to_entry_point(vehicle)) return std::nullopt;
  if (!planner_.plan(vehicle)) return std::nullopt;
  const zone::TrackPosition track_position = *positions_.reported(vehicle).position;
  const Sections remaining = context_.traffic.remaining(vehicle);
  const auto behind = context_.map->behind(track_position, context_.traffic.traversed(vehicle));
  if (!behind || behind->since_m > node_far_behind_m) {
    const auto ahead = context_.map->first_ahead(track_position, remaining);
    if (ahead && (!behind || ahead->distance_m <= node_ahead_m)) {
      planner_.begin_route(remaining.subspan(ahead->sections));
      if (!context_.traffic.holds_all(vehicle, ahead->distance_m) && !enter(vehicle, 0.0, ahead->distance_m))
        return std::nullopt;
      return Start{ahead->waypoint, ahead->distance_m};
    }
  }
  if (!behind) return std::nullopt;
  planner_.begin_route(behind->sections, remaining);
  return Start{behind->waypoint, -behind->since_m};
}

bool RouteFollower::go_to_entry_point(VehicleIndex vehicle) {
  const auto entry_point = zone::snap_to_path(context_.map->circuit(), positions_.reported(vehicle).X_MB);
  if (!entry_point) return false;
  const VehicleIndex other = joins_.obstructs_line_entry(vehicle, entry_point->position);
  waits_.wait_for(vehicle, other, WaitReason::off_path);
  if (other != no_vehicle) {
    context_.traffic.withdraw(vehicle);  // the other vehicle may need the crossings that this vehicle has requested
    return false;
  }
  positions_.set_entry_point(vehicle, entry_point->position, entry_point->distance_m);
  context_.traffic.set_position(vehicle, entry_point->position);
  context_.traffic.update();
  return true;
}

void RouteFollower::keep_off_path(VehicleIndex vehicle) {
  // The vehicle stays where its body is: off_path_obstruction() keeps the other vehicles away from the body.
  if (!positions_.clear_entry_point(vehicle)) return;
  context_.traffic.set_position(vehicle, std::nullopt);
  context_.traffic.update();
}

bool RouteFollower::leads_too_far(VehicleIndex vehicle) {
  // The vehicle no longer follows the announced horizon; a vehicle with a horizon does not count as arrived.
  const OrderSession& session = sessions_[vehicle];
  if (!session.is_running() || !session.has_horizon()) return false;
  if (!leads_on_) leads_on_ = planner_.next_stretch(vehicle, session.base_end(), 0) != nullptr;
  return !*leads_on_;
}

bool RouteFollower::comes_again(VehicleIndex vehicle, const Start& from, std::size_t passed,
                                const WaypointGraph::Stretch& stretch) const {
  // A base that passes one position twice has two ends of the same name. A vehicle that has passed the end of its base
  // and is in the next section reaches that section for the first time.
  const bool on_its_base = sessions_[vehicle].is_running() && from.reach_m > 0.0;
  const zone::TrackPosition start =
      on_its_base ? *positions_.reported(vehicle).position : context_.map->waypoint(from.from).position;
  Sections released;
  if (on_its_base)
    released = context_.traffic.remaining(vehicle).first(sections_of_base(context_.traffic, vehicle, start));
  const Sections added = planner_.route().first(passed);
  const auto on_base = [&](zone::SectionId section) {
    return std::ranges::find(released, section) != released.end() || std::ranges::find(added, section) != added.end();
  };
  // On the return to its present section the base may reach up to its present position.
  const zone::TrackPosition end = context_.map->waypoint(stretch.to).position;
  const bool beyond_start = end.section != start.section || end.s_m >= start.s_m;
  if (stretch.sections.empty()) return end.section == start.section && on_base(start.section) && beyond_start;
  return std::ranges::any_of(stretch.sections, [&](zone::SectionId section) {
    return section == start.section ? beyond_start : on_base(section);
  });
}

void RouteFollower::extend_from(VehicleIndex vehicle, const Start& from) {
  WaypointIndex at = from.from;
  std::size_t passed = 0;
  double reach_m = from.reach_m;
  double in_convoy_m = 0.0;   // up to here the leader holds the same crossings and has a base to leave them
  double must_reach_m = 0.0;  // a granted chain is released as a whole: no vehicle stops in a crossing for lack of base
  const BaseReach reach{context_.registry[vehicle], context_.map->zone(), context_.rules, context_.publisher.now()};
  while (base_.size() < context_.rules.base_nodes_max && (reach_m < reach.wanted_m() || reach_m < must_reach_m)) {
    const WaypointGraph::Stretch* stretch = planner_.next_stretch(vehicle, at, passed);
    if (!leads_on_) leads_on_ = stretch != nullptr;
    if (stretch == nullptr) break;
    if (comes_again(vehicle, from, passed, *stretch)) break;
    const double next_m = reach_m + stretch->length_m;
    const bool enters = stretch->crosses && !context_.traffic.holds_all(vehicle, next_m);
    WaypointGraph::Chain chain{no_waypoint, stretch->length_m};
    if (enters) {
      const WaypointIndex goal = context_.missions.complete(vehicle) ? context_.missions.goal(vehicle) : no_waypoint;
      chain = context_.map->chain(at, planner_.route().subspan(passed), goal);
    }
    const double chain_m = reach_m + chain.length_m;
    if (reach_m >= must_reach_m && !reach.extends(reach_m, std::max(next_m, chain_m), stretch->speed_mps_max)) break;
    const bool joins = enters && joins_convoy(vehicle, {reach_m, next_m, chain_m});
    if (joins) in_convoy_m = chain_m;
    const bool moves_up = yielding_.moves_up(vehicle) && !enters && base_.empty();
    if (next_m > std::max(in_convoy_m, context_.traffic.reach_m(vehicle, next_m)) && !moves_up) {
      waits_.wait_for(vehicle, context_.traffic.ahead_within(vehicle, next_m + context_.traffic.stopped_m()).vehicle,
                      WaitReason::ahead);
      break;
    }
    if (const VehicleIndex other = joins_.off_path_obstruction(vehicle, reach_m, chain_m); other != no_vehicle) {
      waits_.wait_for(vehicle, other, WaitReason::off_path);
      context_.traffic.withdraw(vehicle);  // the other vehicle may need the crossings that this vehicle has requested
      break;
    }
    if (enters) {
      if (!joins && !enter(vehicle, reach_m, chain_m)) break;
      if (joins) join_convoy(vehicle);
      must_reach_m = chain_m - 1e-6;
    }
    base_.push_back(stretch);
    at = stretch->to;
    passed += stretch->sections.size();
    reach_m = next_m;
  }
  COSIVA_EXPECT(base_.size() <= context_.rules.base_nodes_max);
  yielding_.end_moving_up(vehicle);
}

void RouteFollower::announce(VehicleIndex vehicle, const Start& from) {
  WaypointIndex at = base_.empty() ? from.from : base_.back()->to;
  std::size_t passed = 0;
  for (const WaypointGraph::Stretch* stretch : base_) passed += stretch->sections.size();
  while (horizon_.size() < context_.rules.horizon) {
    const WaypointGraph::Stretch* stretch = planner_.next_stretch(vehicle, at, passed);
    if (stretch == nullptr) break;
    horizon_.push_back(stretch);
    at = stretch->to;
    passed += stretch->sections.size();
  }
}

bool RouteFollower::enter(VehicleIndex vehicle, double stop_m, double exit_m) {
  if (stop_m > context_.traffic.rules().request_within_m) return false;
  const auto response = context_.traffic.request(vehicle, exit_m, stop_m);
  if (response.granted) return true;
  waits_.wait_for(vehicle, response);
  return false;
}

bool RouteFollower::joins_convoy(VehicleIndex vehicle, const ChainAhead& chain) {
  // The base does not keep the vehicle away from its leader: its obstacle sensor must.
  if (chain.next_m <= context_.traffic.reach_m(vehicle, chain.next_m)) return false;
  const VehicleIndex ahead = context_.traffic.ahead(vehicle).vehicle;
  if (!detects(context_.registry, vehicle, ahead)) return false;
  // A vehicle that is stopped by command will not make room soon.
  if (!may_extend(ahead) || yielding_.yields(ahead)) return false;
  return context_.traffic.may_join(vehicle, chain.exit_m, chain.stop_m);
}

void RouteFollower::join_convoy(VehicleIndex vehicle) {
  const VehicleIndex ahead = context_.traffic.ahead(vehicle).vehicle;
  const auto [size, crossings] = context_.traffic.join(vehicle);
  std::string through;
  for (const CrossingIndex x : crossings)
    through += (through.empty() ? "" : " and ") + context_.map->zone().crossings[x].name;
  context_.publisher.explain(
      context_.registry[vehicle], "convoy",
      "convoy of " + std::to_string(size) + " through " + through + ", behind " + context_.registry[ahead].name());
}

}  // namespace cosiva::virtual_side
