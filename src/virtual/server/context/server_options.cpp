// ServerOptions as JSON: the payload of the server's configure input.
#include "cosiva/virtual/server/context/server_options.h"

#include <utility>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/wire/own/control_areas.h"

namespace cosiva::virtual_side {
namespace {

auto bad(std::string_view field, std::string_view expected) {
  return fail("options.server", "expected " + std::string(expected), std::string(field));
}

/// Reads a number in (0, max] into `out`; leaves it as it is where the field is missing.
Result<void> read_positive(const JsonValue& json, std::string_view field, double max, double& out) {
  const JsonValue* found = json.find(field);
  if (found == nullptr || found->is_null()) return {};
  const double* number = found->number();
  if (number == nullptr || !(*number > 0.0 && *number <= max))
    return bad(field, "a number above 0 and at most " + std::to_string(max));
  out = *number;
  return {};
}

Result<void> read_duration(const JsonValue& json, std::string_view field, SimDuration& out) {
  double ms = to_milliseconds_by_seconds(out);
  if (auto read = read_positive(json, field, 3.6e6, ms); !read) return read;
  out = from_seconds(ms * 1e-3);
  return {};
}

/// A journal from before there were these limits lives through its time again with the fixed limit of then.
Result<void> read_limits(const JsonValue& json, ServerOptions& options) {
  constexpr std::size_t vehicles_max_then = 256;
  auto vehicles = static_cast<double>(vehicles_max_then);
  if (auto r = read_positive(json, "vehicles_max", static_cast<double>(Registry::vehicles_max_limit), vehicles); !r)
    return r;
  if (vehicles < 1.0) return bad("vehicles_max", "at least 1");
  options.vehicles_max = static_cast<std::size_t>(vehicles);
  options.entries_expire_after = SimDuration::zero();
  if (json.number("entries_expire_after_ms").value_or(0.0) != 0.0)
    if (auto r = read_duration(json, "entries_expire_after_ms", options.entries_expire_after); !r) return r;
  options.vehicle_messages_per_s_max = 0.0;
  if (json.number("vehicle_messages_per_s_max").value_or(0.0) == 0.0) return {};
  return read_positive(json, "vehicle_messages_per_s_max", 1e6, options.vehicle_messages_per_s_max);
}

Result<void> read_zone(const JsonValue& json, ServerOptions& options) {
  const JsonValue* zone = json.find("zone");
  if (zone == nullptr || zone->is_null()) return {};
  auto configuration = zone::zone_configuration_from_json(*zone);
  if (!configuration) return tl::unexpected(configuration.error());
  options.zone = std::move(*configuration);
  return {};
}

Result<void> read_contract(const JsonValue& json, BijectionContract& contract) {
  const JsonValue* found = json.find("contract");
  if (found == nullptr || found->is_null()) return {};
  if (found->object() == nullptr) return bad("contract", "an object");
  if (auto r = read_positive(*found, "divergence_p99_m", 1e3, contract.divergence_p99_m); !r) return r;
  if (auto r = read_positive(*found, "age_p99_ms", 1e7, contract.age_p99_ms); !r) return r;
  if (auto r = read_positive(*found, "command_p99_ms", 1e7, contract.command_p99_ms); !r) return r;
  if (auto r = read_positive(*found, "event_p99_ms", 1e7, contract.event_p99_ms); !r) return r;
  if (auto r = read_positive(*found, "effect_p99_ms", 1e7, contract.effect_p99_ms); !r) return r;
  return read_positive(*found, "actual_p99_m", 1e3, contract.actual_p99_m);
}

}  // namespace

std::string to_json(const ServerOptions& options) {
  JsonWriter json;
  json.begin_object().field("interface", options.interface_name);
  if (!options.area.empty()) json.field("area", options.area);
  if (options.zone) zone::write_json(json.key("zone"), *options.zone);
  json.field("drive", options.drive).field("lost_after_ms", to_milliseconds_by_seconds(options.lost_after));
  if (options.permitted_time > SimDuration::zero())
    json.field("permitted_time_ms", to_milliseconds_by_seconds(options.permitted_time));
  json.field("cycle_ms", to_milliseconds_by_seconds(options.cycle));
  json.key("contract")
      .begin_object()
      .field("divergence_p99_m", options.contract.divergence_p99_m)
      .field("age_p99_ms", options.contract.age_p99_ms)
      .field("command_p99_ms", options.contract.command_p99_ms)
      .field("event_p99_ms", options.contract.event_p99_ms)
      .field("effect_p99_ms", options.contract.effect_p99_ms)
      .field("actual_p99_m", options.contract.actual_p99_m)
      .end_object();
  json.field("vehicles_max", options.vehicles_max)
      .field("entries_expire_after_ms", to_milliseconds_by_seconds(options.entries_expire_after))
      .field("vehicle_messages_per_s_max", options.vehicle_messages_per_s_max);
  json.field("traces_max", options.traces_max).field("map_download_link", options.map_download_link);
  json.field("v2x", options.v2x).field("convoys", options.convoys).field("anticipation", options.anticipation);
  if (options.negotiated_crossings) json.field("negotiatedCrossings", true);
  aiv::write_json(json.key("virtual_rules"), options.virtual_rules);
  json.end_object();
  return json.take();
}

Result<ServerOptions> server_options_from_json(std::string_view text) {
  const auto json = JsonValue::parse(text);
  if (!json) return tl::unexpected(json.error());
  if (json->object() == nullptr) return bad("", "a JSON object with the server's options");
  ServerOptions options;
  options.interface_name = json->text("interface").value_or("");
  options.area = json->text("area").value_or("");
  if (!options.area.empty() && !wire::valid_area_name(options.area))
    return bad("area", "a name of A-Z a-z 0-9 _ . : - only, 32 at most");
  options.drive = json->flag("drive").value_or(true);
  if (auto r = read_zone(*json, options); !r) return tl::unexpected(r.error());
  if (auto r = read_duration(*json, "lost_after_ms", options.lost_after); !r) return tl::unexpected(r.error());
  // A journal from before there was a limit is replayed without it.
  options.permitted_time = {};
  if (auto r = read_duration(*json, "permitted_time_ms", options.permitted_time); !r) return tl::unexpected(r.error());
  if (auto r = read_duration(*json, "cycle_ms", options.cycle); !r) return tl::unexpected(r.error());
  if (options.cycle < std::chrono::milliseconds{1}) return bad("cycle_ms", "at least 1");
  if (auto r = read_contract(*json, options.contract); !r) return tl::unexpected(r.error());
  auto traces = static_cast<double>(options.traces_max);
  if (auto r = read_positive(*json, "traces_max", 1e7, traces); !r) return tl::unexpected(r.error());
  options.traces_max = static_cast<std::size_t>(traces);
  if (auto r = read_limits(*json, options); !r) return tl::unexpected(r.error());
  options.map_download_link = json->text("map_download_link").value_or("");
  // A journal from before there were V2X, convoys, rules or anticipation lives through its time again without them.
  options.v2x = json->flag("v2x").value_or(false);
  options.convoys = json->flag("convoys").value_or(false);
  options.anticipation = json->flag("anticipation").value_or(false);
  options.negotiated_crossings = json->flag("negotiatedCrossings").value_or(false);
  options.virtual_rules = {};
  if (const JsonValue* rules = json->find("virtual_rules"); rules != nullptr && !rules->is_null()) {
    auto read = aiv::speed_rules_from_json(*rules);
    if (!read) return tl::unexpected(read.error());
    options.virtual_rules = std::move(*read);
  }
  return options;
}

}  // namespace cosiva::virtual_side
