#include "cosiva/virtual/server/orders/planned_routes.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <span>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/orders/base_reach.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration waits_long = std::chrono::seconds{5};
constexpr SimDuration replan_period = std::chrono::seconds{4};
constexpr double same_m = 1e-6;  // between a state's position and its waypoint's

}  // namespace

void PlannedRoutes::set_map(const WaypointGraph* map) {
  fleet_.set_map(map);
  goals_.set_map(map);
}

void PlannedRoutes::resize(std::size_t vehicles) {
  fleet_.resize(vehicles);
  goals_.resize(vehicles);
  route_waits_.resize(vehicles);
}

void PlannedRoutes::forget(VehicleIndex vehicle) {
  fleet_.forget(vehicle);
  goals_.forget(vehicle);
  route_waits_.forget(vehicle);
}

void PlannedRoutes::update() {
  fleet_.update();
  for (VehicleIndex vehicle = 0; vehicle < sessions_.size(); ++vehicle)
    if (fleet_.plan().takes_part(vehicle) &&
        goals_.choose(vehicle, route_waits_.waited(vehicle, context_.publisher.now())))
      route_waits_.arrive(vehicle);
  replan_when_it_pays();
  fleet_.plan().plan();
  for (VehicleIndex vehicle = 0; vehicle < sessions_.size(); ++vehicle)
    route_waits_.record(vehicle, route_of(vehicle), context_.publisher.now());
}

/// A plan has an order, and no times. Where vehicles are later than others, the order of before makes these wait that
/// could pass first.
void PlannedRoutes::replan_when_it_pays() {
  const SimTime now = context_.publisher.now();
  if (now - replanned_at_ < replan_period) return;
  const planning::TrackFleet& plan = fleet_.plan();
  for (VehicleIndex vehicle = 0; vehicle < sessions_.size(); ++vehicle) {
    if (!plan.takes_part(vehicle) || plan.granted_moves(vehicle) > 0 || !plan.waits_for(vehicle) ||
        now - fleet_.moved_at(vehicle) < waits_long)
      continue;
    fleet_.plan().replan();
    replanned_at_ = now;
    return;
  }
}

std::optional<RouteWaits::Route> PlannedRoutes::route_of(VehicleIndex vehicle) {
  planning::TrackFleet& plan = fleet_.plan();
  const auto& goal = goals_.goal(vehicle);
  if (!goal || !plan.takes_part(vehicle) || !follower_.may_extend(vehicle)) return std::nullopt;
  const std::uint32_t steps = plan.moves_to(*goal, plan.states(vehicle)[0]);
  const bool drives = plan.granted_moves(vehicle) > 0 && !positions_.is_stopped(vehicle);
  return RouteWaits::Route{*goal, steps, drives ? plan.moves_to(*goal, plan.states(vehicle)[1]) : steps};
}

std::optional<BaseExtension> PlannedRoutes::extend(VehicleIndex vehicle) {
  OrderSession& session = sessions_[vehicle];
  if (!fleet_.plan().takes_part(vehicle)) {
    // An order from before a restart, or of another sender, leads where the plan does not know: when it has been
    // driven, the vehicle joins.
    if (session.is_running() && positions_.is_stopped(vehicle)) session.cancel_and_pause();
    return std::nullopt;
  }
  const std::size_t before = fleet_.plan().granted_moves(vehicle);
  const std::size_t added = grant(vehicle);
  if (const auto other = fleet_.plan().waits_for(vehicle); added == 0 && other)
    waits_.wait_for(vehicle, *other, WaitReason::plan);
  if (!session.is_running()) return begin_order(vehicle);
  if (added == 0) return std::nullopt;
  const WaypointIndex from = waypoint_of(vehicle, before);
  COSIVA_EXPECT(from != no_waypoint);
  if (from != session.base_end()) session.set_base_end(from);
  if (!fill_base(vehicle, from, before)) return std::nullopt;
  set_course(vehicle, base_.back()->to);
  return BaseExtension{from, 0.0, base_, {}};
}

std::size_t PlannedRoutes::grant(VehicleIndex vehicle) {
  planning::TrackFleet& plan = fleet_.plan();
  const BaseReach reach{context_.registry[vehicle], context_.map->zone(), context_.rules, context_.publisher.now()};
  double reach_m = 0.0;
  if (sessions_[vehicle].is_running())
    reach_m = context_.traffic.base_left_m(vehicle, *positions_.reported(vehicle).position).value_or(0.0);
  std::size_t granted = 0;
  while (granted < context_.rules.base_nodes_max && reach_m < reach.wanted_m()) {
    const auto& states = plan.states(vehicle);
    const std::size_t end = plan.granted_moves(vehicle);
    if (end + 1 >= states.size()) break;
    const double next_m = reach_m + plan.track().length_m(states[end], states[end + 1]);
    if (!reach.extends(reach_m, next_m) || !plan.grant(vehicle)) break;
    reach_m = next_m;
    ++granted;
    fleet_.begin_move(vehicle);
  }
  return granted;
}

std::optional<BaseExtension> PlannedRoutes::begin_order(VehicleIndex vehicle) {
  if (fleet_.plan().granted_moves(vehicle) == 0) return std::nullopt;
  if (positions_.goes_onto_line(vehicle) && !follower_.go_to_entry_point(vehicle)) return std::nullopt;
  // Between two nodes the order begins at the one behind the vehicle.
  const WaypointIndex from = waypoint_of(vehicle, 0);
  if (from == no_waypoint) return std::nullopt;
  const zone::TrackPosition start = context_.map->waypoint(from).position;
  const zone::TrackPosition here = *positions_.reported(vehicle).position;
  // At a node the vehicle may leave by any section; its report names one of them.
  const auto& states = fleet_.plan().states(vehicle);
  if (here.section != start.section && here.section != fleet_.plan().track().position(states[0]).section) {
    positions_.set_position(vehicle, start);
    if (context_.traffic.track_position(vehicle)) context_.traffic.set_position(vehicle, start);
  }
  if (!fill_base(vehicle, from, 0)) return std::nullopt;
  set_course(vehicle, base_.back()->to);
  const double to_first_m = distance(context_.map->point(from), position(fleet_.pose(vehicle)));
  return BaseExtension{from, to_first_m, base_, {}};
}

bool PlannedRoutes::fill_base(VehicleIndex vehicle, WaypointIndex from, std::size_t move) {
  base_.clear();
  for (WaypointIndex at = from; move < fleet_.plan().granted_moves(vehicle); ++move) {
    const WaypointGraph::Stretch* const stretch = stretch_of(vehicle, at, move);
    if (stretch == nullptr) {
      context_.publisher.log('w', context_.registry[vehicle].name() + ": no stretch leads from " +
                                      context_.map->waypoint(at).id + " along its planned move");
      return false;
    }
    base_.push_back(stretch);
    at = waypoint_of(vehicle, move + 1);
    if (at == no_waypoint) at = stretch->to;
  }
  return true;
}

/// The waypoint at a state on the section by which the vehicle leaves, if it does.
WaypointIndex PlannedRoutes::waypoint_of(VehicleIndex vehicle, std::size_t state) const {
  const WaypointGraph& map = *context_.map;
  const planning::TrackFloor& track = fleet_.plan().track();
  const auto& states = fleet_.plan().states(vehicle);
  const zone::TrackPosition at = track.position(states[state]);
  const auto at_start_of = [&](zone::SectionId section) {
    const WaypointIndex first = map.first_on(section);
    return first != no_waypoint && map.waypoint(first).position.s_m == 0.0 ? first : no_waypoint;
  };
  // What is planned and not granted may change: the branch is not known yet.
  if (state < fleet_.plan().granted_moves(vehicle))
    if (const auto beyond = track.sections(states[state], states[state + 1]); !beyond.empty())
      return at_start_of(beyond.front());
  for (WaypointIndex i = map.first_on(at.section); i < map.size(); ++i) {
    const zone::TrackPosition waypoint = map.waypoint(i).position;
    if (waypoint.section != at.section) break;
    if (std::fabs(waypoint.s_m - at.s_m) < same_m) return i;
  }
  WaypointIndex first = no_waypoint;
  if (at.s_m == 0.0 || std::fabs(map.circuit().section(at.section).length_m() - at.s_m) >= same_m) return first;
  for (const zone::SectionId next : map.circuit().next(at.section)) first = std::min(first, at_start_of(next));
  return first;
}

const WaypointGraph::Stretch* PlannedRoutes::stretch_of(VehicleIndex vehicle, WaypointIndex from,
                                                        std::size_t move) const {
  const planning::TrackFloor& track = fleet_.plan().track();
  const auto& states = fleet_.plan().states(vehicle);
  const auto sections = track.sections(states[move], states[move + 1]);
  // A move from the end of a section begins on the next one, on which the waypoint lies, too.
  const zone::SectionId start = context_.map->waypoint(from).position.section;
  const auto driven = !sections.empty() && sections.front() == start ? sections.subspan(1) : sections;
  const zone::TrackPosition end = track.position(states[move + 1]);
  std::optional<zone::SectionId> beyond;
  if (move + 1 < fleet_.plan().granted_moves(vehicle))
    if (const auto next = track.sections(states[move + 1], states[move + 2]); !next.empty()) beyond = next.front();
  const WaypointGraph::Stretch* usual = nullptr;
  for (const WaypointGraph::Stretch& stretch : context_.map->stretches(from)) {
    if (stretch.to == no_waypoint || stretch.sections.size() < driven.size() ||
        !std::ranges::equal(Sections{stretch.sections}.first(driven.size()), driven))
      continue;
    const zone::TrackPosition to = context_.map->waypoint(stretch.to).position;
    const bool same =
        stretch.sections.size() == driven.size() && to.section == end.section && std::fabs(to.s_m - end.s_m) < same_m;
    if (same) return &stretch;
    if (stretch.sections.size() != driven.size() + 1 || to.s_m != 0.0) continue;
    if (beyond == to.section) return &stretch;
    if (usual == nullptr) usual = &stretch;
  }
  return usual;
}

void PlannedRoutes::set_course(VehicleIndex vehicle, WaypointIndex end) {
  const planning::TrackFleet& plan = fleet_.plan();
  const auto& states = plan.states(vehicle);
  const zone::TrackPosition here = *positions_.reported(vehicle).position;
  std::vector<zone::SectionId> sections;
  const zone::TrackPosition begin = plan.track().position(states[0]);
  if (begin.s_m == 0.0) sections.push_back(begin.section);
  for (std::size_t move = 0; move < plan.granted_moves(vehicle); ++move) {
    const auto more = plan.track().sections(states[move], states[move + 1]);
    sections.insert(sections.end(), more.begin(), more.end());
  }
  const auto present = std::ranges::find(sections, here.section);
  if (present != sections.end()) sections.erase(sections.begin(), present + 1);
  const zone::SectionId last = context_.map->waypoint(end).position.section;
  if (last != (sections.empty() ? here.section : sections.back())) sections.push_back(last);
  const Sections traversed = context_.traffic.traversed(vehicle);
  std::vector<zone::SectionId> all{traversed.begin(), traversed.end()};
  const std::size_t before = all.size();
  all.push_back(here.section);
  all.insert(all.end(), sections.begin(), sections.end());
  zone::Course course{std::move(all), before};
  if (const auto& twin = context_.registry[vehicle].twin()) context_.simulator.set_course(*twin, course);
  context_.traffic.set_course(vehicle, std::move(course));
  context_.traffic.update();
}

void PlannedRoutes::archive(Archive& archive) { archive(fleet_, goals_, route_waits_, replanned_at_); }

}  // namespace cosiva::virtual_side
