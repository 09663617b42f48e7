#include "cosiva/virtual/server/core/server_view.h"

#include <algorithm>

#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side {
namespace {

constexpr std::size_t commands_shown = 50;

void text_or_null(JsonWriter& json, std::string_view name, std::string_view text) {
  json.key(name);
  if (text.empty())
    json.null();
  else
    json.value(text);
}

template <typename... Numbers>
void add(Digest& digest, Numbers... numbers) {
  (digest.add(static_cast<std::uint64_t>(numbers)), ...);
}

}  // namespace

void ServerView::write_objects(JsonWriter& json) const {
  json.key("virtualObjects").begin_array();
  for (const VirtualObject& virtual_object : context_.simulator.augmented().virtual_objects()) {
    const Walk::Motion at = virtual_object.at(context_.now);
    json.begin_object()
        .field("id", virtual_object.id)
        .field("handle", virtual_object.handle)
        .field("kind", to_string(virtual_object.kind))
        .field("x", at.at.x_m)
        .field("y", at.at.y_m)
        .field("heading", at.heading_rad)
        .field("radius", virtual_object.radius_m)
        .field("speed", virtual_object.walk.speed_mps());
    if (virtual_object.walk.path().size() > 1) {
      json.key("path").begin_array();
      for (const Point2 p : virtual_object.walk.path()) json.begin_array().value(p.x_m).value(p.y_m).end_array();
      json.end_array().field("repeat", to_string(virtual_object.walk.repeat()));
    }
    json.key("perceivedBy").begin_array();
    for (VehicleIndex v = 0; v < context_.registry.size(); ++v)
      if (context_.registry[v].here() && augmented_.virtual_obstacles.perceives(v) == virtual_object.id)
        json.value(context_.registry[v].name());
    json.end_array().field("since_ms", to_milliseconds_scaled(virtual_object.since)).end_object();
  }
  json.end_array();
}

void ServerView::write_obstacles(JsonWriter& json) const {
  json.key("obstacles").begin_array();
  for (const DetectedObstacle& obstacle : context_.simulator.detected().obstacles()) {
    json.begin_object()
        .field("id", obstacle.id)
        .field("handle", obstacle.handle)
        .field("x", obstacle.at.x_m)
        .field("y", obstacle.at.y_m)
        .field("radius", obstacle.radius_m);
    json.key("detectedBy").begin_array();
    for (const DetectedObstacle::Witness& witness : obstacle.detected_by) json.value(witness.vehicle);
    json.end_array()
        .field("first_ms", to_milliseconds_scaled(obstacle.first))
        .field("last_ms", to_milliseconds_scaled(obstacle.last))
        .end_object();
  }
  json.end_array();
}

void ServerView::write_crossings(JsonWriter& json) const {
  json.key("crossings").begin_array();
  if (zones_.map()) {
    for (CrossingIndex x = 0; x < zones_.map()->crossing_count(); ++x) {
      const VehicleIndex holder = master_.traffic.holder(x);
      json.begin_object().field("name", zones_.map()->zone().crossings[x].name);
      text_or_null(json, "heldBy",
                   holder == no_vehicle ? std::string_view{} : std::string_view{context_.registry[holder].name()});
      json.key("waiting").begin_array();
      for (const VehicleIndex waiting : master_.traffic.waiting(x)) json.value(context_.registry[waiting].name());
      json.end_array().end_object();
    }
  }
  json.end_array();
}

void ServerView::write_commands(JsonWriter& json) const {
  json.key("commands").begin_array();
  const auto& list = master_.commands.list();
  const std::size_t first = list.size() > commands_shown ? list.size() - commands_shown : 0;
  for (std::size_t i = first; i < list.size(); ++i) {
    const Command& command = list[i];
    const auto since = [&](std::string_view name, const std::optional<SimTime>& at) {
      json.key(name);
      if (at)
        json.value(to_milliseconds_scaled(*at - command.at));
      else
        json.null();
    };
    json.begin_object()
        .field("id", command.id)
        .field("vehicle", command.vehicle_name)
        .field("command", command.command_text)
        .field("state", to_string(command.state))
        .field("time_ms", to_milliseconds_scaled(command.at));
    since("accepted_ms", command.accepted_at);
    since("materialised_ms", command.materialised_at);
    json.field("reason", command.reason).end_object();
  }
  json.end_array();
}

std::string ServerView::snapshot_json() const {
  JsonWriter json;
  json.begin_object()
      .field("time", to_iso8601(context_.now))
      .field("time_ms", to_milliseconds_scaled(context_.now))
      .field("zoneRevision", context_.simulator.zone_revision());
  json.key("zoneEdits")
      .begin_object()
      .field("undo", static_cast<std::uint64_t>(zones_.edits().undo_count()))
      .field("redo", static_cast<std::uint64_t>(zones_.edits().redo_count()))
      .field("unsaved", zones_.edits().unsaved(context_.simulator))
      .end_object();
  json.key("registry")
      .begin_object()
      .field("vehicles", context_.registry.known())
      .field("max", context_.registry.vehicles_max())
      .field("refused", context_.unknown_senders.excess)
      .field("full", refuses_vehicles(context_))
      .end_object();
  if (context_.areas.several()) context_.areas.write(json.key("area"));
  zones_.write(json);
  json.key("aivs").begin_array();
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v)
    if (context_.registry[v].shown(context_.now)) vehicle_.write(json, v);
  json.end_array();
  write_objects(json);
  write_obstacles(json);
  write_crossings(json);
  master_.deadlocks.write(json.key("deadlocks"));
  context_.simulator.monitor().write(json.key("bijection"));
  write_commands(json);
  instruments_.batteries.write(json.key("battery"));
  instruments_.gvs.write(json.key("gvs"));
  instruments_.units.write(json.key("units"), context_.now,
                           zones_.map() ? std::string_view{zones_.map()->zone().name} : std::string_view{});
  json.end_object();
  return json.take();
}

std::string ServerView::summary_json() const {
  JsonWriter json;
  context_.simulator.monitor().write(json.begin_object().key("bijection"));
  json.key("aivs").begin_array();
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
    if (context_.registry.vacant(v)) continue;
    const AivProxy& proxy = context_.registry[v];
    const wire::ConnectionState connection = proxy.connection.shown();
    json.begin_object()
        .field("id", proxy.name())
        .field("number", proxy.identity.number())
        .field("augmented", proxy.augmented())
        .field("connection", wire::vda5050::to_string(connection))
        .field("present", proxy.twin_link.present())
        .field("twin", proxy.twin().has_value())
        .field("messages", proxy.counters.messages())
        .field("missed", proxy.counters.missed())
        .field("refused", proxy.counters.refused())
        .field("outdated", proxy.counters.outdated())
        .field("dropped", proxy.counters.dropped())
        .end_object();
  }
  json.end_array();
  json.key("orders")
      .begin_object()
      .field("sent", master_.orders.counters().orders)
      .field("updates", master_.orders.counters().updates)
      .field("resent", master_.orders.counters().repeated)
      .field("longest_wait_s", to_seconds(master_.orders.longest_wait()))
      .end_object();
  if (const PlannedRoutes* const planned = master_.orders.planned()) planned->route_waits().write(json.key("routes"));
  master_.deadlocks.write_counters(json.key("deadlocks").begin_object());
  json.end_object();
  json.field("messages_refused", context_.messages_refused).field("traces", context_.traces.next() - 1).end_object();
  return json.take();
}

ServerCore::PageRevision ServerView::page_revision() const {
  Digest waited_for;
  Digest events;
  add(waited_for, context_.simulator.zone_revision(), zones_.edits().undo_count(), zones_.edits().redo_count(),
      zones_.edits().unsaved(context_.simulator), refuses_vehicles(context_), master_.deadlocks.revision());
  for (const Finding& finding : context_.simulator.monitor().findings()) {
    add(waited_for, finding.kind, finding.since.time_since_epoch().count());
    waited_for.add(std::string_view{finding.id});
  }
  for (const Command& command : master_.commands.list())
    add(waited_for, command.state, command.handle, command.vehicle);
  for (const VirtualObject& virtual_object : context_.simulator.augmented().virtual_objects())
    add(waited_for, virtual_object.handle, virtual_object.started.time_since_epoch().count());
  for (const DetectedObstacle& detected : context_.simulator.detected().obstacles()) add(waited_for, detected.handle);
  instruments_.units.fold(waited_for, context_.now);
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) add_vehicle(v, waited_for, events);
  return {waited_for.value(), events.value()};
}

void ServerView::add_vehicle(VehicleIndex vehicle, Digest& waited_for, Digest& events) const {
  const AivProxy& proxy = context_.registry[vehicle];
  add(waited_for, proxy.here(), proxy.lost(context_.now, context_.options.lost_after), proxy.settings.priority());
  if (const auto connection = proxy.connection.state()) add(waited_for, *connection, 1);
  waited_for.add(std::string_view{augmented_.virtual_obstacles.perceives(vehicle)});
  if (!proxy.state()) return;
  const wire::State& state = *proxy.state();
  add(waited_for, proxy.counters.rate().flooding(context_.now), state.field_violation, state.paused,
      state.errors.size());
  add(events, proxy.reported_state.last_tag().value_or(0), state.last_node_sequence_id, state.driving);
  events.add(std::string_view{state.last_node_id});
}

}  // namespace cosiva::virtual_side
