#include "cosiva/aiv/onboard/onboard_options.h"

#include <cmath>

#include "cosiva/base/json_value.h"
#include "cosiva/base/json_writer.h"

namespace cosiva::aiv {
namespace {

constexpr std::string_view finish_base_text = "finish-base";
constexpr std::string_view negotiate_text = "negotiate";

auto bad(std::string field, std::string expected) {
  return fail("options.field", "expected " + std::move(expected), std::move(field));
}

Result<OnboardOptions::Start> start_from(const JsonValue& json) {
  const auto section = json.text("section");
  const auto s_m = json.number("s_m");
  if (!section || !s_m || !std::isfinite(*s_m)) return bad("start", "an object with section and s_m");
  return OnboardOptions::Start{*section, *s_m};
}

/// Absent from journals recorded before there were these fields, as from those of a vehicle with the defaults.
Result<void> read_direct_link(const JsonValue& json, OnboardOptions& options) {
  options.v2x_direct = json.flag("v2xDirect").value_or(false);
  if (const JsonValue* autonomy = json.find("autonomy")) {
    const std::string* text = autonomy->text();
    if (text == nullptr || *text != negotiate_text || !options.v2x_direct)
      return bad("autonomy", "\"negotiate\" with v2xDirect, or no such field");
    options.autonomy = Autonomy::negotiate;
  }
  const JsonValue* link_loss = json.find("linkLoss");
  if (link_loss == nullptr) return {};
  const std::string* text = link_loss->text();
  if (text == nullptr || *text != finish_base_text) return bad("linkLoss", "\"finish-base\", or no such field");
  options.link_loss = LinkLoss::finish_base;
  return {};
}

/// Reads a duration in milliseconds, if the field is there.
Result<void> read_ms(const JsonValue& json, std::string_view field, SimDuration& duration) {
  const JsonValue* value = json.find(field);
  if (value == nullptr) return {};
  constexpr double ms_max = 3'600'000.0;
  const double* ms = value->number();
  if (ms == nullptr || !(*ms >= 1.0 && *ms <= ms_max)) return bad(std::string(field), "milliseconds from 1 to 3600000");
  duration = from_seconds(*ms * 1e-3);
  return {};
}

}  // namespace

std::string to_json(const OnboardOptions& options) {
  JsonWriter json;
  json.begin_object().field("number", options.number).field("manufacturer", options.id.manufacturer);
  json.field("serialNumber", options.id.serial_number).field("interfaceName", options.interface_name);
  if (options.zone) zone::write_json(json.key("zone"), *options.zone);
  if (options.start) {
    json.key("start").begin_object().field("section", options.start->section);
    json.field("s_m", options.start->s_m).end_object();
  }
  write_json(json.key("rules"), options.rules);
  if (options.actions != usual_actions()) write_json(json.key("actions"), options.actions);
  json.field("rali", options.rali).field("v2x", options.v2x);
  if (options.v2x_direct) json.field("v2xDirect", true);
  if (options.link_loss == LinkLoss::finish_base) json.field("linkLoss", finish_base_text);
  if (options.autonomy == Autonomy::negotiate) json.field("autonomy", negotiate_text);
  json.field("cycle_ms", to_milliseconds_by_seconds(options.cycle))
      .field("visualization_period_ms", to_milliseconds_by_seconds(options.visualization_period))
      .field("state_period_ms", to_milliseconds_by_seconds(options.state_period))
      .field("link_timeout_ms", to_milliseconds_by_seconds(options.link_timeout));
  return json.end_object().take();
}

Result<OnboardOptions> onboard_options_from_json(std::string_view json) {
  const auto value = JsonValue::parse(json);
  if (!value) return tl::unexpected(value.error());
  if (value->object() == nullptr) return bad("", "an object");
  OnboardOptions options;
  if (const JsonValue* number = value->find("number")) {
    const double* n = number->number();
    if (n == nullptr || !(*n >= 1.0 && *n <= 1e6) || std::floor(*n) != *n)
      return bad("number", "a whole number from 1");
    options.number = static_cast<std::uint32_t>(*n);
  }
  options.id.manufacturer = value->text("manufacturer").value_or(options.id.manufacturer);
  options.id.serial_number = value->text("serialNumber").value_or("AIV" + std::to_string(options.number));
  if (!wire::valid_serial_number(options.id.serial_number))
    return bad("serialNumber", "letters, digits and _ . : - only");
  options.interface_name = value->text("interfaceName").value_or(options.interface_name);
  if (options.id.manufacturer.empty() || options.interface_name.empty())
    return bad("manufacturer, interfaceName", "texts that are not empty");
  if (const JsonValue* zone = value->find("zone"); zone != nullptr && !zone->is_null()) {
    auto read = zone::zone_configuration_from_json(*zone);
    if (!read) return tl::unexpected(read.error());
    options.zone = std::move(*read);
  }
  if (const JsonValue* start = value->find("start"); start != nullptr && !start->is_null()) {
    auto read = start_from(*start);
    if (!read) return tl::unexpected(read.error());
    options.start = std::move(*read);
  }
  if (const JsonValue* rules = value->find("rules"); rules != nullptr && !rules->is_null()) {
    auto read = speed_rules_from_json(*rules);
    if (!read) return tl::unexpected(read.error());
    options.rules = std::move(*read);
  }
  if (const JsonValue* actions = value->find("actions"); actions != nullptr && !actions->is_null()) {
    auto read = action_catalogue_from_json(*actions);
    if (!read) return tl::unexpected(read.error());
    options.actions = std::move(*read);
  }
  options.rali = value->flag("rali").value_or(true);
  // Without the field: a journal from before V2X.
  options.v2x = value->flag("v2x").value_or(false);
  for (auto read : {read_direct_link(*value, options), read_ms(*value, "cycle_ms", options.cycle),
                    read_ms(*value, "visualization_period_ms", options.visualization_period),
                    read_ms(*value, "state_period_ms", options.state_period),
                    read_ms(*value, "link_timeout_ms", options.link_timeout)}) {
    if (!read) return tl::unexpected(read.error());
  }
  return options;
}

}  // namespace cosiva::aiv
