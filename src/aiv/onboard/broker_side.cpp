// What the on-board program makes of the broker's messages: orders, instant actions, the server's life signs.
#include <cmath>
#include <utility>

#include "aiv/onboard/inside.h"
#include "base/json_value.h"
#include "wire/vda5050/codec.h"
#include "wire/vda5050/said.h"

namespace cosiva::aiv {

void OnboardCore::Inside::on_server_connection(const wire::Input& input, wire::Effects& effects) {
  constexpr std::size_t bytes_max = 4096;
  const auto json = JsonValue::parse(input.payload, bytes_max);
  const auto word = json ? json->text("connectionState") : std::nullopt;
  if (!word) {
    log(effects, 'w', "the server's connection message says nothing");
    return;
  }
  if (*word == wire::vda5050::to_string(wire::ConnectionState::offline)) {
    supervision.server_left();
    if (felt) felt->forget();
  }
}

void OnboardCore::Inside::on_order(const wire::Input& input, wire::Effects& effects) {
  const auto order = wire::vda5050::heard_order(input);
  if (!order) return refuse("validationError", "order", to_string(order.error()), {}, effects);
  std::vector<wire::Reference> references{{"topic", "order"},
                                          {"headerId", std::to_string(order->header.header_id)},
                                          {"orderId", order->order_id},
                                          {"orderUpdateId", std::to_string(order->order_update_id)}};
  if (auto accepted = session.accepts(order->header); !accepted)
    return refuse("validationError", "order", to_string(accepted.error()), std::move(references), effects);
  if (!agent) return refuse("noRouteError", "order", "no zone is known yet", std::move(references), effects);
  const bool repeated =
      order->order_id == agent->order().order_id() && order->order_update_id == agent->order().order_update_id();
  if (coming_zone && !repeated) {
    return refuse("noRouteError", "order", "zone '" + coming_zone->zone().name + "' follows as soon as it stands",
                  std::move(references), effects);
  }

  const auto verdict = agent->take_order(*order);
  state_due = true;  // the state's orderUpdateId is the only acknowledgement, also of a repetition
  if (!verdict)
    return refuse(verdict.error().code, "order", to_string(verdict.error()), std::move(references), effects);
  if (*verdict == OrderBook::Verdict::accepted_new) {
    warnings.on_new_order();
    actions.on_new_order();
    log(effects, 'i', "order " + order->order_id + " from " + order->nodes.front().node_id);
  } else if (*verdict == OrderBook::Verdict::accepted_update) {
    warnings.on_update();
  }
  // At a slow pace a tick is far away, and somebody may wait for this one to go.
  if (options.cycle > usual_cycle && *verdict != OrderBook::Verdict::ignored_same) drive(effects);
}

void OnboardCore::Inside::refuse(std::string type, std::string_view topic, std::string why,
                                 std::vector<wire::Reference> references, wire::Effects& effects) {
  log(effects, 'w', std::string(topic) + " refused, " + type + ": " + why);
  if (references.empty()) references.push_back({"topic", std::string(topic)});
  warnings.add(std::move(type), std::move(why), std::move(references));
  state_due = true;
}

void OnboardCore::Inside::on_instant_actions(const wire::Input& input, wire::Effects& effects) {
  const auto message = wire::vda5050::decode_instant_actions(input.payload);
  if (!message) return refuse("validationError", "instantActions", to_string(message.error()), {}, effects);
  if (auto accepted = session.accepts(message->header); !accepted) {
    return refuse("validationError", "instantActions", to_string(accepted.error()),
                  {{"topic", "instantActions"}, {"headerId", std::to_string(message->header.header_id)}}, effects);
  }
  for (const wire::Action& action : message->actions) {
    state_due = true;
    if (actions.begin(action)) perform(action, effects);
  }
}

void OnboardCore::Inside::give_up(const wire::Action& action, std::string type, std::string why,
                                  wire::Effects& effects) {
  actions.set(action.action_id, wire::ActionStatus::failed, why);
  refuse(std::move(type), "instantActions", std::move(why),
         {{"actionId", action.action_id}, {"actionType", action.action_type}}, effects);
}

void OnboardCore::Inside::perform(const wire::Action& action, wire::Effects& effects) {
  const std::string_view type = action.action_type;
  if (type == action::state_request) return finish(action);
  if (!agent) return give_up(action, "instantActionError", "no zone is known yet", effects);
  if (type == action::start_pause) return start_pause(action);
  if (type == action::stop_pause) return stop_pause(action);
  if (type == action::cancel_order) return cancel_order(action, effects);
  if (type == action::init_position) return init_position(action, effects);
  if (type == action::set_speed_limit) return set_speed_limit(action, effects);
  if (type == action::enable_map || type == action::download_map) return enable_map(action, effects);
  if (type == action::join_line) return join_line(action, effects);
  if (type == action::back_up) return back_up(action, effects);
  if (type == action::factsheet_request) {
    publish_factsheet(now, effects);
    return finish(action);
  }
  give_up(action, "instantActionError", "action '" + action.action_type + "' is not supported", effects);
}

void OnboardCore::Inside::start_pause(const wire::Action& action) {
  agent->hold(Hold::paused, true);
  actions.set(action.action_id, wire::ActionStatus::running);
  end_waits();
  must_remember = true;
}

void OnboardCore::Inside::stop_pause(const wire::Action& action) {
  agent->hold(Hold::paused, false);
  actions.end_running(action::start_pause, wire::ActionStatus::failed, "overtaken by stopPause");
  finish(action);
  must_remember = true;
}

void OnboardCore::Inside::cancel_order(const wire::Action& action, wire::Effects& effects) {
  if (!agent->begin_cancel()) return give_up(action, "noOrderToCancel", "there is no order to cancel", effects);
  actions.set(action.action_id, wire::ActionStatus::running);
}

std::optional<Pose2> OnboardCore::Inside::pose_told(const wire::Action& action, wire::Effects& effects) {
  const auto x = action.number("x");
  const auto y = action.number("y");
  const auto theta = action.number("theta");
  if (x && y && theta && std::isfinite(*x) && std::isfinite(*y) && std::isfinite(*theta))
    return Pose2{*x, *y, wrap_angle(*theta)};
  give_up(action, "instantActionError", action.action_type + " needs the numbers x, y and theta", effects);
  return std::nullopt;
}

void OnboardCore::Inside::join_line(const wire::Action& action, wire::Effects& effects) {
  const auto X_MG = pose_told(action, effects);
  if (!X_MG) return;
  const auto joins = agent->join_line(*X_MG);
  if (!joins) return give_up(action, "instantActionError", joins.error().message, effects);
  actions.end_running(action::join_line, wire::ActionStatus::failed, "overtaken by another joinLine");
  actions.set(action.action_id, wire::ActionStatus::running);
}

void OnboardCore::Inside::back_up(const wire::Action& action, wire::Effects& effects) {
  const auto distance_m = action.number("distance");
  if (!distance_m) return give_up(action, "instantActionError", "backUp needs the number distance", effects);
  const auto backs = agent->back_up(*distance_m);
  if (!backs) return give_up(action, "instantActionError", backs.error().message, effects);
  actions.end_running(action::back_up, wire::ActionStatus::failed, "overtaken by another backUp");
  if (!agent->backing_up()) return finish(action);
  actions.set(action.action_id, wire::ActionStatus::running);
}

void OnboardCore::Inside::init_position(const wire::Action& action, wire::Effects& effects) {
  const auto map_id = action.text("mapId");
  const auto X_MB = pose_told(action, effects);
  if (!X_MB) return;
  if (map_id && !map_id->empty() && *map_id != zone->name) {
    return give_up(action, "instantActionError", "map '" + *map_id + "' is not '" + zone->name + "'", effects);
  }
  const auto done = agent->initialise_position(*X_MB, action.text("lastNodeId").value_or(""));
  if (!done) return give_up(action, "instantActionError", done.error().message, effects);
  memory.reset();
  must_remember = true;
  finish(action);
}

void OnboardCore::Inside::set_speed_limit(const wire::Action& action, wire::Effects& effects) {
  const auto word = action.text("profile");
  const auto speed_mps = action.number("maxSpeed");
  if (word) {
    const auto profile = parse_profile(*word);
    if (*word != "normal" && (!profile || *profile == Profile::stop)) {
      return give_up(action, "instantActionError", "profile '" + *word + "', expected slow, medium, fast or normal",
                     effects);
    }
    agent->impose(profile);
    agent->limit_speed(std::nullopt);
  } else if (!speed_mps) {
    return give_up(action, "instantActionError", "setSpeedLimit needs profile or maxSpeed", effects);
  }
  if (speed_mps) {
    if (!(*speed_mps > 0.0 && std::isfinite(*speed_mps)))
      return give_up(action, "instantActionError", "maxSpeed is a positive number of m/s", effects);
    agent->limit_speed(*speed_mps);
  }
  must_remember = true;
  finish(action, agent->imposed() ? std::string(to_string(*agent->imposed())) : "normal");
}

void OnboardCore::Inside::end_waits() {
  if (agent->standing() && agent->holds(Hold::paused) && actions.running(action::start_pause)) {
    actions.end_running(action::start_pause, wire::ActionStatus::finished);
    state_due = true;
  }
  if (!agent->joining() && actions.running(action::join_line)) {
    const bool there = !agent->position().off_line();
    actions.end_running(action::join_line, there ? wire::ActionStatus::finished : wire::ActionStatus::failed,
                        there ? "" : "it was given up on the way");
    state_due = true;
  }
  if (!agent->backing_up() && actions.running(action::back_up)) {
    const bool there = agent->backed_up();
    actions.end_running(action::back_up, there ? wire::ActionStatus::finished : wire::ActionStatus::failed,
                        there ? "" : "it came to an end before it was there");
    state_due = true;
  }
  if (!agent->cancelling() && actions.running(action::cancel_order)) {
    actions.end_running(action::cancel_order, wire::ActionStatus::finished);
    state_due = true;
  }
}

}  // namespace cosiva::aiv
