#include "cosiva/hmi/stop_calls.h"

#include <utility>
#include <variant>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_text.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/hmi/http_responses.h"

namespace cosiva::app {

using adapters::http_error;
using adapters::HttpResponse;

namespace {

JsonWriter& write_entry(JsonWriter& json, const StopBook::Entry& stop) {
  json.begin_object().field("id", stop.id).field("durable", stop.durable);
  if (!stop.durable) json.field("reason", stop.reason);
  return json;
}

}  // namespace

bool is_stop(const JsonValue& body) { return body.text("command") == "stop"; }

Result<StopRequest> read_stop(const JsonValue& body, const std::string& id) {
  JsonWriter json;
  json.begin_object().field("id", id);
  for (const char* key : {"command", "vehicle", "vehicles"})
    if (const JsonValue* value = body.find(key)) write_json(json.key(key), *value);
  json.field("actionId", id).end_object();
  StopRequest stop{id, json.take(), {}, {}};
  stop.decoded = std::make_shared<const virtual_side::DecodedCommand>(stop.json);
  if (!stop.decoded->command()) return tl::unexpected(stop.decoded->command().error().error);
  const auto* command = std::get_if<virtual_side::VehicleCommand>(&*stop.decoded->command());
  COSIVA_EXPECT(command != nullptr);
  stop.vehicles = command->vehicle_names;
  return stop;
}

HttpResponse give_stop(CallContext& context, const StopRequest& stop) {
  if (const auto checked = context.host().core->check_command(*stop.decoded); !checked) {
    context.stops()->refuse(stop.id, to_string(checked.error()));
    return refusal(checked.error());
  }
  const auto durable = [stops = context.stops(), id = stop.id] { stops->became_durable(id); };
  if (context.host().stop)
    context.host().stop("http", stop.json, stop.decoded, durable);
  else
    context.host().command("http", stop.json, stop.decoded, [durable](const Result<void>& kept) {
      if (kept) durable();
    });
  return stop_response(context.stops()->find(stop.id).value_or(StopBook::Entry{stop.id, false, StopBook::not_yet}));
}

HttpResponse stop_response(const StopBook::Entry& stop) {
  JsonWriter json;
  write_entry(json, stop).end_object();
  return json_response(json.take(), 202);
}

HttpResponse stop_progress(const StopBook& stops, const StopLine& line, const std::string& id) {
  const auto stop = stops.find(id);
  if (!stop)
    return http_error(404, "command.not_found",
                      "'" + id.substr(0, 80) + "' is none of the last Stops; the snapshot lists the other commands");
  JsonWriter json;
  write_entry(json, *stop).key("unconfirmed").begin_array();
  if (line.unconfirmed)
    for (const std::string& name : line.unconfirmed(id)) json.value(name);
  json.end_array().end_object();
  return json_response(json.take());
}

HttpResponse get_command(CallContext& context, const Call& call) {
  return stop_progress(*context.stops(), context.host().stop_line, call.arguments[0]);
}

}  // namespace cosiva::app
