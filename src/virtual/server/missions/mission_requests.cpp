#include "cosiva/virtual/server/missions/mission_requests.h"

#include <algorithm>
#include <string>

#include "cosiva/base/expect.h"
#include "cosiva/base/likeness.h"
#include "cosiva/virtual/server/missions/mission.h"

namespace cosiva::virtual_side {
namespace {

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

Result<void> MissionRequests::check_map() const {
  if (missions_.map() != nullptr) return {};
  return fail("mission.zone", "there is no zone yet; wait until the physical side has sent it, then try again");
}

Result<std::vector<VehicleIndex>> MissionRequests::addressed(const std::vector<std::string>& names) const {
  std::vector<VehicleIndex> vehicles;
  for (const std::string& name : names) {
    if (name == "*") {
      for (VehicleIndex v = 0; v < registry_.size(); ++v)
        if (!registry_[v].retired() && !registry_[v].settings.excluded()) vehicles.push_back(v);
      continue;
    }
    const auto vehicle = registry_.find(name);
    if (!vehicle || registry_[*vehicle].retired()) {
      return fail("mission.vehicle",
                  name.empty() ? std::string("state which vehicle, as manufacturer/serial number, or * for all")
                               : "no vehicle '" + cut(name) + "' is known; name it as manufacturer/serial number",
                  "vehicle");
    }
    if (registry_[*vehicle].settings.excluded())
      return fail("mission.excluded", "'" + cut(name) + "' is excluded; include it first", "vehicle");
    vehicles.push_back(*vehicle);
  }
  if (vehicles.empty()) return fail("mission.vehicle", "no vehicle is known yet", "vehicle");
  return vehicles;
}

Result<void> MissionRequests::check(const MissionCommand& command) const {
  if (auto map = check_map(); !map) return map;
  if (auto vehicles = addressed(command.vehicle_names); !vehicles) return tl::unexpected(vehicles.error());
  const zone::TrafficZone& zone = missions_.map()->zone();
  std::vector<std::string_view> names;
  if (!command.goes) {
    const std::string& loop = command.name;
    if (loop.empty() || zone.find_loop(loop) != nullptr) return {};
    for (const zone::Loop& known : zone.loops) names.push_back(known.name);
    return fail("mission.loop", "there is no loop '" + cut(loop) + "'" + nearest_names(loop, names, "loops"), "loop");
  }
  const std::string& to = command.name;
  if (to.empty() || to.size() > mission_name_bytes_max)
    return fail("mission.to", "state the destination, as the name of a station or waypoint", "to");
  if (!goals_of(*missions_.map(), to).empty()) return {};
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

Result<void> MissionRequests::check(const SectionCommand& command) const {
  if (auto map = check_map(); !map) return map;
  const std::string& name = command.section;
  if (name.empty())
    return fail("mission.section", std::string("state which section to ") + (command.closes ? "close" : "open"),
                "section");
  const zone::Circuit& circuit = missions_.map()->circuit();
  const auto section = circuit.find(name);
  if (!section) {
    std::vector<std::string_view> names;
    for (zone::SectionId id = 0; id < circuit.size(); ++id) names.push_back(circuit.part(id).name);
    return fail("mission.section", "there is no section '" + cut(name) + "'" + nearest_names(name, names, "sections"),
                "section");
  }
  if (missions_.closed().contains(*section) == command.closes)
    return fail("mission.section", "'" + cut(name) + "' is " + (command.closes ? "closed" : "open") + " already",
                "section");
  return {};
}

void MissionRequests::follow(const MissionCommand& command) {
  const auto vehicles = addressed(command.vehicle_names);
  COSIVA_EXPECT(vehicles.has_value());
  Mission mission{command.goes ? Mission::Kind::go : Mission::Kind::circulate, command.name};
  if (command.goes && goals_of(*missions_.map(), command.name).empty() && abroad_) {
    auto leads = abroad_(command.name);
    if (!leads) return publisher_.log('w', "command refused: " + to_string(leads.error()));
    mission = std::move(*leads);
  }
  for (const VehicleIndex v : *vehicles) missions_.give(v, mission);
}

void MissionRequests::follow(const SectionCommand& command) {
  const auto section = missions_.map()->circuit().find(command.section);
  COSIVA_EXPECT(section.has_value());
  std::vector<zone::SectionId> closed = missions_.closed().all();
  if (command.closes)
    closed.push_back(*section);
  else
    std::erase(closed, *section);
  missions_.set_closed(std::move(closed));
}

}  // namespace cosiva::virtual_side
