#include "cosiva/physical/roadside/crossing_unit.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/wire/in_process/received_intents.h"
#include "cosiva/wire/own/v2x_port.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::physical {
namespace {

auto key_of(const wire::VehicleId& id) { return std::tie(id.manufacturer, id.serial_number); }

bool newer(std::uint32_t a, std::uint32_t b) { return static_cast<std::int32_t>(a - b) > 0; }

bool same_vehicles(const std::vector<wire::CrossingStatus::Vehicle>& a,
                   const std::vector<wire::CrossingStatus::Vehicle>& b) {
  return std::ranges::equal(a, b, {}, &wire::CrossingStatus::Vehicle::vehicle, &wire::CrossingStatus::Vehicle::vehicle);
}

}  // namespace

std::string to_json(const CrossingUnitOptions& options) {
  COSIVA_EXPECT(options.rtm != nullptr);
  JsonWriter json;
  json.begin_object().field("crossing", options.crossing).field("direct", options.direct);
  json.field("emulated", options.emulated).field("off", options.off);
  zone::write_json(json.key("zone"), options.rtm->configuration());
  return json.end_object().take();
}

Result<CrossingUnitOptions> crossing_unit_options_from_json(std::string_view text) {
  const auto json = JsonValue::parse(text);
  if (!json) return tl::unexpected(json.error());
  const JsonValue* const zone = json->find("zone");
  const auto crossing = json->text("crossing");
  if (zone == nullptr || !crossing) return fail("unit.options", "a unit needs its crossing and its zone");
  auto configuration = zone::zone_configuration_from_json(*zone);
  if (!configuration) return tl::unexpected(configuration.error());
  auto rtm = zone::Rtm::initialise(std::move(*configuration));
  if (!rtm) return tl::unexpected(rtm.error());
  const auto flag = [&](const char* name) { return json->flag(name).value_or(false); };
  return CrossingUnitOptions{std::make_shared<const zone::Rtm>(std::move(*rtm)), *crossing, flag("direct"),
                             flag("emulated"), flag("off")};
}

/// What the newest messages of a vehicle state about the crossing.
struct CrossingUnit::Presence {
  bool holds{};
  bool awaits{};
  SimDuration age{};
  /// Vehicles with a claim in its order, then the others by their announced arrival.
  std::uint32_t stamp{std::numeric_limits<std::uint32_t>::max()};
  double arrival_s{};
};

Result<std::unique_ptr<CrossingUnit>> CrossingUnit::make(CrossingUnitOptions options) {
  COSIVA_EXPECT(options.rtm != nullptr);
  const zone::TrafficZone& zone = options.rtm->zone();
  const auto known = std::ranges::find(zone.crossings, options.crossing, &zone::Crossing::name);
  if (known == zone.crossings.end() || !wire::valid_serial_number(options.crossing)) {
    std::string names;
    for (const zone::Crossing& crossing : zone.crossings) names.append(names.empty() ? "" : ", ").append(crossing.name);
    return fail("unit.crossing",
                "the zone " + zone.name + " has no crossing of this name" +
                    (names.empty() ? ", nor any other" : "; it has " + names),
                options.crossing);
  }
  std::unique_ptr<CrossingUnit> unit{new CrossingUnit{std::move(options)}};
  wire::CrossingStatus& status = unit->status_;
  status.map_id = zone.name;
  status.crossing = known->name;
  status.unit = {std::string(wire::unit_manufacturer), known->name};
  status.centre = known->centre;
  return unit;
}

std::vector<std::string> CrossingUnit::subscriptions() const {
  const std::string of_cell = wire::v2x_topic(options_.rtm->zone().name, {}, status_.unit);
  const std::size_t map_end = of_cell.find('/', wire::v2x_topic_prefix.size());
  std::vector<std::string> filters{of_cell.substr(0, map_end) + "/#"};
  if (options_.emulated) filters.emplace_back(wire::plant_unit_topic);
  return filters;
}

CrossingUnit::Vehicle* CrossingUnit::vehicle_of(const wire::VehicleId& sender) {
  const auto at =
      std::ranges::lower_bound(vehicles_, key_of(sender), {}, [](const Vehicle& v) { return key_of(v.id); });
  if (at != vehicles_.end() && at->id == sender) return &*at;
  if (vehicles_.size() >= vehicles_max) return nullptr;
  Vehicle& added = *vehicles_.insert(at, Vehicle{});
  added.id = sender;
  COSIVA_EXPECT(vehicles_.size() <= vehicles_max);
  return &added;
}

void CrossingUnit::on_intent(SimTime now, const wire::VehicleId& sender, const wire::Input& input) {
  auto intent = wire::received_intent(input);
  Vehicle* const vehicle =
      intent && (*intent)->vehicle == sender && (*intent)->map_id == status_.map_id ? vehicle_of(sender) : nullptr;
  if (vehicle == nullptr) {
    ++counters_.refused;
    return;
  }
  // The same message may arrive by broker and direct link, or late; a restarted vehicle may begin anywhere.
  const bool current = vehicle->intent && now - vehicle->intent_at < fresh;
  if (current && !newer((*intent)->header_id, vehicle->intent->header_id)) return;
  vehicle->intent = std::move(*intent);
  vehicle->intent_at = now;
}

void CrossingUnit::on_claims(SimTime now, const wire::VehicleId& sender, const wire::Input& input,
                             wire::Effects& effects) {
  auto claims = wire::received_claims(input.payload);
  Vehicle* const vehicle =
      claims && (*claims)->vehicle == sender && (*claims)->map_id == status_.map_id ? vehicle_of(sender) : nullptr;
  if (vehicle == nullptr) {
    ++counters_.refused;
    return;
  }
  const bool current = vehicle->claims && now - vehicle->claims_at < fresh;
  if (current && !newer((*claims)->header_id, vehicle->claims->header_id)) return;
  vehicle->claims = std::move(*claims);
  vehicle->claims_at = now;
  // Each message once, so that units in reach of each other do not repeat without end.
  if (distance(vehicle->claims->position, status_.centre) > repeats_within_m) return;
  ++counters_.repeated;
  effects.emplace_back(wire::SendBytes{input.source, input.payload});
}

CrossingUnit::Presence CrossingUnit::presence_of(const Vehicle& vehicle, SimTime now) const {
  Presence presence;
  const bool intent_fresh = vehicle.intent && now - vehicle.intent_at < fresh;
  const bool claims_fresh = vehicle.claims && now - vehicle.claims_at < fresh;
  const bool any_fresh = intent_fresh || claims_fresh;
  const bool intent_newest = vehicle.intent && (!vehicle.claims || vehicle.intent_at > vehicle.claims_at);
  if (intent_fresh || (!any_fresh && intent_newest)) {
    const auto& listed = vehicle.intent->crossings;
    const auto found = std::ranges::find(listed, status_.crossing, &wire::CrossingIntent::name);
    const bool names = found != listed.end();
    presence.holds = names && found->entry_m <= 0.0;
    presence.awaits = names && intent_fresh;
    if (names) presence.arrival_s = found->arrival_s;
  }
  if (vehicle.claims && vehicle.claims->claim && (claims_fresh || (!any_fresh && !intent_newest))) {
    const wire::CrossingClaims::Claim& claim = *vehicle.claims->claim;
    const bool names = std::ranges::find(claim.crossings, status_.crossing) != claim.crossings.end();
    // A claim with the stamp 0 is made inside of the crossing.
    presence.holds = presence.holds || (names && (claim.granted || claim.stamp == 0));
    presence.awaits = presence.awaits || (names && claims_fresh);
    if (names) presence.stamp = claim.stamp;
  }
  const SimTime newest = !vehicle.claims || intent_newest ? vehicle.intent_at : vehicle.claims_at;
  presence.age = std::max(now - newest, SimDuration::zero());
  return presence;
}

void CrossingUnit::compute(SimTime now) {
  std::vector<std::pair<Presence, const wire::VehicleId*>> waiting;
  status_.holders.clear();
  status_.waiting.clear();
  std::erase_if(vehicles_, [&](const Vehicle& vehicle) {
    const Presence presence = presence_of(vehicle, now);
    return !presence.holds && presence.age >= fresh;
  });
  const auto entry = [](const Presence& presence, const wire::VehicleId& id) {
    constexpr std::int64_t age_ms_max = std::numeric_limits<std::uint32_t>::max();
    const std::int64_t age_ms = presence.age / std::chrono::milliseconds{1};
    return wire::CrossingStatus::Vehicle{id, static_cast<std::uint32_t>(std::min(age_ms, age_ms_max))};
  };
  for (const Vehicle& vehicle : vehicles_) {
    const Presence presence = presence_of(vehicle, now);
    if (presence.holds && status_.holders.size() < wire::CrossingStatus::vehicles_max)
      status_.holders.push_back(entry(presence, vehicle.id));
    else if (presence.awaits && !presence.holds)
      waiting.emplace_back(presence, &vehicle.id);
  }
  std::ranges::stable_sort(waiting, [](const auto& a, const auto& b) {
    return std::tie(a.first.stamp, a.first.arrival_s) < std::tie(b.first.stamp, b.first.arrival_s);
  });
  for (const auto& [presence, id] : waiting)
    if (status_.waiting.size() < wire::CrossingStatus::vehicles_max) status_.waiting.push_back(entry(presence, *id));
}

void CrossingUnit::publish(SimTime now, wire::Effects& effects) {
  const auto holders = status_.holders;
  const auto waiting = status_.waiting;
  compute(now);
  const bool due = !published_at_ || now - *published_at_ >= period || now < *published_at_ || !status_.online;
  const bool changed = !same_vehicles(holders, status_.holders) || !same_vehicles(waiting, status_.waiting);
  if (!due && !changed) return;
  // A restarted unit counts on.
  if (!published_at_)
    status_.header_id = static_cast<std::uint32_t>(now.time_since_epoch() / std::chrono::milliseconds{1});
  published_at_ = now;
  ++status_.header_id;
  status_.timestamp = now;
  std::string json = wire::to_json(status_);
  if (options_.direct) effects.emplace_back(wire::SendBytes{std::string(wire::unit_port), json});
  if (online_)
    effects.emplace_back(
        wire::Publish{wire::own_topic(wire::unit_topic_prefix, status_.unit), std::move(json), 0, false});
}

void CrossingUnit::switch_to(const std::string& json) {
  const auto command = wire::unit_switch_from_json(json);
  if (!command) {
    ++counters_.refused;
    return;
  }
  if (command->crossing != status_.crossing) return;
  on_ = command->on;
  // As after a restart of its program: it has received nothing yet.
  vehicles_.clear();
  COSIVA_EXPECT(vehicles_.empty());
}

void CrossingUnit::on_message(const wire::Input& input) {
  if (options_.emulated && input.source == wire::plant_unit_topic) return switch_to(input.payload);
  const wire::V2xTopic* const topic = input.flag || !on_ ? nullptr : wire::received_v2x_topic(input.source);
  if (topic != nullptr) on_intent(input.at, topic->vehicle, input);
}

void CrossingUnit::on_bytes(const wire::Input& input, wire::Effects& effects) {
  const auto source = on_ ? wire::v2x_source(input.source) : std::nullopt;
  if (!source) return;
  if (source->port == wire::v2x_port) on_intent(input.at, source->sender, input);
  if (source->port == wire::claims_port) on_claims(input.at, source->sender, input, effects);
}

void CrossingUnit::handle(const wire::Input& input, wire::Effects& effects) {
  switch (input.kind) {
    case wire::InputKind::link: online_ = input.payload == "up"; break;
    case wire::InputKind::message: on_message(input); break;
    case wire::InputKind::bytes: on_bytes(input, effects); break;
    case wire::InputKind::tick:
      if (on_) publish(input.at, effects);
      break;
    default: break;
  }
}

void CrossingUnit::farewell(SimTime now, wire::Effects& effects) {
  if (!on_) return;
  status_.online = false;
  publish(now, effects);
}

void CrossingUnit::fold(Digest& digest) const {
  digest.add(std::string_view{status_.crossing});
  for (const auto* list : {&status_.holders, &status_.waiting})
    for (const wire::CrossingStatus::Vehicle& one : *list) digest.add(std::string_view{one.vehicle.serial_number});
  digest.add(counters_.repeated);
  digest.add(counters_.refused);
}

}  // namespace cosiva::physical
