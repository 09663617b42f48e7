// Requests to Missions, and the state of Missions that persists over a crash of the server.
#include <algorithm>
#include <utility>

#include "cosiva/base/likeness.h"
#include "cosiva/virtual/server/orders/missions.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::size_t name_bytes_max = 200;
constexpr std::size_t likened_max = 5000;  ///< with more names than this, no similar names are listed
constexpr std::size_t shown_max = 3;

std::string cut(std::string_view text) { return std::string(text.substr(0, 80)); }

/// "; the nearest are dock, deck and duck", or the reason for an empty list.
std::string nearest_names(std::string_view requested, const std::vector<std::string_view>& names,
                          std::string_view of_what) {
  if (names.empty()) return "; this zone has no " + std::string(of_what);
  if (names.size() > likened_max) return "";
  std::vector<std::pair<std::size_t, std::string_view>> ranked;
  ranked.reserve(names.size());
  for (const std::string_view name : names)
    ranked.emplace_back(edit_distance(requested.substr(0, 64), name.substr(0, 64)), name);
  std::ranges::stable_sort(ranked, {}, &std::pair<std::size_t, std::string_view>::first);
  std::string text = names.size() > shown_max ? "; the nearest " : "; there ";
  if (ranked.size() > shown_max) ranked.resize(shown_max);
  text += ranked.size() == 1 ? "is " : "are ";
  for (std::size_t i = 0; i < ranked.size(); ++i) {
    if (i > 0) text += i + 1 == ranked.size() ? " and " : ", ";
    text += ranked[i].second;
  }
  return text;
}

}  // namespace

Result<void> Missions::check_map() const {
  if (map_ != nullptr) return {};
  return fail("mission.zone", "there is no zone yet; wait until the physical side has sent it, then try again");
}

Result<std::vector<VehicleIndex>> Missions::addressed(const std::vector<std::string>& names) const {
  std::vector<VehicleIndex> vehicles;
  for (const std::string& name : names) {
    if (name == "*") {
      for (VehicleIndex v = 0; v < registry_.size(); ++v)
        if (!registry_[v].retired) vehicles.push_back(v);
      continue;
    }
    const auto vehicle = registry_.find(name);
    if (!vehicle || registry_[*vehicle].retired) {
      return fail("mission.vehicle",
                  name.empty() ? std::string("state which vehicle, as manufacturer/serial number, or * for all")
                               : "no vehicle '" + cut(name) + "' is known; name it as manufacturer/serial number",
                  "vehicle");
    }
    vehicles.push_back(*vehicle);
  }
  if (vehicles.empty()) return fail("mission.vehicle", "no vehicle is known yet", "vehicle");
  return vehicles;
}

Result<void> Missions::check(const MissionCommand& command) const {
  if (auto map = check_map(); !map) return map;
  if (auto vehicles = addressed(command.vehicle_names); !vehicles) return tl::unexpected(vehicles.error());
  const zone::TrafficZone& zone = map_->zone();
  std::vector<std::string_view> names;
  if (!command.goes) {
    const std::string& loop = command.name;
    if (loop.empty() || zone.find_loop(loop) != nullptr) return {};
    for (const zone::Loop& known : zone.loops) names.push_back(known.name);
    return fail("mission.loop", "there is no loop '" + cut(loop) + "'" + nearest_names(loop, names, "loops"), "loop");
  }
  const std::string& to = command.name;
  if (to.empty() || to.size() > name_bytes_max)
    return fail("mission.to", "state the destination, as the name of a station or waypoint", "to");
  if (!goals(to).empty()) return {};
  if (abroad_ && to.find('/') != std::string::npos) {
    const auto leads = abroad_(to);
    return leads ? Result<void>{} : tl::unexpected(leads.error());
  }
  if (zone.find_station(to) != nullptr)
    return fail("mission.to",
                "no section of this zone has a stopping point at '" + cut(to) + "'; move it onto a section", "to");
  for (const zone::Station& station : zone.stations) names.push_back(station.name);
  if (names.empty()) {
    for (const zone::Waypoint& waypoint : zone.waypoints)
      if (names.empty() || names.back() != waypoint.id) names.push_back(waypoint.id);
  }
  return fail("mission.to", "there is no station or waypoint '" + cut(to) + "'" + nearest_names(to, names, "stations"),
              "to");
}

Result<void> Missions::check(const SectionCommand& command) const {
  if (auto map = check_map(); !map) return map;
  const std::string& name = command.section;
  if (name.empty())
    return fail("mission.section", std::string("state which section to ") + (command.closes ? "close" : "open"),
                "section");
  const zone::Circuit& circuit = map_->circuit();
  const auto section = circuit.find(name);
  if (!section) {
    std::vector<std::string_view> names;
    for (zone::SectionId id = 0; id < circuit.size(); ++id) names.push_back(circuit.part(id).name);
    return fail("mission.section", "there is no section '" + cut(name) + "'" + nearest_names(name, names, "sections"),
                "section");
  }
  if (is_closed(*section) == command.closes)
    return fail("mission.section", "'" + cut(name) + "' is " + (command.closes ? "closed" : "open") + " already",
                "section");
  return {};
}

bool Missions::worth_remembering() const {
  return closed_ != configured_ || !persisted_.empty() ||
         std::ranges::any_of(entries_, [](const Entry& entry) { return !(entry.mission == Mission{}); });
}

void Missions::write_persisted(JsonWriter& json) const {
  json.begin_object().field("zone", map_ == nullptr ? std::string_view{} : std::string_view{map_->zone().name});
  json.key("closed").begin_array();
  for (const std::string& name : closed_names()) json.value(name);
  json.end_array().key("missions").begin_array();
  const auto write = [&json](const std::string& vehicle, const Mission& mission) {
    json.begin_object()
        .field("vehicle", vehicle)
        .field("kind", mission.kind == Mission::Kind::go ? "go" : "circulate")
        .field("name", mission.name);
    if (!mission.beyond.empty()) json.field("beyond", mission.beyond);
    json.end_object();
  };
  for (VehicleIndex v = 0; v < entries_.size(); ++v)
    if (!(entries_[v].mission == Mission{})) write(registry_[v].name, entries_[v].mission);
  for (const Persisted& one : persisted_) write(one.vehicle, one.mission);
  json.end_array().end_object();
}

void Missions::restore(const JsonValue& memory) {
  const auto each = [&memory](std::string_view list, const auto& take) {
    const JsonValue* found = memory.find(list);
    if (found == nullptr || found->array() == nullptr) return;
    for (const JsonValue& one : *found->array()) take(one);
  };
  persisted_closed_.emplace(PersistedClosed{memory.text("zone").value_or(""), {}});
  each("closed", [&](const JsonValue& name) {
    if (name.text() != nullptr) persisted_closed_->sections.push_back(*name.text());
  });
  each("missions", [&](const JsonValue& one) {
    const auto vehicle = one.text("vehicle");
    if (!vehicle || vehicle->size() > name_bytes_max || persisted_.size() >= Registry::vehicles_max) return;
    const bool go = one.text("kind").value_or("") == "go";
    persisted_.push_back({*vehicle,
                          {go ? Mission::Kind::go : Mission::Kind::circulate, one.text("name").value_or(""),
                           one.text("beyond").value_or("")}});
  });
  for (VehicleIndex v = 0; v < entries_.size(); ++v) registered(v);
  if (map_ == nullptr) return;
  restore_for_zone();
  closed_changed();
}

void Missions::registered(VehicleIndex vehicle) {
  const auto found = std::ranges::find(persisted_, registry_[vehicle].name, &Persisted::vehicle);
  if (found == persisted_.end()) return;
  if (map_ == nullptr || known(found->mission)) {
    entries_[vehicle].mission = found->mission;
    ++entries_[vehicle].revision;
  }
  persisted_.erase(found);
}

void Missions::restore_for_zone() {
  if (!persisted_closed_) return;
  const PersistedClosed was = *std::exchange(persisted_closed_, std::nullopt);
  if (was.zone != map_->zone().name) return;
  closed_.clear();
  for (const std::string& name : was.sections)
    if (const auto section = map_->circuit().find(name)) closed_.push_back(*section);
  std::ranges::sort(closed_);
  closed_.erase(std::unique(closed_.begin(), closed_.end()), closed_.end());
}

}  // namespace cosiva::virtual_side
