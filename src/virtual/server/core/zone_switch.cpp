// From one zone to another while vehicles drive: who is on the new one already, who stands where, when to go on.
#include <algorithm>
#include <cmath>
#include <utility>

#include "cosiva/virtual/server/core/inside.h"
#include "cosiva/zone/circuit/anchor.h"

namespace cosiva::virtual_side {
namespace {

/// One of ours that has not said so long after a switch that it is on the new map is not waited for any more.
constexpr SimDuration change_patience{std::chrono::seconds{10}};
constexpr double moving_mps = 0.01;

double ms_of(SimDuration duration) { return static_cast<double>(duration.count()) * 1e-6; }

}  // namespace

Result<zone::ZoneConfiguration> ServerCore::Inside::switch_wanted(const JsonValue& command) const {
  const JsonValue* zone = command.find("zone");
  if (zone == nullptr)
    return fail("switch.zone", R"(say which zone, as {"zone":{"format":…,"origin":…,"text":…}})", "zone");
  auto configuration = zone::zone_configuration_from_json(*zone);
  if (!configuration) return configuration;
  if (simulator.configuration() != nullptr && same_content(*simulator.configuration(), *configuration))
    return fail("switch.same", "this zone is in force already", "zone");
  // What we publish, everybody must be able to build.
  if (auto rtm = zone::Rtm::initialise(*configuration); !rtm) return tl::unexpected(rtm.error());
  return configuration;
}

void ServerCore::Inside::note_refused(const std::string& origin, const std::string& why) {
  refused_zone = Refused{now, origin, why};
  publisher.log('e',
                "zone configuration refused: " + why + (simulator.zone() ? "; the zone that was there stays" : ""));
}

void ServerCore::Inside::note_switch(std::string from) {
  switched = Switched{};
  switched->at = now;
  switched->from = std::move(from);
}

bool ServerCore::Inside::changing_map(VehicleIndex vehicle) const {
  const AivProxy& proxy = registry[vehicle];
  return switched && now - switched->at < change_patience && !proxy.map_id.empty() && proxy.map_id != map->zone().name;
}

bool ServerCore::Inside::all_stand_off_old_map() const {
  for (VehicleIndex v = 0; v < registry.size(); ++v) {
    const AivProxy& proxy = registry[v];
    if (!proxy.here() || !proxy.online() || proxy.lost(now, options.lost_after) || !changing_map(v)) continue;
    // What it did before the switch says nothing of what it does now.
    const bool moves = proxy.reports.last() <= switched->at || (proxy.state && proxy.state->driving) ||
                       simulator.twin(*proxy.twin).speed_mps() > moving_mps;
    if (proxy.ours() && moves) return false;
  }
  return true;
}

bool ServerCore::Inside::nobody_changes_map() const {
  for (VehicleIndex v = 0; v < registry.size(); ++v) {
    const AivProxy& proxy = registry[v];
    if (!proxy.here() || !proxy.online() || proxy.lost(now, options.lost_after)) continue;
    const bool rolls_out = simulator.twin(*proxy.twin).speed_mps() > moving_mps && !orders.has_order(v);
    if (changing_map(v) || proxy.reports.last() <= switched->at || rolls_out) return false;
  }
  return true;
}

std::string ServerCore::Inside::parked(VehicleIndex vehicle) const {
  const AivProxy& proxy = registry[vehicle];
  if (!map || !proxy.here() || changing_map(vehicle)) return {};
  const std::string& name = map->zone().name;
  if (!proxy.map_id.empty() && proxy.map_id != name)
    return "is on map '" + proxy.map_id.substr(0, 80) + "', not on '" + name + "'; it gets no orders until it is";
  const Twin& twin = simulator.twin(*proxy.twin);
  if (twin.reported_off_m() <= zone::anchor_within_m) return {};
  return "stands " + metres_text(twin.reported_off_m()) + " m from the nearest way of '" + name + "'; put it within " +
         metres_text(zone::anchor_within_m) + " m of one";
}

void ServerCore::Inside::follow_switch() {
  if (!map) return;
  const MapDesk::Map wanted{map->zone().name, zone::version_of(*simulator.configuration()), options.map_download_link};
  for (VehicleIndex v = 0; v < registry.size(); ++v) {
    const AivProxy& proxy = registry[v];
    if (options.drive && !proxy.ours() && proxy.here() && !proxy.map_id.empty() && proxy.map_id != wanted.id)
      maps.step(v, wanted);
  }
  if (!switched) return;
  switched->sent_off = switched->sent_off || all_stand_off_old_map();
  const bool settled_down = nobody_changes_map() || now - switched->at >= change_patience;
  if (switched->sent_off && !switched->counted && settled_down) {
    switched->counted = true;
    for (VehicleIndex v = 0; v < registry.size(); ++v) {
      const AivProxy& proxy = registry[v];
      if (!proxy.here()) continue;
      const std::string why = parked(v);
      if (why.empty()) {
        ++switched->anchored;
        continue;
      }
      switched->parked.push_back(proxy.name);
      publisher.log('w', proxy.name + ": parked: it " + why);
    }
  }
  if (!switched->sent_off || switched->first_moving) return;
  for (VehicleIndex v = 0; v < registry.size(); ++v) {
    const AivProxy& proxy = registry[v];
    if (!proxy.here() || !orders.has_order(v)) continue;
    // Turning towards its new line counts: VDA 5050's driving is "driving or rotating".
    const bool drives = proxy.state && proxy.state->driving && proxy.map_id == map->zone().name;
    if (!drives && simulator.twin(*proxy.twin).speed_mps() <= moving_mps) continue;
    switched->first_moving = now;
    publisher.log('i', "zone '" + wanted.id + "': " + proxy.name + " moves on it, " +
                           std::to_string(static_cast<std::int64_t>(ms_of(now - switched->at))) +
                           " ms after the switch");
    return;
  }
}

void ServerCore::Inside::write_zone(JsonWriter& json) const {
  json.key("zone").begin_object().key("name");
  if (simulator.zone())
    json.value(simulator.zone()->name);
  else
    json.null();
  json.field("revision", simulator.zone_revision()).key("closed").begin_array();
  for (const std::string& name : missions.closed_names()) json.value(name);
  json.end_array().key("refused");
  if (refused_zone) {
    json.begin_object()
        .field("origin", refused_zone->origin)
        .field("why", refused_zone->why)
        .field("at", ms_of(refused_zone->at.time_since_epoch()))
        .end_object();
  } else {
    json.null();
  }
  json.key("switched");
  if (switched) {
    json.begin_object()
        .field("at", ms_of(switched->at.time_since_epoch()))
        .field("from", switched->from)
        .key("first_moving_ms");
    if (switched->first_moving)
      json.value(ms_of(*switched->first_moving - switched->at));
    else
      json.null();
    json.field("anchored", static_cast<std::uint64_t>(switched->anchored)).key("parked").begin_array();
    for (const std::string& name : switched->parked) json.value(name);
    json.end_array().end_object();
  } else {
    json.null();
  }
  json.end_object();
}

}  // namespace cosiva::virtual_side
