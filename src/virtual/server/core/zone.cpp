// Zones as they come, and as they are edited while everything drives.
#include <utility>

#include "cosiva/virtual/server/core/inside.h"

namespace cosiva::virtual_side {
namespace {

/// A broker sends what it keeps at once when somebody subscribes.
constexpr SimDuration retained_within{std::chrono::milliseconds{300}};

}  // namespace

void ServerCore::Inside::on_zone(const zone::ZoneConfiguration& configuration, ZoneCame came) {
  const ZoneEdits::Arrival arrival = edits.arrives(configuration);
  if (came != ZoneCame::given && arrival != ZoneEdits::Arrival::echo) {
    traces.add(now, "physical side", "AIV_Server", "zone",
               configuration.format + ", " + std::to_string(configuration.text.size()) + " bytes", configuration.origin,
               configuration.text);
  }
  const zone::ZoneConfiguration* had = simulator.configuration();
  const bool in_force = had != nullptr && same_content(*had, configuration);
  if (in_force || arrival != ZoneEdits::Arrival::news) zone_confirmed = zone_confirmed || came == ZoneCame::retained;
  switch (arrival) {
    case ZoneEdits::Arrival::echo: return;
    case ZoneEdits::Arrival::stale:
      // A physical side that was started again brings its file; what was edited since is in force all the same.
      if (edits.edited(simulator)) publish_zone();
      return;
    case ZoneEdits::Arrival::news: break;
  }
  if (in_force || waits_for_others(configuration, came)) return;
  if (!take_zone(configuration)) return;
  if (std::exchange(zone_switched_here, false)) state_stale = true;
  edits.begin(configuration, ZoneEdits::Origin::broker);
  recall_zone();
}

bool ServerCore::Inside::waits_for_others(const zone::ZoneConfiguration& configuration, ZoneCame came) {
  // A broker may keep one configuration for each format. They come in any order: where the one in force is among them
  // the others are left from before, else the last one counts.
  if (came != ZoneCame::retained || simulator.configuration() == nullptr || now - link.up_since() >= retained_within)
    return false;
  waiting_zone = configuration;
  return true;
}

void ServerCore::Inside::take_waiting_zone() {
  const zone::ZoneConfiguration configuration = *std::exchange(waiting_zone, std::nullopt);
  if (!zone_confirmed) return on_zone(configuration, ZoneCame::published);
  publisher.log('w', "the broker keeps another zone besides the one in force, on " + configuration.origin +
                         "; it is left alone. Clear that topic, or switch to it");
}

bool ServerCore::Inside::take_zone(const zone::ZoneConfiguration& configuration) {
  const auto received = simulator.receive(now, configuration, step_recorder(*this));
  if (!received) {
    ++messages_refused;
    note_refused(configuration.origin, to_string(received.error()));
    return false;
  }
  refused_zone.reset();
  if (*received == Simulator::Reception::same) return true;
  const auto& zone = simulator.zone();
  publisher.log('i', "zone '" + zone->name + "': " + std::to_string(zone->waypoints.size()) + " waypoints, " +
                         std::to_string(zone->crossings.size()) + " crossings");
  const bool same_ways = *received == Simulator::Reception::same_ways;
  if (same_ways)
    drive_on(zone);
  else
    start_over(zone);
  for (VehicleIndex v = 0; v < registry.size(); ++v) take_priority(v);
  hosted.zone(now, configuration);
  return true;
}

void ServerCore::Inside::drive_on(const std::shared_ptr<const zone::TrafficZone>& zone) {
  // Places, holds and orders are on the ways, which are the same.
  if (!map || !map->take(zone)) return start_over(zone);
  missions.renew();
}

void ServerCore::Inside::start_over(const std::shared_ptr<const zone::TrafficZone>& zone) {
  // Everything that points into the old map forgets it before it goes.
  const std::string from = map ? map->zone().name : std::string{};
  const auto tell_all = [this](const WayMap* ways) {
    traffic.set_map(ways);
    missions.set_map(ways);
    orders.set_map(ways);
    pauses.set_map(ways);
  };
  deadlocks.forget();
  tell_all(nullptr);
  map.emplace(zone);
  tell_all(&*map);
  maps.begin();
  if (!from.empty()) note_switch(from);
  for (VehicleIndex v = 0; v < registry.size(); ++v) {
    AivProxy& proxy = registry[v];
    if (!proxy.here() || !proxy.reported || !proxy.position_known) continue;
    // Seen again on the new zone from where it last was, standing until it reports.
    place_twin(v, now, *proxy.reported, wire::Velocity{});
  }
}

void ServerCore::Inside::take_priority(VehicleIndex vehicle) {
  if (!simulator.zone()) return;
  registry[vehicle].priority = simulator.zone()->priority_of(registry[vehicle].name);
  traffic.set_priority(vehicle, registry[vehicle].priority);
}

void ServerCore::Inside::publish_zone() {
  const zone::ZoneConfiguration* configuration = simulator.configuration();
  if (!link.up() || configuration == nullptr) return;
  const std::string topic = topics.zone_prefix + configuration->format;
  edits.published(*configuration);
  std::string payload = zone::to_payload(*configuration);
  traces.add(now, "AIV_Server", "*", "zone", configuration->format + ", " + std::to_string(payload.size()) + " bytes",
             topic, payload);
  publisher.publish(topic, std::move(payload), 1, true);
}

void ServerCore::Inside::edit_zone(const JsonValue& command) {
  const auto after = edits.after(command, simulator);
  if (!after) {
    publisher.log('w', "command refused: " + to_string(after.error()));
    return;
  }
  const std::string verb = *command.text("command");
  state_stale = true;
  if (verb == "saved") {
    edits.saved(*after);
    return;
  }
  zone::ZoneConfiguration before = *simulator.configuration();
  if (!take_zone(*after)) return;
  edits.done(verb, std::move(before));
  publish_zone();
}

void ServerCore::Inside::switch_zone(const JsonValue& command) {
  const auto wanted = switch_wanted(command);
  if (!wanted) {
    note_refused(command.find("zone") == nullptr ? std::string{} : command.find("zone")->text("origin").value_or(""),
                 to_string(wanted.error()));
    return;
  }
  const std::string format = simulator.configuration() == nullptr ? wanted->format : simulator.configuration()->format;
  if (!take_zone(*wanted)) return;
  zone_switched_here = true;
  state_stale = true;
  waiting_zone.reset();
  edits.begin(*wanted, ZoneEdits::Origin::own);
  publish_zone();
  // Who comes later must not find two.
  if (link.up() && format != wanted->format) publisher.publish(topics.zone_prefix + format, {}, 1, true);
}

}  // namespace cosiva::virtual_side
