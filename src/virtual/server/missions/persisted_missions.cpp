#include "cosiva/virtual/server/missions/persisted_missions.h"

#include <algorithm>
#include <string_view>
#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/virtual/server/missions/mission.h"

namespace cosiva::virtual_side {

bool PersistedMissions::worth_remembering() const {
  if (missions_.closed().all() != missions_.closed().configured() || !missions_left_.empty()) return true;
  for (VehicleIndex v = 0; v < registry_.size(); ++v)
    if (!(missions_.mission(v) == Mission{})) return true;
  return false;
}

void PersistedMissions::write(JsonWriter& json) const {
  const WaypointGraph* map = missions_.map();
  json.begin_object().field("zone", map == nullptr ? std::string_view{} : std::string_view{map->zone().name});
  json.key("closed").begin_array();
  for (const std::string& name : missions_.closed().names(map)) json.value(name);
  json.end_array().key("missions").begin_array();
  const auto write = [&json](const std::string& vehicle, const Mission& mission) {
    json.begin_object()
        .field("vehicle", vehicle)
        .field("kind", mission.kind == Mission::Kind::go ? "go" : "circulate")
        .field("name", mission.name);
    if (!mission.beyond.empty()) json.field("beyond", mission.beyond);
    json.end_object();
  };
  for (VehicleIndex v = 0; v < registry_.size(); ++v)
    if (!(missions_.mission(v) == Mission{})) write(registry_[v].name(), missions_.mission(v));
  for (const Persisted& one : missions_left_) write(one.vehicle, one.mission);
  json.end_array().end_object();
}

void PersistedMissions::restore(const JsonValue& memory) {
  const auto each = [&memory](std::string_view list, const auto& take) {
    const JsonValue* found = memory.find(list);
    if (found == nullptr || found->array() == nullptr) return;
    for (const JsonValue& one : *found->array()) take(one);
  };
  closed_.emplace(PersistedClosed{memory.text("zone").value_or(""), {}});
  each("closed", [&](const JsonValue& name) {
    if (name.text() != nullptr) closed_->sections.push_back(*name.text());
  });
  each("missions", [&](const JsonValue& one) {
    const auto vehicle = one.text("vehicle");
    if (!vehicle || vehicle->size() > mission_name_bytes_max || missions_left_.size() >= registry_.vehicles_max())
      return;
    const bool go = one.text("kind").value_or("") == "go";
    missions_left_.push_back({*vehicle,
                              {go ? Mission::Kind::go : Mission::Kind::circulate, one.text("name").value_or(""),
                               one.text("beyond").value_or("")}});
  });
  for (VehicleIndex v = 0; v < registry_.size(); ++v) registered(v);
  COSIVA_EXPECT(missions_left_.size() <= registry_.vehicles_max());
  if (missions_.map() == nullptr) return;
  if (auto closed = take_closed(missions_.map()))
    missions_.set_closed(std::move(*closed));
  else
    missions_.set_closed(missions_.closed().all());
}

void PersistedMissions::registered(VehicleIndex vehicle) {
  const auto found = std::ranges::find(missions_left_, registry_[vehicle].name(), &Persisted::vehicle);
  if (found == missions_left_.end()) return;
  if (missions_.map() == nullptr || is_known(*missions_.map(), found->mission))
    missions_.restore(vehicle, found->mission);
  missions_left_.erase(found);
}

void PersistedMissions::removed(VehicleIndex vehicle) {
  const Mission& mission = missions_.mission(vehicle);
  if (mission == Mission{} || missions_left_.size() >= registry_.vehicles_max()) return;
  missions_left_.push_back({registry_[vehicle].name(), mission});
}

std::optional<std::vector<zone::SectionId>> PersistedMissions::take_closed(const WaypointGraph* map) {
  if (map == nullptr || !closed_) return std::nullopt;
  const PersistedClosed was = *std::exchange(closed_, std::nullopt);
  if (was.zone != map->zone().name) return std::nullopt;
  std::vector<zone::SectionId> sections;
  for (const std::string& name : was.sections)
    if (const auto section = map->circuit().find(name)) sections.push_back(*section);
  return sections;
}

void PersistedMissions::archive(Archive& archive) { archive(missions_left_, closed_); }

}  // namespace cosiva::virtual_side
