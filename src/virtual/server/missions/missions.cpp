#include "cosiva/virtual/server/missions/missions.h"

#include <algorithm>
#include <array>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void Missions::set_map(const WaypointGraph* map, std::optional<std::vector<zone::SectionId>> closed) {
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
  closed_.configure(map_->zone().closed);
  for (VehicleIndex v = 0; v < entries_.size(); ++v) {
    Mission& mission = entries_[v].mission;
    if (is_known(*map_, mission)) continue;
    publisher_.log('w',
                   registry_[v].name() + ": this zone has no '" + mission.name + "'; it follows its default mission");
    mission = {};
  }
  if (closed) closed_.set(std::move(*closed));
  for_ever_ = router_->goes_on_for_ever(closed_.all());
}

void Missions::renew() {
  router_.emplace(map_->zone());
  if (map_->zone().closed == closed_.configured()) return;
  closed_.configure(map_->zone().closed);
  set_closed(closed_.all());
}

void Missions::set_closed(std::vector<zone::SectionId> sections) {
  closed_.set(std::move(sections));
  for_ever_ = router_->goes_on_for_ever(closed_.all());
  ++revision_;
}

void Missions::Entry::stop(const Error& error) {
  state = State::no_route;
  why = error.message;
  complete = true;
}

bool Missions::has_detour(VehicleIndex vehicle, zone::TrackPosition from, Sections around) const {
  const Entry& entry = entries_[vehicle];
  const auto closed = closed_.with(around);
  if (entry.mission.kind == Mission::Kind::go)
    return std::ranges::any_of(goals_of(*map_, entry.mission.name), [&](WaypointIndex goal) {
      return router_->plan(from, map_->waypoint(goal).position, closed).has_value();
    });
  if (const zone::Loop* loop = loop_of(*map_, entry.mission)) return router_->plan(from, *loop, closed).has_value();
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
  const zone::Loop* loop = entry.mission.kind == Mission::Kind::circulate ? loop_of(*map_, entry.mission) : nullptr;
  if (entry.mission.kind == Mission::Kind::circulate && loop == nullptr) {
    std::vector<zone::SectionId> sections;
    for (const zone::TrackPosition& start : starts) sections.push_back(start.section);
    const zone::SectionId best = sections.size() == 1
                                     ? zone::no_section
                                     : entry.roaming.least_recent(sections, {closed_, entry.avoided, for_ever_});
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
      consider(router_->plan(start, *loop, closed_.with(entry.avoided)), no_waypoint);
      continue;
    }
    for (const WaypointIndex goal : goals_of(*map_, entry.mission.name))
      consider(router_->plan(start, map_->waypoint(goal).position, closed_.with(entry.avoided)), goal);
  }
  if (!best) {
    entry.stop(error.value_or(Error{"route.none", "the zone has no '" + entry.mission.name + "' any more", ""}));
    publisher_.log('w', registry_[vehicle].name() + ": no route: " + entry.why);
    return std::nullopt;
  }
  entry.complete = entry.mission.kind == Mission::Kind::go;
  return std::move(best->sections);
}

std::vector<zone::SectionId> Missions::more(VehicleIndex vehicle, zone::SectionId last) {
  Entry& entry = entries_[vehicle];
  if (entry.complete) return {};
  COSIVA_EXPECT(entry.state != State::no_route);
  const auto next = map_->circuit().next(last);
  const zone::Loop* loop = loop_of(*map_, entry.mission);
  if (loop == nullptr) {
    const zone::SectionId branch = entry.roaming.least_recent(next, {closed_, entry.avoided, for_ever_});
    if (branch == zone::no_section) {
      const std::string& name = map_->circuit().part(last).name;
      entry.stop({"route.none",
                  next.empty() ? "the path ends with '" + name + "'" : "every section after '" + name + "' is closed",
                  name});
      return {};
    }
    if (next.size() > 1) entry.roaming.take(branch);
    return {branch};
  }
  auto lap = router_->plan({last, map_->circuit().section(last).length_m()}, *loop, closed_.with(entry.avoided));
  const bool alone =
      lap && lap->sections.size() < 2 && std::ranges::find(next, last) != next.end() && !closed_.contains(last);
  if (alone) return {last};
  if (!lap || lap->sections.size() < 2) {
    entry.stop(lap ? Error{"route.none", "the loop ends here", ""} : lap.error());
    return {};
  }
  return {lap->sections.begin() + 1, lap->sections.end()};
}

bool Missions::is_at(VehicleIndex vehicle, Point2 p, double off_m) const {
  const Entry& entry = entries_[vehicle];
  if (entry.mission.kind != Mission::Kind::go) return false;
  if (entry.state == State::arrived) return true;
  const auto all = goals_of(*map_, entry.mission.name);
  return std::ranges::any_of(all, [&](WaypointIndex i) { return distance(map_->point(i), p) <= off_m; });
}

bool Missions::is_stopped_at(VehicleIndex vehicle, Point2 p, double off_m) {
  if (!is_at(vehicle, p, off_m)) return false;
  Entry& entry = entries_[vehicle];
  if (entry.state == State::arrived) return true;
  entry.state = State::arrived;
  entry.why.clear();
  entry.complete = true;
  publisher_.log('i', registry_[vehicle].name() + ": arrived at " + entry.mission.name +
                          (entry.mission.beyond.empty() ? "" : ", continuing to " + entry.mission.beyond));
  return true;
}

void Missions::set_no_route(VehicleIndex vehicle, const std::optional<std::string>& why) {
  Entry& entry = entries_[vehicle];
  if (!why) {
    if (entry.state != State::no_route) return;
    entry.state = State::driving;
    entry.why.clear();
    entry.complete = false;
  } else if (entry.state != State::no_route || entry.why != *why) {
    entry.stop({"route.none", *why, ""});
    publisher_.log('w', registry_[vehicle].name() + ": no route: " + entry.why);
  }
}

void Missions::give(VehicleIndex vehicle, Mission mission) {
  Entry& entry = entries_[vehicle];
  entry.mission = std::move(mission);
  entry.state = State::driving;
  entry.why.clear();
  entry.avoided.clear();
  ++entry.revision;
  registry_[vehicle].settings.on_mission();
}

void Missions::restore(VehicleIndex vehicle, Mission mission) {
  entries_[vehicle].mission = std::move(mission);
  ++entries_[vehicle].revision;
}

void Missions::write(JsonWriter& json, VehicleIndex vehicle, std::string_view waits_for) const {
  const Entry& entry = entries_[vehicle];
  const bool go = entry.mission.kind == Mission::Kind::go;
  json.begin_object().field("kind", go ? "go" : "circulate");
  const zone::Loop* loop = go || map_ == nullptr ? nullptr : loop_of(*map_, entry.mission);
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

void Missions::fold(Digest& digest) const {
  for (const Entry& entry : entries_) {
    if (entry.mission == Mission{} && entry.state == State::driving) continue;
    digest.add(std::string_view{entry.mission.name});
    digest.add(static_cast<std::uint64_t>(entry.state));
  }
  for (const zone::SectionId section : closed_.all()) digest.add(std::uint64_t{section});
}

void Missions::archive(Archive& archive) { archive(entries_, closed_, for_ever_, revision_); }

}  // namespace cosiva::virtual_side
