// Zones as they come, and as they are edited while everything drives.
#include <utility>

#include "virtual/server/inside.h"

namespace cosiva::virtual_side {
void ServerCore::Inside::on_zone(const zone::ZoneConfiguration& configuration, bool from_broker) {
  const ZoneEdits::Arrival arrival = edits.arrives(configuration);
  if (from_broker && arrival != ZoneEdits::Arrival::echo) {
    traces.add(now, "physical side", "AIV_Server", "zone",
               configuration.format + ", " + std::to_string(configuration.text.size()) + " bytes", configuration.origin,
               configuration.text);
  }
  switch (arrival) {
    case ZoneEdits::Arrival::echo: return;
    case ZoneEdits::Arrival::stale:
      // A physical side that was started again brings its file; what was edited since is in force all the same.
      if (edits.edited(simulator)) publish_zone();
      return;
    case ZoneEdits::Arrival::news: break;
  }
  const zone::ZoneConfiguration* had = simulator.configuration();
  if (had != nullptr && had->format == configuration.format && had->text == configuration.text) return;
  if (!take_zone(configuration)) return;
  edits.begin(configuration);
  recall_zone();
}

bool ServerCore::Inside::take_zone(const zone::ZoneConfiguration& configuration) {
  const auto received = simulator.receive(now, configuration, step_recorder());
  if (!received) {
    ++messages_refused;
    outbox.log('e', "zone configuration refused: " + to_string(received.error()) +
                        (simulator.zone() ? "; the zone that was there stays" : ""));
    return false;
  }
  if (*received == Simulator::Reception::same) return true;
  const auto& zone = simulator.zone();
  outbox.log('i', "zone '" + zone->name + "': " + std::to_string(zone->waypoints.size()) + " waypoints, " +
                      std::to_string(zone->crossings.size()) + " crossings");
  const bool same_ways = *received == Simulator::Reception::same_ways;
  if (same_ways)
    drive_on(zone);
  else
    start_over(zone);
  for (VehicleIndex v = 0; v < registry.size(); ++v) take_priority(v);
  if (same_ways)
    fleet.zone(now, configuration);
  else
    resettle_aivs();
  return true;
}

void ServerCore::Inside::drive_on(const std::shared_ptr<const zone::TrafficZone>& zone) {
  // Places, holds and orders are on the ways, which are the same.
  if (map && map->take(zone)) return;
  start_over(zone);
}

void ServerCore::Inside::start_over(const std::shared_ptr<const zone::TrafficZone>& zone) {
  // Everything that points into the old map forgets it before it goes.
  traffic.set_map(nullptr);
  roller.set_map(nullptr);
  pauses.set_map(nullptr);
  map.emplace(zone);
  traffic.set_map(&*map);
  roller.set_map(&*map);
  pauses.set_map(&*map);
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
  if (!link_up || configuration == nullptr) return;
  const std::string topic = std::string(wire::zone_topic_prefix) + configuration->format;
  edits.published(*configuration);
  traces.add(now, "AIV_Server", "*", "zone",
             configuration->format + ", " + std::to_string(configuration->text.size()) + " bytes", topic,
             configuration->text);
  outbox.publish(topic, configuration->text, 1, true);
}

void ServerCore::Inside::edit_zone(const JsonValue& command) {
  const auto after = edits.after(command, simulator);
  if (!after) {
    outbox.log('w', "command refused: " + to_string(after.error()));
    return;
  }
  const std::string verb = *command.text("command");
  memory_stale = true;
  if (verb == "saved") {
    edits.saved(*after);
    return;
  }
  zone::ZoneConfiguration before = *simulator.configuration();
  if (!take_zone(*after)) return;
  edits.done(verb, std::move(before));
  publish_zone();
}

}  // namespace cosiva::virtual_side
