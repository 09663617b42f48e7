#include "cosiva/hmi/zone_calls.h"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <variant>

#include "cosiva/base/json_text.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/hmi/http_responses.h"
#include "cosiva/zone/layout/beacon_free.h"

namespace cosiva::app {
namespace {

using adapters::http_error;
using adapters::HttpResponse;

constexpr std::size_t zone_json_bytes_max = std::size_t{1} << 28U;

HttpResponse no_zone() {
  return http_error(409, "zone.not_now", "there is no zone yet; it comes from the physical side, or with --zone");
}

/// The name of the zone in force; empty while there is none.
std::string zone_name(const virtual_side::ServerCore& core) {
  const auto zone = core.zone();
  return zone ? zone->name : std::string{};
}

/// Whether the zone in force is not the one that the run began with.
bool switched_once(const virtual_side::ServerCore& core) {
  const auto snapshot = JsonValue::parse(core.snapshot_json(), zone_json_bytes_max);
  const JsonValue* zone = snapshot ? snapshot->find("zone") : nullptr;
  const JsonValue* switched = zone == nullptr ? nullptr : zone->find("switched");
  return switched != nullptr && !switched->is_null();
}

/// Whether a request names a zone rather than a file: neither a folder nor an ending.
bool is_plain_name(const std::string& name) {
  return !name.empty() && name.find('/') == std::string::npos && !std::filesystem::path(name).has_extension();
}

/// A zone's name as a file name: no character leads out of the folder.
std::string file_name(std::string name, const std::string& ending) {
  for (char& c : name)
    if (std::isalnum(static_cast<unsigned char>(c)) == 0 && c != '-' && c != '_' && c != '.') c = '_';
  if (name.empty() || name.front() == '.') name.insert(0, "zone");
  return name + ending;
}

HttpResponse download(std::string text, const std::string& name) {
  HttpResponse response{200, "text/plain; charset=utf-8", std::move(text), {}};
  response.headers.emplace_back("Content-Disposition", "attachment; filename=\"" + name + "\"");
  return response;
}

/// A zone that a client sends whole: with its format, or with its file's name, which determines the format.
Result<zone::ZoneConfiguration> given_zone(const JsonValue& body) {
  const auto file = body.text("file");
  const auto text = body.text("text");
  if (file && text) {
    auto format = zone::format_of_file(*file);
    if (!format) return tl::unexpected(format.error());
    return zone::ZoneConfiguration{std::move(*format), *file, *text, body.text("sidecar").value_or("")};
  }
  auto configuration = zone::zone_configuration_from_json(body);
  if (!configuration)
    configuration.error().message =
        R"(name one: {"name":"…"} of a ready zone, {"file","text","sidecar"?}, or {"format","origin","text","sidecar"?})";
  return configuration;
}

/// The revision that the given command has made.
HttpResponse revision_once_decided(CallContext& context) {
  context.respond_once_decided([&context] {
    JsonWriter json;
    json.begin_object().field("revision", context.host().core->zone_revision()).end_object();
    return json_response(json.take());
  });
  return {};
}

Result<void> give_edit(CallContext& context, const JsonValue& changes) {
  JsonWriter json;
  json.begin_object().field("command", "edit").key("edit");
  write_json(json, changes);
  json.end_object();
  return context.give(json.take());
}

HttpResponse step_zone(CallContext& context, std::string_view direction) {
  JsonWriter json;
  json.begin_object().field("command", direction).end_object();
  if (auto given = context.give(json.take()); !given) return refusal(given.error());
  return revision_once_decided(context);
}

/// What a switch has made of the zone.
HttpResponse switched(const CallContext& context, const virtual_side::DecodedCommand& command,
                      const zone::ZoneConfiguration& given) {
  const auto in_force = context.host().core->zone_configuration();
  if (!in_force || in_force->format != given.format || in_force->text != given.text ||
      in_force->sidecar != given.sidecar) {
    const auto evaluated = context.host().core->check_command(command);
    const Error why =
        evaluated ? Error{"zone.refused", "the zone that was there stays in force", {}} : evaluated.error();
    return http_error(422, why.code, to_string(why));
  }
  JsonWriter response;
  response.begin_object()
      .field("revision", context.host().core->zone_revision())
      .field("name", zone_name(*context.host().core))
      .end_object();
  return json_response(response.take());
}

/// Why the zone of a switch could not be built; null: it could.
const Error* why_not_built(const virtual_side::DecodedCommand& command) {
  if (!command.command()) return nullptr;
  const auto* to_zone = std::get_if<virtual_side::SwitchCommand>(&*command.command());
  return to_zone == nullptr || !to_zone->built || *to_zone->built ? nullptr : &to_zone->built->error();
}

/// The command of a switch that was refused already.
std::string refused_switch(const std::string& origin, const Error& why) {
  JsonWriter json;
  json.begin_object().field("command", "switch").key("refused").begin_object().field("origin", origin);
  json.field("code", why.code).field("message", why.message).field("location", why.location);
  json.end_object().end_object();
  return json.take();
}

/// The file that edits of this zone may be saved into: the one that the run was started with, while its zone is in
/// force.
std::string file_at(const CallContext& context, const zone::ZoneConfiguration& configuration) {
  if (context.host().zone_file.empty() || zone::format_of_file(context.host().zone_file) != configuration.format)
    return {};
  // After a switch to another zone the file must not be changed. A file that does not exist (any more) is written anew.
  auto there = context.host().zones->read(context.host().zone_file);
  if (!there) return context.host().zone_file;
  const auto rtm = zone::Rtm::initialise(std::move(*there));
  const bool own = rtm ? rtm->zone().name == zone_name(*context.host().core) : !switched_once(*context.host().core);
  return own ? context.host().zone_file : std::string{};
}

}  // namespace

HttpResponse list_zones(CallContext& context, const Call&) {
  const std::vector<ZoneLibrary::Entry> found = context.host().zones->zones();
  const std::string current = zone_name(*context.host().core);
  JsonWriter json;
  json.begin_object().key("zones").begin_array();
  if (!current.empty() && std::ranges::find(found, current, &ZoneLibrary::Entry::name) == found.end())
    json.begin_object().field("name", current).field("title", current).field("current", true).end_object();
  for (const ZoneLibrary::Entry& zone : found) {
    json.begin_object().field("name", zone.name).field("title", zone.title);
    json.field("current", zone.name == current).end_object();
  }
  json.end_array().end_object();
  return json_response(json.take());
}

HttpResponse get_zone_file(CallContext& context, const Call&) {
  auto configuration = context.host().core->zone_configuration();
  if (!configuration) return http_error(404, "zone.not_found", "there is no zone yet");
  return download(std::move(configuration->text),
                  file_name(zone_name(*context.host().core), context.host().zones->file_ending(configuration->format)));
}

HttpResponse get_zone_sidecar(CallContext& context, const Call&) {
  auto configuration = context.host().core->zone_configuration();
  if (!configuration) return http_error(404, "zone.not_found", "there is no zone yet");
  if (configuration->sidecar.empty())
    return http_error(404, "zone.sidecar", "this zone has no sidecar file: its own file is complete");
  return download(std::move(configuration->sidecar),
                  file_name(zone_name(*context.host().core), std::string(context.host().zones->sidecar_ending())));
}

HttpResponse suggest_beacons(CallContext& context, const Call&) {
  const auto zone = context.host().core->zone();
  if (!zone) return no_zone();
  if (!zone->beacons) return http_error(409, "zone.beacons", "this zone has no beacons, so there is no origin to move");
  const auto suggested = zone::suggest_origin(*zone);
  if (!suggested)
    return http_error(409, "zone.beacons",
                      "this zone is so large that a search would take long; try an origin by hand");
  JsonWriter json;
  json.begin_object().key("origin").begin_array().value(suggested->origin.x_m).value(suggested->origin.y_m).end_array();
  for (const auto& [key, metres] : {std::pair{"now_m", suggested->before_m}, {"longest_free_m", suggested->after_m}}) {
    json.key(key);
    if (std::isfinite(metres))
      json.value(metres);
    else
      json.null();
  }
  json.end_object();
  return json_response(json.take());
}

tl::expected<std::shared_ptr<const GivenZone>, HttpResponse> read_zone(const ZoneLibrary& zones, const Call& call) {
  Result<zone::ZoneConfiguration> configuration;
  if (const JsonValue* name = call.body.find("name")) {
    // Only ready zones: a client must not read this machine's files with this call.
    if (name->text() == nullptr || !is_plain_name(*name->text()))
      return tl::unexpected(
          http_error(400, "zone.name", R"("name" is a ready zone's, as GET /api/v1/zones lists them)"));
    configuration = zones.load(*name->text());
    if (!configuration)
      return tl::unexpected(http_error(404, configuration.error().code, to_string(configuration.error())));
  } else {
    configuration = given_zone(call.body);
    if (!configuration)
      return tl::unexpected(http_error(400, configuration.error().code, configuration.error().message));
  }
  JsonWriter json;
  zone::write_json(json.begin_object().field("command", "switch").key("zone"), *configuration);
  json.end_object();
  GivenZone given{std::move(*configuration), json.take(), {}};
  given.decoded =
      std::make_shared<const virtual_side::DecodedCommand>(given.command, virtual_side::DecodedCommand::Zone::built);
  if (const Error* why = why_not_built(*given.decoded)) {
    // The core shows the reason; a long text that is no zone would only delay it.
    given.command = refused_switch(given.configuration.origin, *why);
    given.decoded = std::make_shared<const virtual_side::DecodedCommand>(given.command);
  }
  return std::make_shared<const GivenZone>(std::move(given));
}

HttpResponse switch_zone(CallContext& context, const Call& call) {
  // The core also publishes on the page why it refuses; only then is it queried again.
  context.give_unchecked(call.zone->command, call.zone->decoded);
  context.respond_once_decided(
      [&context, given = call.zone] { return switched(context, *given->decoded, given->configuration); });
  return {};
}

HttpResponse edit_zone(CallContext& context, const Call& call) {
  if (call.body.object()->empty())
    return http_error(400, "edit.empty",
                      R"(state what to change: "addTags", "moveTags", "removeTags", "beaconPitch" or "priorities")");
  if (const auto given = give_edit(context, call.body); !given) return refusal(given.error());
  return revision_once_decided(context);
}

HttpResponse put_priorities(CallContext& context, const Call& call) {
  JsonValue::Object changes;
  changes.emplace_back("priorities", call.body);
  // A second identical request changes nothing.
  if (const auto given = give_edit(context, JsonValue{std::move(changes)});
      !given && given.error().code != "edit.nothing")
    return refusal(given.error());
  return json_response("{}");
}

HttpResponse undo_zone(CallContext& context, const Call&) { return step_zone(context, "undo"); }
HttpResponse redo_zone(CallContext& context, const Call&) { return step_zone(context, "redo"); }

HttpResponse save_zone(CallContext& context, const Call&) {
  const auto configuration = context.host().core->zone_configuration();
  if (!configuration) return no_zone();
  std::string file = file_at(context, *configuration);
  if (file.empty()) {
    const auto folder = context.host().zones->edits_folder();
    if (!folder) return http_error(500, "zone.save", folder.error().message);
    file = *folder + "/" +
           file_name(zone_name(*context.host().core), context.host().zones->file_ending(configuration->format));
  }
  if (auto written = context.host().zones->write(file, *configuration); !written)
    return http_error(500, "zone.save",
                      "the zone could not be written to " + file + ": " + written.error().message +
                          "; nothing is saved, the edits stay in force");
  // After saving, there are no unsaved edits.
  (void)context.give(R"({"command":"saved"})");
  JsonWriter json;
  json.begin_object().field("file", file).end_object();
  return json_response(json.take());
}

}  // namespace cosiva::app
