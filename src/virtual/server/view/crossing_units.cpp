#include "cosiva/virtual/server/view/crossing_units.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

using Vehicles = std::vector<wire::CrossingStatus::Vehicle>;

std::string names_of(const Vehicles& vehicles) {
  std::string names;
  for (const auto& one : vehicles) names.append(names.empty() ? "" : ", ").append(one.vehicle.serial_number);
  return names;
}

std::string whole_seconds(SimDuration duration) {
  return std::to_string(static_cast<std::int64_t>(std::floor(to_seconds(duration)))) + " s";
}

void write_vehicles(JsonWriter& json, std::string_view name, const Vehicles& vehicles, SimDuration since) {
  json.key(name).begin_array();
  for (const auto& one : vehicles)
    json.begin_object()
        .field("id", wire::to_string(one.vehicle))
        .field("age_ms", static_cast<double>(one.age_ms) + std::nearbyint(to_milliseconds(since)))
        .end_object();
  json.end_array();
}

}  // namespace

bool CrossingUnits::handles(std::string_view topic) { return topic.starts_with(wire::unit_topic_prefix); }

std::vector<std::string> CrossingUnits::subscriptions() { return {wire::topics_below(wire::unit_topic_prefix, 2)}; }

Result<void> CrossingUnits::on_message(SimTime now, const wire::Input& input) {
  const auto sender = wire::parse_own_topic(wire::unit_topic_prefix, input.source);
  auto status = wire::crossing_status_from_json(input.payload);
  if (!status) return tl::unexpected(status.error());
  const bool own_name = sender && *sender == status->unit && sender->manufacturer == wire::unit_manufacturer &&
                        sender->serial_number == status->crossing;
  if (!own_name || input.flag) return fail("unit.sender", "a crossing's status of another sender than its unit");
  if (!status->online) {
    units_.erase(status->crossing);
    return {};
  }
  const auto known = units_.find(status->crossing);
  if (known == units_.end()) {
    if (units_.size() >= units_max) return fail("unit.count", "more units than this server observes");
    const std::string crossing = status->crossing;
    units_.emplace(crossing, Unit{std::move(*status), now, now});
    COSIVA_EXPECT(units_.size() <= units_max);
    return {};
  }
  Unit& unit = known->second;
  const auto first = [](const Vehicles& vehicles) {
    return vehicles.empty() ? wire::VehicleId{} : vehicles[0].vehicle;
  };
  if (first(unit.last.holders) != first(status->holders)) unit.held_since = now;
  unit.last = std::move(*status);
  unit.at = now;
  return {};
}

std::string CrossingUnits::trouble(const Unit& unit, SimTime now) {
  if (unresponsive(unit, now)) return "no status for " + whole_seconds(now - unit.at);
  for (const auto& holder : unit.last.holders) {
    const SimDuration age = std::chrono::milliseconds{holder.age_ms};
    if (age >= evidence_age_max)
      return "it keeps the crossing occupied for " + holder.vehicle.serial_number + ", whose last message is " +
             whole_seconds(age) + " old" +
             (unit.last.waiting.empty() ? "" : "; waiting: " + names_of(unit.last.waiting));
  }
  if (!unit.last.holders.empty() && now - unit.held_since >= held_for_max)
    return "it has reported " + unit.last.holders.front().vehicle.serial_number + " in the crossing for " +
           whole_seconds(now - unit.held_since) +
           (unit.last.waiting.empty() ? "" : "; waiting: " + names_of(unit.last.waiting));
  return {};
}

void CrossingUnits::write(JsonWriter& json, SimTime now, std::string_view map_id) const {
  json.begin_array();
  for (const auto& [crossing, unit] : units_) {
    if (unit.last.map_id != map_id) continue;
    const SimDuration since = now - unit.at;
    json.begin_object().field("crossing", crossing).field("x", unit.last.centre.x_m).field("y", unit.last.centre.y_m);
    json.field("state", unresponsive(unit, now) ? "unresponsive" : "online");
    json.field("age_ms", std::nearbyint(to_milliseconds(since)));
    write_vehicles(json, "holders", unit.last.holders, since);
    write_vehicles(json, "waiting", unit.last.waiting, since);
    const std::string text = trouble(unit, now);
    json.key("trouble");
    if (text.empty())
      json.null();
    else
      json.value(text);
    json.end_object();
  }
  json.end_array();
}

void CrossingUnits::fold(Digest& digest, SimTime now) const {
  for (const auto& [crossing, unit] : units_) {
    digest.add(std::string_view{crossing});
    digest.add(std::string_view{names_of(unit.last.holders)});
    digest.add(std::uint64_t{trouble(unit, now).empty() ? 0U : 1U});
  }
}

}  // namespace cosiva::virtual_side
