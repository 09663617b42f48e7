#include "cosiva/app/remote/zone_switch.h"

#include "cosiva/app/cli/console.h"
#include "cosiva/base/json_value.h"

namespace cosiva::app {
namespace {

constexpr std::size_t snapshot_bytes_max = std::size_t{1} << 28U;

std::string serial_of(const std::string& id) { return id.substr(id.find('/') + 1); }

}  // namespace

std::optional<SwitchedZone> switched_in(std::string_view snapshot_json) {
  const auto snapshot = JsonValue::parse(snapshot_json, snapshot_bytes_max);
  const JsonValue* zone = snapshot ? snapshot->find("zone") : nullptr;
  const JsonValue* last = zone == nullptr ? nullptr : zone->find("switched");
  if (last == nullptr || last->object() == nullptr) return std::nullopt;
  SwitchedZone switched;
  switched.name = zone->text("name").value_or("");
  switched.snapped = static_cast<std::uint64_t>(last->number("snapped").value_or(0.0));
  switched.first_moving_ms = last->number("first_moving_ms");
  if (const JsonValue* off_route = last->find("offRoute"); off_route != nullptr && off_route->array() != nullptr)
    for (const JsonValue& vehicle : *off_route->array())
      if (vehicle.text() != nullptr) switched.off_route.push_back(*vehicle.text());
  if (const JsonValue* aivs = snapshot->find("aivs"); aivs != nullptr && aivs->array() != nullptr)
    switched.vehicles = aivs->array()->size();
  return switched;
}

std::string to_text(const SwitchedZone& switched) {
  std::string text =
      std::to_string(switched.snapped) + " snapped, " + std::to_string(switched.off_route.size()) + " off-route";
  for (std::size_t i = 0; i < switched.off_route.size(); ++i)
    text += (i == 0 ? ": " : ", ") + serial_of(switched.off_route[i]);
  if (switched.first_moving_ms)
    return text + "; the first moved after " + decimals(*switched.first_moving_ms, 0) + " ms";
  if (switched.vehicles == 0) return text + "; there are no vehicles";
  return text +
         (switched.off_route.size() >= switched.vehicles ? "; no vehicle can continue" : "; no vehicle has moved yet");
}

Error refusal_in(std::string_view body, unsigned status) {
  const auto json = JsonValue::parse(body);
  const JsonValue* error = json ? json->find("error") : nullptr;
  const auto message = error == nullptr ? std::nullopt : error->text("message");
  if (!message) return {"http.status", "the platform responded with status " + std::to_string(status), {}};
  return {error->text("code").value_or(""), *message, {}};
}

}  // namespace cosiva::app
