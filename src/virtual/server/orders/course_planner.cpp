#include "cosiva/virtual/server/orders/course_planner.h"

#include <algorithm>
#include <array>
#include <string_view>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr double past_base_m = 0.25;
/// The route is planned this far beyond the released part, and for this number of sections.
constexpr double planned_m = 8.0;
constexpr std::size_t planned_sections = 8;

}  // namespace

std::optional<WaypointIndex> CoursePlanner::adopt_course(VehicleIndex vehicle, const wire::State& state) {
  const auto& track_position = positions_.reported(vehicle).position;
  vehicles_[vehicle].route_of = 0;
  if (!track_position) return std::nullopt;
  std::vector<std::string_view> ids;
  std::size_t released = 0;
  for (const wire::NodeState& node : state.node_states) {
    ids.emplace_back(node.node_id);
    if (node.released) released = ids.size();
  }
  if (released == 0) return std::nullopt;
  auto through = context_.map->through(*track_position, ids, released);
  if (!through) return std::nullopt;
  // The mission determines the course beyond the base.
  through->sections.resize(through->to_end);
  set_course(vehicle, zone::Course(std::move(through->sections)));
  return through->end;
}

void CoursePlanner::set_course(VehicleIndex vehicle, zone::Course course) {
  if (const auto& twin = context_.registry[vehicle].twin()) context_.simulator.set_course(*twin, course);
  context_.traffic.set_course(vehicle, std::move(course));
}

bool CoursePlanner::plan(VehicleIndex vehicle) {
  auto& [route_of, no_route] = vehicles_[vehicle];
  const zone::TrackPosition track_position = *positions_.reported(vehicle).position;
  const std::uint64_t revision = context_.missions.revision(vehicle);
  if (route_of == revision && no_route == track_position.section) return false;
  if (route_of == revision && !no_route && context_.traffic.on_course(vehicle) && !is_past_goal(vehicle)) return true;

  const std::vector<zone::TrackPosition> starts = context_.map->starts(track_position);
  const auto sections = context_.missions.plan(vehicle, starts);
  route_of = revision;
  no_route.reset();
  if (!sections) {
    no_route = track_position.section;
    set_course(vehicle, {});
    return false;
  }
  const auto start = std::ranges::find(starts, sections->front(), &zone::TrackPosition::section);
  COSIVA_EXPECT(start != starts.end());
  // The section that the vehicle came from contains its first node, and its position until it has turned into another
  // section.
  std::vector<zone::SectionId> all;
  const Sections traversed = context_.traffic.traversed(vehicle);
  const auto before_start = context_.map->circuit().previous(start->section);
  if (start == starts.begin() ||
      (!traversed.empty() && std::ranges::find(before_start, traversed.back()) != before_start.end()))
    all.assign(traversed.begin(), traversed.end());
  const std::size_t before = all.size();
  all.insert(all.end(), sections->begin(), sections->end());
  set_course(vehicle, zone::Course(std::move(all), before));
  if (start != starts.begin()) {
    positions_.set_position(vehicle, *start);
    if (context_.traffic.track_position(vehicle)) context_.traffic.set_position(vehicle, *start);
    context_.traffic.update();
  }
  return true;
}

bool CoursePlanner::is_past_goal(VehicleIndex vehicle) const {
  const auto& track_position = positions_.reported(vehicle).position;
  const WaypointIndex goal = context_.missions.goal(vehicle);
  if (is_outdated(vehicle) || goal == no_waypoint || !track_position) return false;
  const zone::TrackPosition end = context_.map->waypoint(goal).position;
  const Sections remaining = context_.traffic.remaining(vehicle);
  const bool comes_to_it = std::ranges::find(remaining, end.section) != remaining.end();
  return !comes_to_it && track_position->section == end.section && track_position->s_m > end.s_m;
}

bool CoursePlanner::cannot_reach_handover(VehicleIndex vehicle) const {
  // Where the path ends behind the position of the handover, a vehicle that has passed that position cannot return. The
  // other control area takes the vehicle over from where it is stopped.
  const auto& no_route = vehicles_[vehicle].no_route;
  return no_route && no_route == positions_.reported(vehicle).position->section &&
         !context_.missions.mission(vehicle).beyond.empty();
}

bool CoursePlanner::stays_at_goal(VehicleIndex vehicle) {
  const bool past = is_past_goal(vehicle);
  const Point2 here = position(positions_.reported(vehicle).X_MB);
  // A vehicle that stops short can drive nearer. A vehicle that has passed the goal would have to drive another lap,
  // because of a deviation that its order allowed.
  double off_m = past ? context_.rules.deviation_m : context_.rules.arrived_m;
  if (cannot_reach_handover(vehicle)) off_m = context_.map->zone().vehicle.length_m;
  const auto& state = context_.registry[vehicle].state();
  if (state && state->driving)
    return past || context_.missions.is_at(vehicle, here, off_m);  // its final position is not known yet
  return context_.missions.is_stopped_at(vehicle, here, off_m);
}

bool CoursePlanner::is_outdated(VehicleIndex vehicle) const {
  return vehicles_[vehicle].route_of != context_.missions.revision(vehicle);
}

bool CoursePlanner::plan_beyond_base(VehicleIndex vehicle) {
  auto& [route_of, no_route] = vehicles_[vehicle];
  OrderSession& session = sessions_[vehicle];
  const BeyondBase beyond = beyond_base(context_.traffic, vehicle, *positions_.reported(vehicle).position);
  const zone::TrackPosition end = context_.map->waypoint(session.base_end()).position;
  const Sections released = context_.traffic.remaining(vehicle).first(beyond.keep);
  const bool ends_at_node = end.s_m == 0.0 && beyond.keep > 0;
  const bool has_siblings =
      ends_at_node && context_.map->find(context_.map->waypoint(session.base_end()).id).size() > 1;
  if (cancel_before_closed(vehicle, has_siblings ? released.first(released.size() - 1) : released)) return false;

  std::optional<std::vector<zone::SectionId>> sections;
  WaypointIndex base_end = no_waypoint;
  std::size_t keep = beyond.keep;
  if (has_siblings) {
    // At a fork the vehicle may still take any branch.
    const zone::SectionId before = keep > 1 ? released[keep - 2] : context_.traffic.course(vehicle).here();
    const std::array from{zone::TrackPosition{before, context_.map->circuit().section(before).length_m()}};
    sections = context_.missions.plan(vehicle, from);
    if (sections && sections->size() == 1) {
      const auto more = context_.missions.more(vehicle, before);
      sections->insert(sections->end(), more.begin(), more.end());
    }
    if (sections && sections->size() > 1) base_end = context_.map->sibling_on(session.base_end(), (*sections)[1]);
    if (base_end != no_waypoint) --keep;
  }
  if (base_end == no_waypoint && !(has_siblings && context_.missions.closed().contains(end.section))) {
    base_end = session.base_end();
    const std::array from{end};
    sections = context_.missions.plan(vehicle, from);
  }
  route_of = context_.missions.revision(vehicle);
  no_route.reset();
  context_.traffic.cut_course(vehicle, keep);
  if (sections && base_end != no_waypoint) {
    context_.traffic.extend_course(vehicle, Sections{*sections}.subspan(1));
    session.set_base_end(base_end);
  } else {
    no_route = end.section;
  }
  if (const auto& twin = context_.registry[vehicle].twin())
    context_.simulator.set_course(*twin, context_.traffic.course(vehicle));
  context_.traffic.update();
  return true;
}

bool CoursePlanner::cancel_before_closed(VehicleIndex vehicle, Sections released) {
  const auto closed = std::ranges::find_if(
      released, [&](zone::SectionId section) { return context_.missions.closed().contains(section); });
  if (closed == released.end()) return false;
  context_.publisher.log('i', context_.registry[vehicle].name() + ": its base leads into '" +
                                  context_.map->circuit().part(*closed).name +
                                  "', which is closed now; cancelled, a new order follows");
  sessions_[vehicle].cancel();
  return true;
}

bool CoursePlanner::regain(VehicleIndex vehicle) {
  const zone::TrackPosition track_position = *positions_.reported(vehicle).position;
  const zone::TrackPosition end = context_.map->waypoint(sessions_[vehicle].base_end()).position;
  std::vector<zone::SectionId> sections{track_position.section};
  if (!context_.map->circuit().shortest_route(end, track_position, past_base_m)) {
    auto route = context_.map->circuit().shortest_route(track_position, end, context_.traffic.base_m_max(vehicle));
    if (!route) return false;
    sections = std::move(route->sections);
  }
  vehicles_[vehicle].route_of = 0;
  set_course(vehicle, zone::Course(std::move(sections)));
  context_.traffic.update();
  return true;
}

void CoursePlanner::begin_route(Sections first, Sections rest) {
  route_.assign(first.begin(), first.end());
  route_.insert(route_.end(), rest.begin(), rest.end());
}

const WaypointGraph::Stretch* CoursePlanner::next_stretch(VehicleIndex vehicle, WaypointIndex at, std::size_t passed) {
  if (vehicles_[vehicle].no_route || passed > route_.size()) return nullptr;
  const auto far_enough = [&] {
    if (route_.size() - passed < planned_sections) return false;
    double rest_m = 0.0;
    for (std::size_t i = passed; i < route_.size() && rest_m < planned_m; ++i)
      rest_m += context_.map->circuit().section(route_[i]).length_m();
    return rest_m >= planned_m;
  };
  bool longer = false;
  while (!context_.missions.complete(vehicle) && !far_enough()) {
    const auto more =
        context_.missions.more(vehicle, route_.empty() ? context_.map->waypoint(at).position.section : route_.back());
    route_.insert(route_.end(), more.begin(), more.end());
    context_.traffic.extend_course(vehicle, more);
    longer = longer || !more.empty();
  }
  const auto& twin = context_.registry[vehicle].twin();
  if (longer && twin) context_.simulator.set_course(*twin, context_.traffic.course(vehicle));
  if (context_.missions.complete(vehicle) && passed == route_.size() && at == context_.missions.goal(vehicle))
    return nullptr;
  const WaypointGraph::Stretch* stretch = context_.map->along(at, Sections{route_}.subspan(passed));
  return stretch != nullptr && stretch->sections.size() <= route_.size() - passed ? stretch : nullptr;
}

void CoursePlanner::archive(Archive& archive) { archive(vehicles_, route_); }

}  // namespace cosiva::virtual_side
