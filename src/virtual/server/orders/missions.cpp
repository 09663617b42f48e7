#include "cosiva/virtual/server/orders/missions.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>
#include <utility>

namespace cosiva::virtual_side {
namespace {

/// Maximum distance between a station and its waypoint, which is rounded.
constexpr double station_m = 0.02;

}  // namespace

void Missions::set_map(const WaypointGraph* map) {
  map_ = map;
  router_.reset();
  for_ever_.clear();
  for (Entry& entry : entries_) {
    Entry fresh;
    fresh.mission = std::move(entry.mission);
    fresh.revision = entry.revision;
    entry = std::move(fresh);
  }
  ++revision_;
  if (map_ == nullptr) return;
  router_.emplace(map_->zone());
  configured_ = map_->zone().closed;
  closed_ = configured_;
  for (VehicleIndex v = 0; v < entries_.size(); ++v) {
    Mission& mission = entries_[v].mission;
    if (known(mission)) continue;
    publisher_.log('w',
                   registry_[v].name + ": this zone has no '" + mission.name + "'; it follows its default mission");
    mission = {};
  }
  restore_for_zone();
  for_ever_ = router_->goes_on_for_ever(closed_);
}

void Missions::renew() {
  router_.emplace(map_->zone());
  if (map_->zone().closed == configured_) return;
  configured_ = map_->zone().closed;
  closed_ = configured_;
  closed_changed();
}

void Missions::closed_changed() {
  for_ever_ = router_->goes_on_for_ever(closed_);
  ++revision_;
}

bool Missions::is_closed(zone::SectionId section) const { return std::ranges::binary_search(closed_, section); }

std::vector<WaypointIndex> Missions::goals(std::string_view name) const {
  std::vector<WaypointIndex> found;
  std::string_view id = name;
  if (const zone::Station* station = map_->zone().find_station(name)) {
    const auto& waypoints = map_->zone().waypoints;
    const auto section_of = [](const zone::Waypoint& waypoint) { return waypoint.position.section; };
    WaypointIndex nearest = no_waypoint;
    double off_m = station_m;
    auto it = std::ranges::lower_bound(waypoints, station->position.section, {}, section_of);
    for (; it != waypoints.end() && it->position.section == station->position.section; ++it) {
      const double here_m = std::fabs(it->position.s_m - station->position.s_m);
      if (here_m > off_m) continue;
      nearest = static_cast<WaypointIndex>(it - waypoints.begin());
      off_m = here_m;
    }
    if (nearest == no_waypoint) return found;
    id = map_->waypoint(nearest).id;
  }
  const auto all = map_->find(id);
  found.assign(all.begin(), all.end());
  return found;
}

const zone::Loop* Missions::loop_of(const Entry& entry) const {
  const auto& loops = map_->zone().loops;
  if (entry.mission.name.empty()) return loops.empty() ? nullptr : &loops.front();
  return map_->zone().find_loop(entry.mission.name);
}

bool Missions::known(const Mission& mission) const {
  if (mission.kind == Mission::Kind::go) return !goals(mission.name).empty();
  return mission.name.empty() || map_->zone().find_loop(mission.name) != nullptr;
}

void Missions::no_route(Entry& entry, const Error& error) {
  entry.state = State::no_route;
  entry.why = error.message;
  entry.complete = true;
}

std::vector<zone::SectionId> Missions::shut(Sections avoided) const {
  std::vector<zone::SectionId> all;
  all.reserve(closed_.size() + avoided.size());
  std::ranges::set_union(closed_, avoided, std::back_inserter(all));
  return all;
}

bool Missions::has_detour(VehicleIndex vehicle, zone::TrackPosition from, Sections around) const {
  const Entry& entry = entries_[vehicle];
  const auto closed = shut(around);
  if (entry.mission.kind == Mission::Kind::go)
    return std::ranges::any_of(goals(entry.mission.name), [&](WaypointIndex goal) {
      return router_->plan(from, map_->waypoint(goal).position, closed).has_value();
    });
  if (const zone::Loop* loop = loop_of(entry)) return router_->plan(from, *loop, closed).has_value();
  return router_->goes_on_for_ever(closed)[from.section];
}

void Missions::avoid(VehicleIndex vehicle, std::vector<zone::SectionId> sections) {
  Entry& entry = entries_[vehicle];
  if (entry.avoided == sections) return;
  entry.avoided = std::move(sections);
  ++entry.revision;
}

std::optional<std::vector<zone::SectionId>> Missions::plan(VehicleIndex vehicle,
                                                           std::span<const zone::TrackPosition> starts) {
  Entry& entry = entries_[vehicle];
  entry.goal = no_waypoint;
  entry.complete = false;
  entry.why.clear();
  entry.state = State::driving;
  const zone::Loop* loop = entry.mission.kind == Mission::Kind::circulate ? loop_of(entry) : nullptr;
  if (entry.mission.kind == Mission::Kind::circulate && loop == nullptr) {
    std::vector<zone::SectionId> sections;
    for (const zone::TrackPosition& start : starts) sections.push_back(start.section);
    const zone::SectionId best = sections.size() == 1 ? zone::no_section : least_recent(entry, sections);
    return std::vector{best == zone::no_section ? sections.front() : best};
  }

  std::optional<zone::Route> best;
  std::optional<Error> error;
  const auto consider = [&](Result<zone::Route> route, WaypointIndex goal) {
    if (!route) {
      if (!error) error = std::move(route.error());
    } else if (!best || route->time_s < best->time_s) {
      best = std::move(*route);
      entry.goal = goal;
    }
  };
  for (const zone::TrackPosition& start : starts) {
    if (loop != nullptr) {
      consider(router_->plan(start, *loop, shut(entry.avoided)), no_waypoint);
      continue;
    }
    for (const WaypointIndex goal : goals(entry.mission.name))
      consider(router_->plan(start, map_->waypoint(goal).position, shut(entry.avoided)), goal);
  }
  if (!best) {
    no_route(entry, error.value_or(Error{"route.none", "the zone has no '" + entry.mission.name + "' any more", ""}));
    publisher_.log('w', registry_[vehicle].name + ": no route: " + entry.why);
    return std::nullopt;
  }
  entry.complete = entry.mission.kind == Mission::Kind::go;
  return std::move(best->sections);
}

std::vector<zone::SectionId> Missions::more(VehicleIndex vehicle, zone::SectionId last) {
  Entry& entry = entries_[vehicle];
  if (entry.complete) return {};
  const zone::Loop* loop = loop_of(entry);
  if (loop == nullptr) return branch(entry, last);
  auto lap = router_->plan({last, map_->circuit().section(last).length_m()}, *loop, shut(entry.avoided));
  const auto next = map_->circuit().next(last);
  const bool alone = lap && lap->sections.size() < 2 && std::ranges::find(next, last) != next.end() && !is_closed(last);
  if (alone) return {last};
  if (!lap || lap->sections.size() < 2) {
    no_route(entry, lap ? Error{"route.none", "the loop ends here", ""} : lap.error());
    return {};
  }
  return {lap->sections.begin() + 1, lap->sections.end()};
}

zone::SectionId Missions::least_recent(const Entry& entry, Sections choice) const {
  const auto worth = [&](zone::SectionId section) {
    const auto taken = entry.taken.find(section);
    // Branches that lead into a dead end come last, regardless of when they were taken.
    constexpr auto dead_end = std::numeric_limits<std::uint64_t>::max() / 2;
    return (taken == entry.taken.end() ? 0 : taken->second) + (for_ever_[section] ? 0 : dead_end);
  };
  zone::SectionId best = zone::no_section;
  for (const zone::SectionId section : choice)
    if (!is_closed(section) && !std::ranges::binary_search(entry.avoided, section) &&
        (best == zone::no_section || worth(section) < worth(best)))
      best = section;
  return best;
}

std::vector<zone::SectionId> Missions::branch(Entry& entry, zone::SectionId last) {
  const auto next = map_->circuit().next(last);
  const zone::SectionId best = least_recent(entry, next);
  if (best == zone::no_section) {
    const std::string& name = map_->circuit().part(last).name;
    no_route(
        entry,
        {"route.none",
         next.empty() ? "the path ends with '" + name + "'" : "every section after '" + name + "' is closed", name});
    return {};
  }
  if (next.size() > 1) entry.taken[best] = ++entry.forks;
  return {best};
}

bool Missions::is_at(VehicleIndex vehicle, Point2 p, double off_m) const {
  const Entry& entry = entries_[vehicle];
  if (entry.mission.kind != Mission::Kind::go) return false;
  if (entry.state == State::arrived) return true;
  const auto all = goals(entry.mission.name);
  return std::ranges::any_of(all, [&](WaypointIndex i) { return distance(map_->point(i), p) <= off_m; });
}

bool Missions::is_stopped_at(VehicleIndex vehicle, Point2 p, double off_m) {
  if (!is_at(vehicle, p, off_m)) return false;
  Entry& entry = entries_[vehicle];
  if (entry.state == State::arrived) return true;
  entry.state = State::arrived;
  entry.why.clear();
  entry.complete = true;
  publisher_.log('i', registry_[vehicle].name + ": arrived at " + entry.mission.name +
                          (entry.mission.beyond.empty() ? "" : ", continuing to " + entry.mission.beyond));
  return true;
}

void Missions::give(VehicleIndex vehicle, Mission mission) {
  Entry& entry = entries_[vehicle];
  entry.mission = std::move(mission);
  entry.state = State::driving;
  entry.why.clear();
  entry.avoided.clear();
  ++entry.revision;
  registry_[vehicle].no_orders = false;
}

void Missions::follow(const MissionCommand& command) {
  const auto vehicles = addressed(command.vehicle_names);
  Mission mission{command.goes ? Mission::Kind::go : Mission::Kind::circulate, command.name};
  if (command.goes && goals(command.name).empty() && abroad_) {
    auto leads = abroad_(command.name);
    if (!leads) return publisher_.log('w', "command refused: " + to_string(leads.error()));
    mission = std::move(*leads);
  }
  for (const VehicleIndex v : *vehicles) give(v, mission);
}

void Missions::follow(const SectionCommand& command) {
  const zone::SectionId section = *map_->circuit().find(command.section);
  if (command.closes)
    closed_.insert(std::ranges::lower_bound(closed_, section), section);
  else
    std::erase(closed_, section);
  closed_changed();
}

void Missions::write(JsonWriter& json, VehicleIndex vehicle, std::string_view waits_for) const {
  const Entry& entry = entries_[vehicle];
  const bool go = entry.mission.kind == Mission::Kind::go;
  json.begin_object().field("kind", go ? "go" : "circulate");
  const zone::Loop* loop = go || map_ == nullptr ? nullptr : loop_of(entry);
  json.key(go ? "to" : "loop");
  if (go)
    json.value(entry.mission.beyond.empty() ? entry.mission.name : entry.mission.beyond);
  else if (loop != nullptr)
    json.value(loop->name);
  else
    json.null();
  constexpr std::array<std::string_view, 3> terms{"driving", "arrived", "no route"};
  // At the station where two control areas meet, the vehicle has not arrived yet.
  const bool waits = entry.state == State::arrived && !entry.mission.beyond.empty();
  json.field("state", waits ? terms[0] : terms[static_cast<std::size_t>(entry.state)]).key("why");
  if (!entry.why.empty())
    json.value(entry.why);
  else if (waits)
    json.value("waits at " + entry.mission.name + " for the server of the other control area");
  else if (go && !waits_for.empty())
    json.value(std::string(waits_for) + " is stopped at " + entry.mission.name);
  else
    json.null();
  json.end_object();
}

std::vector<std::string> Missions::closed_names() const {
  std::vector<std::string> names;
  if (map_ != nullptr)
    for (const zone::SectionId section : closed_) names.push_back(map_->circuit().part(section).name);
  return names;
}

void Missions::fold(Digest& digest) const {
  for (const Entry& entry : entries_) {
    if (entry.mission == Mission{} && entry.state == State::driving) continue;
    digest.add(std::string_view{entry.mission.name});
    digest.add(static_cast<std::uint64_t>(entry.state));
  }
  for (const zone::SectionId section : closed_) digest.add(std::uint64_t{section});
}

}  // namespace cosiva::virtual_side
