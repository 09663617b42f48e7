// OrderManager: where the next stretch begins, and along which route.
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/decision/line_entry.h"
#include "cosiva/base/math.h"
#include "cosiva/virtual/server/orders/order_manager.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

/// A vehicle is on the path within this distance and this heading error.
constexpr double on_line_m = 0.005;
constexpr double on_line_rad = 0.2;
/// A first node within this distance ahead is preferred to a node far behind.
constexpr double node_ahead_m = 0.10;
constexpr double node_far_behind_m = 1.0;
constexpr double past_base_m = 0.25;
/// The route is planned this far beyond the released part, and for this number of sections.
constexpr double planned_m = 8.0;
constexpr std::size_t planned_sections = 8;
/// Sampling distance along a path for the search of off-path bodies.
constexpr double sample_m = 0.05;

}  // namespace

std::optional<OrderManager::Extension> OrderManager::start_of_extension(VehicleIndex vehicle) {
  return plans_[vehicle].stage == Plan::Stage::running ? end_of_base(vehicle) : first_node(vehicle);
}

std::optional<OrderManager::Extension> OrderManager::end_of_base(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  const zone::TrackPosition track_position = *plan.reported.position;
  const bool on_course = traffic_.on_course(vehicle) || regain_course(vehicle);
  const auto left_m = on_course ? traffic_.base_left_m(vehicle, track_position) : std::nullopt;
  if (!left_m) {
    publisher_.log('w', registry_[vehicle].name + ": is not on the route of its order; cancelled, a new one follows");
    cancel(vehicle);
    plan.wait_until = publisher_.now() + rules_.after_refusal;
    return std::nullopt;
  }
  if (plan.route_of != missions_.revision(vehicle) && !plan_course_again(vehicle)) return std::nullopt;
  route_ = traffic_.beyond_base(vehicle, track_position).sections;
  return Extension{plan.base_end, *left_m};
}

std::optional<OrderManager::Extension> OrderManager::first_node(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  if (goes_onto_line(vehicle)) {
    const auto entry_point = zone::snap_to_path(map_->circuit(), plan.reported.X_MB);
    if (!entry_point) return std::nullopt;
    wait_for(plan, obstructs_line_entry(vehicle, entry_point->position), WaitReason::off_path);
    if (plan.waits_for_vehicle != no_vehicle) {
      traffic_.withdraw(vehicle);  // the other vehicle may need the crossings that this vehicle has requested
      return std::nullopt;
    }
    plan.entry_point = entry_point->position;
    plan.reported.position = entry_point->position;
    plan.reported.off_m = entry_point->distance_m;
    traffic_.set_position(vehicle, entry_point->position);
    traffic_.update();
  }
  if (!plan_course(vehicle)) return std::nullopt;
  const zone::TrackPosition track_position = *plan.reported.position;
  const Sections remaining = traffic_.remaining(vehicle);
  auto behind = map_->behind(track_position, traffic_.traversed(vehicle));
  if (!behind || behind->since_m > node_far_behind_m) {
    const auto ahead = map_->first_ahead(track_position, remaining);
    if (ahead && (!behind || ahead->distance_m <= node_ahead_m)) {
      route_.assign(remaining.begin() + static_cast<std::ptrdiff_t>(ahead->sections), remaining.end());
      if (!traffic_.holds_all(vehicle, ahead->distance_m) && !enter(vehicle, 0.0, ahead->distance_m))
        return std::nullopt;
      return Extension{ahead->waypoint, ahead->distance_m};
    }
  }
  if (!behind) return std::nullopt;
  route_ = std::move(behind->sections);
  route_.insert(route_.end(), remaining.begin(), remaining.end());
  return Extension{behind->waypoint, -behind->since_m};
}

void OrderManager::keep_off_path(VehicleIndex vehicle) {
  // The vehicle stays where its body is: off_path_obstruction() keeps the other vehicles away from the body.
  if (!std::exchange(plans_[vehicle].entry_point, std::nullopt)) return;
  traffic_.set_position(vehicle, std::nullopt);
  traffic_.update();
}

void OrderManager::take_course(VehicleIndex vehicle, zone::Course course) {
  if (const auto& twin = registry_[vehicle].twin) simulator_.set_course(*twin, course);
  traffic_.set_course(vehicle, std::move(course));
}

bool OrderManager::plan_course(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  const zone::TrackPosition track_position = *plan.reported.position;
  const std::uint64_t revision = missions_.revision(vehicle);
  if (plan.route_of == revision && plan.no_route == track_position.section) return false;
  if (plan.route_of == revision && !plan.no_route && traffic_.on_course(vehicle) && !past_goal(vehicle)) return true;

  const std::vector<zone::TrackPosition> starts = map_->starts(track_position);
  const auto sections = missions_.plan(vehicle, starts);
  plan.route_of = revision;
  plan.no_route.reset();
  if (!sections) {
    plan.no_route = track_position.section;
    take_course(vehicle, {});
    return false;
  }
  const auto start = std::ranges::find(starts, sections->front(), &zone::TrackPosition::section);
  // The section that the vehicle came from contains its first node, and its position until it has turned into another
  // section.
  std::vector<zone::SectionId> all;
  const Sections traversed = traffic_.traversed(vehicle);
  const auto before_start = map_->circuit().previous(start->section);
  if (start == starts.begin() ||
      (!traversed.empty() && std::ranges::find(before_start, traversed.back()) != before_start.end()))
    all.assign(traversed.begin(), traversed.end());
  const std::size_t before = all.size();
  all.insert(all.end(), sections->begin(), sections->end());
  take_course(vehicle, zone::Course(std::move(all), before));
  if (start != starts.begin()) {
    plan.reported.position = *start;
    if (traffic_.track_position(vehicle)) traffic_.set_position(vehicle, *start);
    traffic_.update();
  }
  return true;
}

bool OrderManager::past_goal(VehicleIndex vehicle) const {
  const Plan& plan = plans_[vehicle];
  const WaypointIndex goal = missions_.goal(vehicle);
  if (plan.route_of != missions_.revision(vehicle) || goal == no_waypoint || !plan.reported.position) return false;
  const zone::TrackPosition end = map_->waypoint(goal).position;
  const Sections remaining = traffic_.remaining(vehicle);
  const bool comes_to_it = std::ranges::find(remaining, end.section) != remaining.end();
  return !comes_to_it && plan.reported.position->section == end.section && plan.reported.position->s_m > end.s_m;
}

bool OrderManager::stays_at_goal(VehicleIndex vehicle) {
  const bool past = past_goal(vehicle);
  const Point2 here = position(plans_[vehicle].reported.X_MB);
  // A vehicle that stops short can drive nearer. A vehicle that has passed the goal would have to drive another lap,
  // because of a deviation that its order allowed.
  const double off_m = past ? rules_.deviation_m : rules_.arrived_m;
  const auto& state = registry_[vehicle].state;
  if (state && state->driving)
    return past || missions_.is_at(vehicle, here, off_m);  // its final position is not known yet
  return missions_.is_stopped_at(vehicle, here, off_m);
}

bool OrderManager::plan_course_again(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  const Traffic::Beyond beyond = traffic_.beyond_base(vehicle, *plan.reported.position);
  const zone::TrackPosition end = map_->waypoint(plan.base_end).position;
  const Sections released = traffic_.remaining(vehicle).first(beyond.keep);
  const bool ends_at_node = end.s_m == 0.0 && beyond.keep > 0;
  const bool has_siblings = ends_at_node && map_->find(map_->waypoint(plan.base_end).id).size() > 1;
  for (std::size_t i = 0; i < released.size(); ++i) {
    if (!missions_.is_closed(released[i]) || (has_siblings && i + 1 == released.size())) continue;
    publisher_.log('i', registry_[vehicle].name + ": its base leads into '" + map_->circuit().part(released[i]).name +
                            "', which is closed now; cancelled, a new order follows");
    cancel(vehicle);
    return false;
  }

  std::optional<std::vector<zone::SectionId>> sections;
  WaypointIndex base_end = no_waypoint;
  std::size_t keep = beyond.keep;
  if (has_siblings) {
    // At a fork the vehicle may still take any branch.
    const zone::SectionId before = keep > 1 ? released[keep - 2] : traffic_.course(vehicle).here();
    const std::array from{zone::TrackPosition{before, map_->circuit().section(before).length_m()}};
    sections = missions_.plan(vehicle, from);
    if (sections && sections->size() == 1) {
      const auto more = missions_.more(vehicle, before);
      sections->insert(sections->end(), more.begin(), more.end());
    }
    if (sections && sections->size() > 1) base_end = map_->sibling_on(plan.base_end, (*sections)[1]);
    if (base_end != no_waypoint) --keep;
  }
  if (base_end == no_waypoint && !(has_siblings && missions_.is_closed(end.section))) {
    base_end = plan.base_end;
    const std::array from{end};
    sections = missions_.plan(vehicle, from);
  }
  plan.route_of = missions_.revision(vehicle);
  plan.no_route.reset();
  traffic_.cut_course(vehicle, keep);
  if (sections && base_end != no_waypoint) {
    traffic_.extend_course(vehicle, Sections{*sections}.subspan(1));
    plan.base_end = base_end;
    traffic_.set_base_end(vehicle, base_end);
  } else {
    plan.no_route = end.section;
  }
  if (const auto& twin = registry_[vehicle].twin) simulator_.set_course(*twin, traffic_.course(vehicle));
  traffic_.update();
  return true;
}

bool OrderManager::regain_course(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  const zone::TrackPosition track_position = *plan.reported.position;
  const zone::TrackPosition end = map_->waypoint(plan.base_end).position;
  std::vector<zone::SectionId> sections{track_position.section};
  if (!map_->circuit().shortest_route(end, track_position, past_base_m)) {
    auto route = map_->circuit().shortest_route(track_position, end, traffic_.base_m_max(vehicle));
    if (!route) return false;
    sections = std::move(route->sections);
  }
  plan.route_of = 0;
  take_course(vehicle, zone::Course(std::move(sections)));
  traffic_.update();
  return true;
}

const WaypointGraph::Stretch* OrderManager::next_stretch(VehicleIndex vehicle, WaypointIndex at, std::size_t passed) {
  if (plans_[vehicle].no_route || passed > route_.size()) return nullptr;
  const auto far_enough = [&] {
    double rest_m = 0.0;
    for (std::size_t i = passed; i < route_.size(); ++i) rest_m += map_->circuit().section(route_[i]).length_m();
    return rest_m >= planned_m && route_.size() - passed >= planned_sections;
  };
  bool longer = false;
  while (!missions_.complete(vehicle) && !far_enough()) {
    const auto more = missions_.more(vehicle, route_.empty() ? map_->waypoint(at).position.section : route_.back());
    route_.insert(route_.end(), more.begin(), more.end());
    traffic_.extend_course(vehicle, more);
    longer = longer || !more.empty();
  }
  const auto& twin = registry_[vehicle].twin;
  if (longer && twin) simulator_.set_course(*twin, traffic_.course(vehicle));
  if (missions_.complete(vehicle) && passed == route_.size() && at == missions_.goal(vehicle)) return nullptr;
  const WaypointGraph::Stretch* stretch = map_->along(at, Sections{route_}.subspan(passed));
  return stretch != nullptr && stretch->sections.size() <= route_.size() - passed ? stretch : nullptr;
}

bool OrderManager::off_path(VehicleIndex vehicle) const {
  const Plan& plan = plans_[vehicle];
  return plan.entry_point || plan.reported.off_m > on_line_m || std::fabs(plan.reported.heading_off_rad) > on_line_rad;
}

bool OrderManager::goes_onto_line(VehicleIndex vehicle) const {
  const Plan& plan = plans_[vehicle];
  return plan.entry_point || (plan.stage == Plan::Stage::none && off_path(vehicle) && registry_[vehicle].is_cosiva());
}

void OrderManager::follow_line(VehicleIndex vehicle) {
  Plan& plan = plans_[vehicle];
  if (!plan.entry_point || map_ == nullptr) return;
  ReportedPose& reported = plan.reported;
  const zone::Circuit& circuit = map_->circuit();
  const Sections remaining = traffic_.remaining(vehicle);
  std::array<zone::SectionId, 2> candidates{plan.entry_point->section,
                                            remaining.empty() ? plan.entry_point->section : remaining[0]};
  for (const zone::SectionId section : candidates) {
    const auto near = circuit.section(section).nearest(position(reported.X_MB));
    const double off_rad =
        wrap_angle(reported.X_MB.heading_rad - circuit.section(section).pose_at(near.s_m).heading_rad);
    if (near.distance_m > on_line_m || std::fabs(off_rad) > on_line_rad) continue;
    plan.entry_point.reset();
    reported.position = zone::TrackPosition{section, near.s_m};
    reported.off_m = near.distance_m;
    reported.heading_off_rad = off_rad;
    return;
  }
  reported.position = plan.entry_point;
  reported.off_m = distance(reported.X_MB, circuit.pose_at(*plan.entry_point));
  reported.heading_off_rad = 0.0;
}

VehicleIndex OrderManager::obstructs_line_entry(VehicleIndex vehicle, zone::TrackPosition entry_point) const {
  const zone::VehicleShape& shape = map_->zone().vehicle;
  const aiv::LineEntry mine{plans_[vehicle].reported.X_MB, map_->circuit().pose_at(entry_point)};
  aiv::EntrySweep sweep{shape};
  sweep.take(mine);
  for (VehicleIndex other = 0; other < registry_.size(); ++other) {
    const AivProxy& proxy = registry_[other];
    if (other == vehicle || !proxy.here()) continue;
    const Pose2 X_MB = simulator_.image(*proxy.twin, publisher_.now()).X_MB;
    if (sweep.near_body(X_MB)) return other;
    const Plan& theirs = plans_[other];
    // Another vehicle that is joining the path, or whose base leads over the entry position.
    if (theirs.entry_point && (theirs.stage == Plan::Stage::running || theirs.join_handle != 0) &&
        aiv::near_entry(mine, shape, {X_MB, map_->circuit().pose_at(*theirs.entry_point)}))
      return other;
    const auto& track_position = traffic_.track_position(other);
    if (!track_position) continue;
    const double base_m = traffic_.base_left_m(other, *track_position).value_or(0.0);
    const Sections remaining = traffic_.remaining(other);
    for (double ahead_m = sample_m; ahead_m < base_m + sample_m; ahead_m += sample_m)
      if (sweep.near_body(
              map_->circuit().pose_at(map_->circuit().advance(*track_position, std::min(ahead_m, base_m), remaining))))
        return other;
    const double clear_m = shape.length_m + aiv::entry_clear_m;
    if (base_m > 0.0 && map_->ahead(*track_position, entry_point, base_m + clear_m, traffic_.remaining(other)))
      return other;
  }
  return no_vehicle;
}

VehicleIndex OrderManager::off_path_obstruction(VehicleIndex vehicle, double from_m, double to_m) const {
  constexpr double clear_m = 0.04;  // not less than the clearance at which a vehicle's own obstacle sensor stops it
  const zone::TrackPosition track_position = *plans_[vehicle].reported.position;
  const zone::Circuit& circuit = map_->circuit();
  const zone::VehicleShape& shape = map_->zone().vehicle;
  const Sections remaining = traffic_.remaining(vehicle);
  aiv::EntrySweep sweep{shape};
  for (const VehicleIndex other : neighbour_) {
    if (other == vehicle) continue;
    const Pose2 X_MB = simulator_.image(*registry_[other].twin, publisher_.now()).X_MB;
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

std::optional<zone::TrackPosition> OrderManager::comes_onto_line_at(VehicleIndex vehicle) const {
  const Plan& plan = plans_[vehicle];
  if (plan.entry_point) return plan.entry_point;
  // A vehicle that waits to join the path is let in, but only for a limited time: it may be unable to join.
  if (!plan.waits_since || publisher_.now() - *plan.waits_since > rules_.let_in_for || !goes_onto_line(vehicle))
    return {};
  const auto entry_point = zone::snap_to_path(map_->circuit(), plan.reported.X_MB);
  return entry_point ? std::optional{entry_point->position} : std::nullopt;
}

std::string OrderManager::blocker_at_goal(VehicleIndex vehicle) const {
  const Plan& plan = plans_[vehicle];
  const WaypointIndex goal = missions_.goal(vehicle);
  if (plan.waits_for_vehicle == no_vehicle || goal == no_waypoint || map_ == nullptr) return {};
  const ReportedPose& other = plans_[plan.waits_for_vehicle].reported;
  const bool is_stopped = distance(position(other.X_MB), map_->point(goal)) <= traffic_.stopped_m();
  return is_stopped ? registry_[plan.waits_for_vehicle].name : std::string{};
}

}  // namespace cosiva::virtual_side
