#include "cosiva/virtual/server/areas/control_areas.h"

#include <algorithm>
#include <limits>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/vda5050/codec.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

std::string cut(std::string_view text) { return std::string(text.substr(0, 80)); }

std::optional<zone::TrackPosition> position_of(const zone::TrafficZone& zone, std::string_view name) {
  if (const zone::Station* station = zone.find_station(name)) return station->position;
  const auto waypoint = std::ranges::find(zone.waypoints, name, &zone::Waypoint::id);
  return waypoint == zone.waypoints.end() ? std::nullopt : std::optional{waypoint->position};
}

std::optional<wire::AgvPosition> position_in(std::string_view topic, const std::string& payload) {
  if (topic == "visualization") {
    const auto message = wire::vda5050::decode_visualization(payload);
    return message ? message->position : std::nullopt;
  }
  const auto message = wire::vda5050::decode_state(payload);
  return message ? message->position : std::nullopt;
}

}  // namespace

bool ControlAreas::owns(const wire::VehicleId& id) const {
  if (!several()) return true;
  const auto found = vehicles_.find(wire::to_string(id));
  return found != vehicles_.end() && found->second.owner && found->second.owner->area == own_;
}

ControlAreas::Vehicle* ControlAreas::vehicle(const wire::VehicleId& id) {
  std::string name = wire::to_string(id);
  if (const auto found = vehicles_.find(name); found != vehicles_.end()) return &found->second;
  if (vehicles_.size() >= vehicles_max) return nullptr;
  Vehicle& made = vehicles_[std::move(name)];
  made.id = id;
  COSIVA_EXPECT(vehicles_.size() <= vehicles_max);
  return &made;
}

void ControlAreas::overhear(Vehicle& vehicle, std::string_view topic, const wire::Input& input) {
  if (topic == "connection") vehicle.connection = input;
  if (topic == "factsheet") vehicle.factsheet = input;
  if (vehicle.owner || input.flag || (topic != "visualization" && topic != "state")) return;
  const auto position = position_in(topic, input.payload);
  const bool known = position && position->position_initialized;
  if (!known) return;
  if (!vehicle.pose) vehicle.pose_since = input.at;
  vehicle.pose = position->pose;
  vehicle.pose_at = input.at;
}

void ControlAreas::link_up() {
  for (auto& [name, vehicle] : vehicles_) {
    vehicle.owner_received = false;
    vehicle.pose.reset();
    vehicle.claimed_at.reset();
  }
}

Result<void> ControlAreas::on_area(wire::AreaTopic topic, const wire::Input& input) {
  if (topic.area == own_) return {};
  auto area = areas_.find(topic.area);
  if (area == areas_.end()) {
    if (areas_.size() >= areas_max) return {};
    area = areas_.emplace(std::string(topic.area), ControlArea{}).first;
    COSIVA_EXPECT(areas_.size() <= areas_max && !areas_.contains(own_));
  }
  if (topic.rest == "server/connection") {
    constexpr std::size_t bytes_max = 4096;
    const auto json = JsonValue::parse(input.payload, bytes_max);
    area->second.online = json && json->text("connectionState") == "ONLINE";
    return {};
  }
  constexpr std::string_view zone = "zone/";
  // As for every retained topic, an empty message clears the topic at the broker and is no zone.
  if (!topic.rest.starts_with(zone) || input.payload.empty()) return {};
  const auto configuration =
      zone::from_payload(std::string(topic.rest.substr(zone.size())), input.source, input.payload);
  // The broker sends a retained zone again after each reconnection.
  if (area->second.rtm && area->second.rtm->configuration() == configuration) return {};
  auto rtm = zone::Rtm::initialise(configuration);
  if (!rtm) return tl::unexpected(std::move(rtm.error()));
  area->second.rtm = std::make_shared<const zone::Rtm>(std::move(*rtm));
  return {};
}

bool ControlAreas::is_there(std::string_view area) const {
  const auto found = areas_.find(area);
  return found != areas_.end() && found->second.online && found->second.rtm;
}

bool ControlAreas::has_map(std::string_view name) const {
  return std::ranges::any_of(areas_,
                             [&](const auto& area) { return area.second.rtm && area.second.rtm->zone().name == name; });
}

Result<Mission> ControlAreas::route_to(std::string_view to, const zone::TrafficZone& zone,
                                       const Missions& missions) const {
  const std::string name{to.substr(0, to.find('/'))};
  const std::string goal{to.substr(std::min(to.size(), name.size() + 1))};
  if (name == own_) {
    if (is_known(*missions.map(), {Mission::Kind::go, goal, {}})) return Mission{Mission::Kind::go, goal, {}};
    return fail("mission.to", "there is no station or waypoint '" + cut(goal) + "' in this control area", "to");
  }
  const auto area = areas_.find(name);
  if (area == areas_.end()) {
    std::string known;
    for (const auto& [other, entry] : areas_) known += (known.empty() ? "; there are " : ", ") + other;
    return fail("mission.area", "no control area '" + cut(name) + "' is known" + known, "to");
  }
  if (!area->second.online)
    return fail("mission.area",
                "the server of control area '" + cut(name) + "' does not respond; start it, then try again", "to");
  if (!area->second.rtm)
    return fail("mission.area", "control area '" + cut(name) + "' has not published its zone; try again", "to");
  const zone::TrafficZone& there = area->second.rtm->zone();
  const auto end = position_of(there, goal);
  if (!end)
    return fail("mission.to", "control area '" + cut(name) + "' has no station or waypoint '" + cut(goal) + "'", "to");

  const zone::Router router{there};
  const zone::Station* best = nullptr;
  double best_m = std::numeric_limits<double>::infinity();
  for (const zone::Station& station : zone.stations) {
    if (!is_known(*missions.map(), {Mission::Kind::go, station.name, {}})) continue;
    const auto entry_point = zone::snap_to_path(there.circuit, zone.circuit.pose_at(station.position));
    if (!entry_point || entry_point->distance_m >= best_m || !router.plan(entry_point->position, *end)) continue;
    best = &station;
    best_m = entry_point->distance_m;
  }
  if (best == nullptr) {
    return fail("mission.to",
                "no station of this control area is on a section of control area '" + cut(name) +
                    "' with a route to '" + cut(goal) + "'; define one where the two control areas meet",
                "to");
  }
  return Mission{Mission::Kind::go, best->name, std::string(to)};
}

void ControlAreas::write(JsonWriter& json) const {
  json.begin_object().field("name", own_).key("others").begin_array();
  for (const auto& [name, area] : areas_)
    json.begin_object().field("name", name).field("online", area.online).end_object();
  json.end_array().end_object();
}

void ControlAreas::fold(Digest& digest) const {
  for (const auto& [name, vehicle] : vehicles_) {
    digest.add(std::string_view{name});
    if (vehicle.owner) digest.add(std::string_view{vehicle.owner->area});
  }
}

void ControlAreas::archive(Archive& archive) { archive(areas_, vehicles_); }

}  // namespace cosiva::virtual_side
