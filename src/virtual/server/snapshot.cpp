// What the page and the run's summary read (docs/protocols/hmi-api.md).
#include <algorithm>

#include "base/json_writer.h"
#include "virtual/server/inside.h"
#include "wire/vda5050/codec.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::size_t commands_shown = 50;

double ms_of(SimDuration duration) { return static_cast<double>(duration.count()) * 1e-6; }

void write_pose(JsonWriter& json, const Pose2& pose) {
  json.field("x", pose.x_m).field("y", pose.y_m).field("heading", pose.heading_rad);
}

void text_or_null(JsonWriter& json, std::string_view name, std::string_view text) {
  json.key(name);
  if (text.empty())
    json.null();
  else
    json.value(text);
}

}  // namespace

void ServerCore::Inside::write_vehicle(JsonWriter& json, VehicleIndex vehicle) const {
  const AivProxy& proxy = registry[vehicle];
  const Twin& twin = simulator.twin(*proxy.twin);
  const Twin::Image image = simulator.image(*proxy.twin, now);
  const wire::ConnectionState connection = proxy.connection.value_or(wire::ConnectionState::online);
  const bool lost = proxy.lost(now, options.lost_after) || connection == wire::ConnectionState::connection_broken;
  const double speed_mps = lost ? 0.0 : image.speed_mps;

  json.begin_object()
      .field("id", proxy.name)
      .field("number", proxy.number)
      .field("connection", wire::vda5050::to_string(connection))
      .field("lost", lost)
      .field("status", aiv::to_string(aiv::status_of(speed_mps, proxy.imposed)));
  write_pose(json, image.X_MB);
  json.field("speed", speed_mps).key("section");
  if (image.place && simulator.circuit() != nullptr)
    json.value(simulator.circuit()->part(image.place->section).name).key("s").value(image.place->s_m);
  else
    json.null().key("s").null();
  write_pose(json.key("reported").begin_object(), twin.last_report().X_MB);
  json.end_object();
  json.field("age_ms", std::max(0.0, ms_of(now - proxy.reported_at)))
      .field("divergence_m", simulator.last_divergence_m(*proxy.twin))
      .field("battery", proxy.state ? proxy.state->battery.charge_percent : 0.0)
      .key("lastTag");
  if (proxy.last_tag)
    json.value(*proxy.last_tag);
  else
    json.null();
  const wire::State none;
  const wire::State& state = proxy.state ? *proxy.state : none;
  json.field("sinceTag_m", proxy.since_tag_m)
      .field("lastNode", state.last_node_id)
      .field("orderId", state.order_id)
      .field("orderUpdateId", state.order_update_id)
      .field("driving", state.driving)
      .field("paused", state.paused)
      .field("fieldViolation", state.field_violation);
  text_or_null(json, "waitsFor", roller.waits_for(vehicle));
  json.key("errors").begin_array();
  for (const wire::VehicleError& error : state.errors)
    json.value(error.description.empty() ? error.type : error.type + ": " + error.description);
  if (proxy.clock_off_s != 0.0) json.value("clock: off by " + std::to_string(proxy.clock_off_s) + " s");
  json.end_array();
  const auto held = simulator.monitor().held(proxy.entity);
  json.key("contract")
      .begin_object()
      .field("matched", held.matched)
      .field("divergence", held.divergence)
      .field("age", held.age)
      .end_object()
      .end_object();
}

void ServerCore::Inside::write_crossings(JsonWriter& json) const {
  json.key("crossings").begin_array();
  if (map) {
    for (CrossingIndex x = 0; x < map->crossing_count(); ++x) {
      const VehicleIndex holder = traffic.holder(x);
      json.begin_object().field("name", map->zone().crossings[x].name);
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
  json.key("aivs").begin_array();
  for (VehicleIndex v = 0; v < in.registry.size(); ++v)
    if (in.registry[v].twin) in.write_vehicle(json, v);
  json.end_array();
  in.write_crossings(json);
  in.simulator.monitor().write(json.key("bijection"));
  in.write_commands(json);
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
      .field("sent", in.roller.orders_sent())
      .field("updates", in.roller.updates_sent())
      .field("resent", in.roller.resent())
      .field("longest_wait_s", to_seconds(in.roller.longest_wait()))
      .end_object();
  json.field("messages_refused", in.messages_refused).field("traces", in.traces.next() - 1).end_object();
  return json.take();
}

std::string ServerCore::traces_json(std::uint64_t after, std::size_t limit) const {
  return inside_->traces.to_json(after, limit);
}

}  // namespace cosiva::virtual_side
