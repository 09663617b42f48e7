#include "cosiva/hmi/commands.h"

#include <algorithm>

#include "cosiva/base/json_text.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/hmi/http_responses.h"
#include "cosiva/hmi/stop_calls.h"
#include "cosiva/hmi/unique_ids.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::app {
namespace {

using adapters::http_error;
using adapters::HttpResponse;

constexpr std::size_t snapshot_bytes_max = std::size_t{1} << 28U;

HttpResponse id_response(std::string_view id, unsigned status) {
  JsonWriter json;
  json.begin_object().field("id", id).end_object();
  return json_response(json.take(), status);
}

HttpResponse removed_response(std::size_t count) {
  JsonWriter json;
  json.begin_object().field("removed", count).end_object();
  return json_response(json.take());
}

/// {"command":command,"virtualObject":{"id":…, and the fields of the body except its own id}}
std::string virtual_object_command(std::string_view command, const std::string& id, const JsonValue& body) {
  JsonWriter json;
  json.begin_object().field("command", command).key("virtualObject").begin_object().field("id", id);
  for (const auto& [name, value] : *body.object())
    if (name != "id") write_json(json.key(name), value);
  json.end_object().end_object();
  return json.take();
}

std::string remove_command(std::string_view id) {
  JsonWriter json;
  json.begin_object().field("command", "remove").field("id", id).end_object();
  return json.take();
}

/// A virtual AIV has two names: its virtual object's id, and the vehicle "CoSiVA.virtual/V1".
std::string virtual_object_id(const std::string& given) {
  const std::string prefix = std::string(wire::virtual_manufacturer) + "/";
  return given.starts_with(prefix) ? given.substr(prefix.size()) : given;
}

/// The number of virtual objects and virtual AIVs.
std::size_t count_virtual(const virtual_side::ServerCore& core) {
  const auto snapshot = JsonValue::parse(core.snapshot_json(), snapshot_bytes_max);
  if (!snapshot) return 0;
  std::size_t count = 0;
  if (const JsonValue* virtual_objects = snapshot->find("virtualObjects");
      virtual_objects != nullptr && virtual_objects->array() != nullptr)
    count += virtual_objects->array()->size();
  if (const JsonValue* aivs = snapshot->find("aivs"); aivs != nullptr && aivs->array() != nullptr)
    count += static_cast<std::size_t>(
        std::ranges::count_if(*aivs->array(), [](const JsonValue& aiv) { return aiv.flag("augmented") == true; }));
  return count;
}

/// The id that the client has chosen for its command, where it has.
Result<std::optional<std::string>> chosen_id(const JsonValue& body) {
  const JsonValue* id = body.find("id");
  if (id == nullptr) return std::nullopt;
  if (id->text() == nullptr || !valid_client_id(*id->text())) {
    return fail("command.id",
                "an id has 1 to 64 of A-Z a-z 0-9 _ . : -, and is not of the form of the server's own ids (C-…, S-…, "
                "c-…, c12); a UUID is suitable; without an id the server gives one",
                "id");
  }
  return *id->text();
}

}  // namespace

HttpResponse post_command(CallContext& context, const Call& call) {
  if (is_stop(call.body)) {
    const auto stop = read_stop(call.body, context.stops()->begin());
    return stop ? give_stop(context, *stop) : refusal(stop.error());
  }
  const auto chosen = chosen_id(call.body);
  if (!chosen) return refusal(chosen.error());
  const std::string id = *chosen ? **chosen : context.next_command_id();
  JsonWriter json;
  json.begin_object().field("id", id);
  if (*chosen) json.field("once", true);
  for (const char* key : {"command", "vehicle", "vehicles", "speed", "to", "loop", "section"})
    if (const JsonValue* value = call.body.find(key)) write_json(json.key(key), *value);
  json.end_object();
  if (auto given = context.give(json.take()); !given) return refusal(given.error());
  return id_response(id, 202);
}

HttpResponse post_battery_ready(CallContext& context, const Call& call) {
  JsonWriter json;
  json.begin_object().field("command", "batteryReady");
  for (const char* key : {"vehicle", "battery", "type", "cycles", "rest_s", "temperature", "charge"})
    if (const JsonValue* value = call.body.find(key)) write_json(json.key(key), *value);
  json.end_object();
  if (auto given = context.give(json.take()); !given) return refusal(given.error());
  return json_response("{}", 202);
}

HttpResponse add_virtual_object(CallContext& context, const Call& call) {
  const std::string kind = call.body.text("kind").value_or("");
  if (kind != "aiv" && kind != "person" && kind != "obstacle")
    return http_error(400, "virtual_object.kind", R"(state what to add: "kind":"aiv", "person" or "obstacle")");
  const std::string id = context.host().core->next_virtual_object_id(kind);
  if (auto given = context.give(virtual_object_command("add", id, call.body)); !given) return refusal(given.error());
  return id_response(id, 201);
}

HttpResponse move_virtual_object(CallContext& context, const Call& call) {
  const std::string id = virtual_object_id(call.arguments[0]);
  // Whether the object could be removed shows whether it exists.
  if (auto there = context.host().core->check_command(virtual_side::DecodedCommand{remove_command(id)}); !there)
    return refusal(there.error());
  if (auto given = context.give(virtual_object_command("move", id, call.body)); !given) return refusal(given.error());
  return id_response(id, 200);
}

HttpResponse remove_virtual_object(CallContext& context, const Call& call) {
  const std::string id = virtual_object_id(call.arguments[0]);
  if (id == "*")
    return http_error(404, "virtual_object.not_found", "DELETE /api/v1/virtual-objects removes all of them");
  if (auto given = context.give(remove_command(id)); !given) return refusal(given.error());
  return removed_response(1);
}

HttpResponse remove_virtual_objects(CallContext& context, const Call&) {
  const std::size_t count = count_virtual(*context.host().core);
  if (count > 0) {
    if (auto given = context.give(remove_command("*")); !given) return refusal(given.error());
  }
  return removed_response(count);
}

HttpResponse add_plant_obstacle(CallContext& context, const Call& call) {
  if (!context.has_plant())
    return http_error(409, "plant.not_now",
                      "no emulated world has reported; put a physical obstacle into the zone by hand");
  std::string id;
  if (const JsonValue* given = call.body.find("id")) {
    if (given->text() == nullptr || given->text()->empty())
      return http_error(400, "plant.id", R"("id" is a name such as "box1"; without one the server gives it)");
    id = *given->text();
  } else {
    id = context.next_obstacle_id();
  }
  JsonWriter json;
  json.begin_object().field("command", "plant").key("plant").begin_object().key("addObstacle").begin_object();
  json.field("id", id);
  for (const auto& [name, value] : *call.body.object())
    if (name != "id") write_json(json.key(name), value);
  json.end_object().end_object().end_object();
  if (auto given = context.give(json.take()); !given) return refusal(given.error());
  context.added_to_plant(id);
  return id_response(id, 201);
}

HttpResponse remove_plant_obstacle(CallContext& context, const Call& call) {
  const std::string& id = call.arguments[0];
  if (!context.has_plant())
    return http_error(409, "plant.not_now", "no emulated world has reported; remove a physical obstacle by hand");
  if (!context.in_plant(id))
    return http_error(404, "plant.not_found", "the emulated world has no obstacle '" + id + "'");
  JsonWriter json;
  json.begin_object().field("command", "plant").key("plant").begin_object().field("removeObstacle", id);
  json.end_object().end_object();
  if (auto given = context.give(json.take()); !given) return refusal(given.error());
  context.removed_from_plant(id);
  return removed_response(1);
}

}  // namespace cosiva::app
