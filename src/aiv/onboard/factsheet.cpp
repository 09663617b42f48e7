#include "cosiva/aiv/onboard/factsheet.h"

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/aiv/order/instant_actions.h"

namespace cosiva::aiv {
namespace {

wire::Parameter number(std::string key) { return {std::move(key), std::string("NUMBER")}; }
wire::Parameter text(std::string key) { return {std::move(key), std::string("STRING")}; }

/// An action of orders, with the parameters that it uses.
wire::Factsheet::SupportedAction order_action(const ActionType& type) {
  wire::Factsheet::SupportedAction action{type.name, type.description, type.instant, type.at_nodes, type.on_edges, {}};
  switch (type.effect) {
    case ActionEffect::pick:
      action.optional_parameters = {text("lhd"), text("loadId"), text("loadType"), number("weight")};
      break;
    case ActionEffect::drop: action.optional_parameters = {text("lhd"), text("loadId"), text("loadType")}; break;
    case ActionEffect::await_trigger: action.optional_parameters = {text("triggerType")}; break;
    case ActionEffect::detect: action.optional_parameters = {text("objectType")}; break;
    case ActionEffect::start_charging:
    case ActionEffect::stop_charging:
    case ActionEffect::none: break;
  }
  action.blocking_types = {wire::BlockingType::none, wire::BlockingType::soft, wire::BlockingType::hard};
  return action;
}

}  // namespace

wire::Factsheet make_factsheet(const zone::TrafficZone& zone, const SessionTiming& timing,
                               const ActionCatalogue& catalogue) {
  const auto& [slow, medium, fast] = zone.profiles;
  wire::Factsheet sheet;
  sheet.series_name = "CoSiVA AIV";
  sheet.series_description = "Autonomous industrial vehicle, line following, " + zone.name;
  sheet.speed_max_mps = std::max({slow.speed_mps, medium.speed_mps, fast.speed_mps});
  sheet.acceleration_max_mps2 = std::max({slow.acceleration_mps2, medium.acceleration_mps2, fast.acceleration_mps2});
  sheet.deceleration_max_mps2 = std::max({slow.braking_mps2, medium.braking_mps2, fast.braking_mps2});
  sheet.height_m = 0.10;
  sheet.width_m = zone.vehicle.width_m;
  sheet.length_m = zone.vehicle.length_m;
  sheet.min_order_interval_s = 0.1;
  sheet.min_state_interval_s = to_seconds(timing.state_interval_min);
  sheet.default_state_interval_s = to_seconds(timing.state_period);
  sheet.visualization_interval_s = to_seconds(timing.visualization_period);
  const auto instant = [](std::string_view type, std::string description,
                          std::vector<wire::Parameter> parameters = {}) {
    return wire::Factsheet::SupportedAction{std::string(type),    std::move(description), true, false, false,
                                            std::move(parameters)};
  };
  sheet.actions = {
      instant(action::start_pause, "stops the vehicle until stopPause"),
      instant(action::stop_pause, "ends the pause"),
      instant(action::cancel_order, "stops the vehicle and discards the order"),
      instant(action::init_position, "sets the vehicle's position",
              {number("x"), number("y"), number("theta"), text("mapId"), text("lastNodeId")}),
      instant(action::state_request, "sends a state at once"),
      instant(action::factsheet_request, "sends the factsheet"),
      instant(action::set_speed_limit,
              "imposes a speed: profile slow, medium, fast or normal (none); or maxSpeed in m/s",
              {text("profile"), number("maxSpeed")}),
      instant(action::enable_map, "reports whether this map is in force; maps arrive by themselves",
              {text("mapId"), text("mapVersion")}),
      instant(action::self_test, "tests every board and its parts; only at standstill"),
      instant(action::join_line, "joins the path at a pose that lies along it; for an off-path vehicle",
              {number("x"), number("y"), number("theta")}),
      instant(action::move, "drives this far along the order and stops there, up to 10 m; 0 ends the limit",
              {number("distance")}),
      instant(action::back_up, "backs up along the path, by at most 0.5 m, without sensing; 0 stops the vehicle",
              {number("distance")}),
  };
  for (const ActionType& type : catalogue.types) sheet.actions.push_back(order_action(type));
  const auto waits = [](const ActionType& type) { return type.effect == ActionEffect::await_trigger; };
  if (std::ranges::any_of(catalogue.types, waits)) {
    sheet.actions.push_back(instant(action::trigger, "ends waitForTrigger; triggerType: only of this type"));
    sheet.actions.back().optional_parameters = {text("triggerType")};
  }
  sheet.load_positions = catalogue.load_positions;
  return sheet;
}

}  // namespace cosiva::aiv
