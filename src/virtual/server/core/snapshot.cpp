// What the page and the run's summary read (docs/protocols/hmi-api.md).
#include <algorithm>

#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/core/inside.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::size_t commands_shown = 50;

double ms_of(SimDuration duration) { return static_cast<double>(duration.count()) * 1e-6; }

void text_or_null(JsonWriter& json, std::string_view name, std::string_view text) {
  json.key(name);
  if (text.empty())
    json.null();
  else
    json.value(text);
}

}  // namespace

void ServerCore::Inside::write_things(JsonWriter& json) const {
  json.key("things").begin_array();
  for (const Thing& thing : simulator.augmented().things()) {
    const Walk::Motion at = thing.at(now);
    json.begin_object()
        .field("id", thing.id)
        .field("handle", thing.handle)
        .field("kind", to_string(thing.kind))
        .field("x", at.at.x_m)
        .field("y", at.at.y_m)
        .field("heading", at.heading_rad)
        .field("radius", thing.radius_m)
        .field("speed", thing.walk.speed_mps());
    if (thing.walk.path().size() > 1) {
      json.key("path").begin_array();
      for (const Point2 p : thing.walk.path()) json.begin_array().value(p.x_m).value(p.y_m).end_array();
      json.end_array().field("repeat", to_string(thing.walk.repeat()));
    }
    json.key("feltBy").begin_array();
    for (VehicleIndex v = 0; v < registry.size(); ++v)
      if (registry[v].here() && virtual_obstacles.feels(v) == thing.id) json.value(registry[v].name);
    json.end_array().field("since_ms", ms_of(thing.since.time_since_epoch())).end_object();
  }
  json.end_array();
}

void ServerCore::Inside::write_obstacles(JsonWriter& json) const {
  json.key("obstacles").begin_array();
  for (const SeenObstacle& obstacle : simulator.seen().obstacles()) {
    json.begin_object()
        .field("id", obstacle.id)
        .field("handle", obstacle.handle)
        .field("x", obstacle.at.x_m)
        .field("y", obstacle.at.y_m)
        .field("radius", obstacle.radius_m);
    json.key("seenBy").begin_array();
    for (const SeenObstacle::Witness& witness : obstacle.seen_by) json.value(witness.vehicle);
    json.end_array()
        .field("first_ms", ms_of(obstacle.first.time_since_epoch()))
        .field("last_ms", ms_of(obstacle.last.time_since_epoch()))
        .end_object();
  }
  json.end_array();
}

void ServerCore::Inside::write_crossings(JsonWriter& json) const {
  json.key("crossings").begin_array();
  if (zones.map()) {
    for (CrossingIndex x = 0; x < zones.map()->crossing_count(); ++x) {
      const VehicleIndex holder = traffic.holder(x);
      json.begin_object().field("name", zones.map()->zone().crossings[x].name);
      text_or_null(json, "heldBy", holder == no_vehicle ? std::string_view{} : std::string_view{registry[holder].name});
      json.key("waiting").begin_array();
      for (const VehicleIndex waiting : traffic.waiting(x)) json.value(registry[waiting].name);
      json.end_array().end_object();
    }
  }
  json.end_array();
}

void ServerCore::Inside::write_commands(JsonWriter& json) const {
  json.key("commands").begin_array();
  const auto& list = commands.list();
  const std::size_t first = list.size() > commands_shown ? list.size() - commands_shown : 0;
  for (std::size_t i = first; i < list.size(); ++i) {
    const Command& command = list[i];
    const auto since = [&](std::string_view name, const std::optional<SimTime>& at) {
      json.key(name);
      if (at)
        json.value(ms_of(*at - command.at));
      else
        json.null();
    };
    json.begin_object()
        .field("id", command.id)
        .field("vehicle", command.vehicle_name)
        .field("command", command.verb_text)
        .field("state", to_string(command.state))
        .field("time_ms", ms_of(command.at.time_since_epoch()));
    since("accepted_ms", command.accepted_at);
    since("materialised_ms", command.materialised_at);
    json.field("reason", command.reason).end_object();
  }
  json.end_array();
}

std::string ServerCore::snapshot_json() const {
  const Inside& in = *inside_;
  JsonWriter json;
  json.begin_object()
      .field("time", to_iso8601(in.now))
      .field("time_ms", ms_of(in.now.time_since_epoch()))
      .field("zoneRevision", in.simulator.zone_revision());
  json.key("zoneEdits")
      .begin_object()
      .field("undo", static_cast<std::uint64_t>(in.zones.edits().undo_count()))
      .field("redo", static_cast<std::uint64_t>(in.zones.edits().redo_count()))
      .field("unsaved", in.zones.edits().unsaved(in.simulator))
      .end_object();
  if (in.areas.several()) in.areas.write(json.key("hall"));
  in.zones.write(json);
  json.key("aivs").begin_array();
  for (VehicleIndex v = 0; v < in.registry.size(); ++v)
    if (in.registry[v].shown(in.now)) in.write_vehicle(json, v);
  json.end_array();
  in.write_things(json);
  in.write_obstacles(json);
  in.write_crossings(json);
  in.deadlocks.write(json.key("deadlocks"));
  in.simulator.monitor().write(json.key("bijection"));
  in.write_commands(json);
  in.batteries.write(json.key("battery"));
  in.gvs.write(json.key("gvs"));
  json.end_object();
  return json.take();
}

void ServerCore::write_bijection(JsonWriter& json) const { inside_->simulator.monitor().write(json); }

std::string ServerCore::summary_json() const {
  const Inside& in = *inside_;
  JsonWriter json;
  in.simulator.monitor().write(json.begin_object().key("bijection"));
  json.key("aivs").begin_array();
  for (const AivProxy& proxy : in.registry) {
    const wire::ConnectionState connection = proxy.connection.value_or(wire::ConnectionState::online);
    json.begin_object()
        .field("id", proxy.name)
        .field("number", proxy.number)
        .field("augmented", proxy.augmented)
        .field("connection", wire::vda5050::to_string(connection))
        .field("present", proxy.present)
        .field("twin", proxy.twin.has_value())
        .field("messages", proxy.messages)
        .field("missed", proxy.headers_missed)
        .field("refused", proxy.refused)
        .field("outdated", proxy.outdated)
        .end_object();
  }
  json.end_array();
  json.key("orders")
      .begin_object()
      .field("sent", in.orders.orders_sent())
      .field("updates", in.orders.updates_sent())
      .field("resent", in.orders.resent())
      .field("longest_wait_s", to_seconds(in.orders.longest_wait()))
      .end_object();
  in.deadlocks.write_counters(json.key("deadlocks").begin_object());
  json.end_object();
  json.field("messages_refused", in.messages_refused).field("traces", in.traces.next() - 1).end_object();
  return json.take();
}

std::string ServerCore::traces_json(std::uint64_t after, std::size_t limit) const {
  return inside_->traces.to_json(after, limit);
}

}  // namespace cosiva::virtual_side
