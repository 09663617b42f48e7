#include "cosiva/aiv/order/action_catalogue.h"

#include <algorithm>
#include <array>
#include <chrono>

#include "cosiva/aiv/order/instant_actions.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::aiv {
namespace {

using std::chrono::seconds;

/// The predefined actions of §6.8.1 that an order may have, and noop, which peers use to stop a vehicle at a node.
std::vector<ActionType> predefined() {
  constexpr auto none = ActionEffect::none;
  return {{"pick", ActionEffect::pick, true, true, false, true, seconds{1}, seconds{5}, "picks a load"},
          {"drop", ActionEffect::drop, true, true, false, true, seconds{1}, seconds{5}, "drops a load"},
          {std::string(action::start_charging), ActionEffect::start_charging, true, false, true, false, seconds{1},
           seconds{0}, "begins to charge; charging ends with stopCharging, or when the vehicle drives away"},
          {std::string(action::stop_charging), ActionEffect::stop_charging, true, false, true, false, seconds{1},
           seconds{0}, "ends charging"},
          {"finePositioning", none, true, true, false, true, {}, seconds{2}, "positions the vehicle exactly"},
          {"waitForTrigger",
           ActionEffect::await_trigger,
           true,
           false,
           false,
           false,
           {},
           std::nullopt,
           "waits for the instant action trigger"},
          {"detectObject", ActionEffect::detect, true, true, false, false, {}, seconds{1}, "detects an object"},
          {"noop", none, true, true, false, true, {}, seconds{0}, "has no effect"}};
}

auto bad(std::string expected) { return fail("options.actions", "expected " + std::move(expected), "actions"); }

bool handles_loads(const ActionType& type) {
  return type.effect == ActionEffect::pick || type.effect == ActionEffect::drop;
}

std::optional<SimDuration> duration_from(const JsonValue& json, std::string_view key) {
  const auto ms = json.number(key);
  if (!ms || !(*ms >= 0.0 && *ms <= 1e3 * action_s_max)) return std::nullopt;
  return from_seconds(1e-3 * *ms);
}

Result<ActionType> type_from(const JsonValue& json) {
  const auto name = json.text("name");
  const auto preparation = duration_from(json, "preparation_ms");
  if (!name || !valid_action_name(*name) || reserved_action(*name) || !preparation)
    return bad("actions with a name of their own and preparation_ms from 0 to 86400000");
  ActionType type = action_named(*name);
  type.at_nodes = json.flag("node").value_or(false);
  type.on_edges = json.flag("edge").value_or(false);
  type.preparation = *preparation;
  type.duration = duration_from(json, "duration_ms");
  const bool needs_duration = type.effect != ActionEffect::await_trigger || json.find("duration_ms") != nullptr;
  if (needs_duration && !type.duration) return bad("a duration_ms from 0 to 86400000");
  type.description = json.text("description").value_or("");
  return type;
}

}  // namespace

const ActionType* find_action(const ActionCatalogue& catalogue, std::string_view name) {
  const auto type = std::ranges::find(catalogue.types, name, &ActionType::name);
  return type == catalogue.types.end() ? nullptr : &*type;
}

Result<void> check_action(const ActionCatalogue& catalogue, const wire::Action& action, ActionScope scope) {
  const std::string named = "action '" + action.action_type + "' (" + action.action_id + ")";
  const ActionType* type = find_action(catalogue, action.action_type);
  if (type == nullptr) return fail("orderError", named + " is not supported");
  if (!(scope == ActionScope::node ? type->at_nodes : type->on_edges))
    return fail("orderError", named + " is not supported " + (scope == ActionScope::node ? "at nodes" : "on edges"));
  const auto position = action.text("lhd");
  if (handles_loads(*type) && position && !position->empty() &&
      std::ranges::find(catalogue.load_positions, *position) == catalogue.load_positions.end())
    return fail("orderError", named + ": there is no load handling device '" + *position + "'");
  return {};
}

bool block_driving(const std::vector<wire::Action>& actions) {
  return std::ranges::any_of(
      actions, [](const wire::Action& action) { return action.blocking_type != wire::BlockingType::none; });
}

ActionCatalogue usual_actions() { return {predefined(), {"deck"}}; }

ActionType action_named(std::string_view name) {
  const ActionCatalogue usual{predefined(), {}};
  if (const ActionType* type = find_action(usual, name)) return *type;
  ActionType own;
  own.name = std::string(name);
  own.duration = SimDuration::zero();
  return own;
}

bool reserved_action(std::string_view name) {
  constexpr std::array names{action::start_pause,     action::stop_pause,    action::cancel_order,
                             action::init_position,   action::state_request, action::factsheet_request,
                             action::set_speed_limit, action::enable_map,    action::download_map,
                             action::join_line,       action::back_up,       action::move,
                             action::self_test,       action::trigger};
  return std::ranges::find(names, name) != names.end();
}

void remove_impossible(ActionCatalogue& catalogue) {
  if (catalogue.load_positions.empty()) std::erase_if(catalogue.types, handles_loads);
}

bool valid_action_name(std::string_view name) { return wire::valid_serial_number(name); }

void write_json(JsonWriter& json, const ActionCatalogue& catalogue) {
  const auto ms = [](SimDuration duration) { return to_milliseconds(duration); };
  json.begin_object().key("types").begin_array();
  for (const ActionType& type : catalogue.types) {
    json.begin_object().field("name", type.name).field("node", type.at_nodes).field("edge", type.on_edges);
    json.field("preparation_ms", ms(type.preparation));
    if (type.duration) json.field("duration_ms", ms(*type.duration));
    json.field("description", type.description).end_object();
  }
  json.end_array().key("load_positions").begin_array();
  for (const std::string& position : catalogue.load_positions) json.value(position);
  json.end_array().end_object();
}

Result<ActionCatalogue> action_catalogue_from_json(const JsonValue& json) {
  const JsonValue* types = json.find("types");
  const JsonValue* positions = json.find("load_positions");
  if (types == nullptr || types->array() == nullptr || positions == nullptr || positions->array() == nullptr)
    return bad("an object with the arrays types and load_positions");
  if (types->array()->size() > action_types_max || positions->array()->size() > load_positions_max)
    return bad("at most 64 types and 16 load positions");
  ActionCatalogue catalogue;
  for (const JsonValue& each : *types->array()) {
    auto type = type_from(each);
    if (!type) return tl::unexpected(type.error());
    if (find_action(catalogue, type->name) != nullptr) return bad("each type once");
    catalogue.types.push_back(std::move(*type));
  }
  for (const JsonValue& each : *positions->array()) {
    if (each.text() == nullptr || !valid_action_name(*each.text())) return bad("names of load positions");
    if (std::ranges::find(catalogue.load_positions, *each.text()) != catalogue.load_positions.end())
      return bad("each load position once");
    catalogue.load_positions.push_back(*each.text());
  }
  remove_impossible(catalogue);
  return catalogue;
}

}  // namespace cosiva::aiv
