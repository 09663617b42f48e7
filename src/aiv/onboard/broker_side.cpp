// What the on-board program makes of the broker's messages: zone, orders, instant actions, the server's life signs.
#include <cmath>
#include <utility>

#include "aiv/onboard/inside.h"
#include "base/json_value.h"
#include "wire/vda5050/codec.h"
#include "zone/edit.h"

namespace cosiva::aiv {

void OnboardCore::Inside::on_zone(const wire::Input& input, wire::Effects& effects) {
  const std::string format = input.source.substr(wire::zone_topic_prefix.size());
  if (!agent) return use_zone({format, input.source, input.payload}, effects);
  if (input.payload == zone_text) return;
  const auto rtm = zone::Rtm::initialise({format, input.source, input.payload});
  if (!rtm) return log(effects, 'w', "another zone was announced and is not used: " + to_string(rtm.error()));
  if (zone::same_ways(*zone, rtm->zone())) return take_over_marks(rtm->zone(), input.payload, effects);
  log(effects, 'w', "another zone was announced; this vehicle stays in '" + zone->name + "' until it is restarted");
}

void OnboardCore::Inside::take_over_marks(const zone::TrafficZone& edited, std::string text, wire::Effects& effects) {
  // Field by field into the same object: whoever refers to the zone looks tags and beacons up when one is read.
  zone->tags = edited.tags;
  zone->beacons = edited.beacons;
  zone->stations = edited.stations;
  zone->starts = edited.starts;
  zone->priorities = edited.priorities;
  zone_text = std::move(text);
  agent->on_marks_moved();
  log(effects, 'i',
      "tags and beacons of '" + zone->name + "' as announced: " + std::to_string(zone->tags.size()) + " tags");
}

void OnboardCore::Inside::use_zone(const zone::ZoneConfiguration& configuration, wire::Effects& effects) {
  auto rtm = zone::Rtm::initialise(configuration);
  if (!rtm) {
    log(effects, 'e', "zone not used: " + to_string(rtm.error()));
    return;
  }
  zone = std::make_shared<zone::TrafficZone>(rtm->zone());
  zone_text = configuration.text;
  agent.emplace(*zone);
  felt.emplace(*zone);
  if (power) agent->on_charge(0.001 * power->charge_permille);
  if (memory) {
    agent->hold(Hold::paused, memory->paused);
    agent->impose(memory->imposed);
  }
  if (options.start && !zone->circuit.find(options.start->section))
    log(effects, 'e', "start: no section '" + options.start->section + "' in zone '" + zone->name + "'");
  publish_factsheet(now, effects);
  state_due = true;
}

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
  const auto order = wire::vda5050::decode_order(input.payload);
  if (!order) return refuse("validationError", "order", to_string(order.error()), {}, effects);
  std::vector<wire::Reference> references{{"topic", "order"},
                                          {"headerId", std::to_string(order->header.header_id)},
                                          {"orderId", order->order_id},
                                          {"orderUpdateId", std::to_string(order->order_update_id)}};
  if (auto accepted = session.accepts(order->header); !accepted)
    return refuse("validationError", "order", to_string(accepted.error()), std::move(references), effects);
  if (!agent) return refuse("noRouteError", "order", "no zone is known yet", std::move(references), effects);

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

void OnboardCore::Inside::init_position(const wire::Action& action, wire::Effects& effects) {
  const auto x = action.number("x");
  const auto y = action.number("y");
  const auto theta = action.number("theta");
  const auto map_id = action.text("mapId");
  if (!x || !y || !theta || !std::isfinite(*x) || !std::isfinite(*y) || !std::isfinite(*theta))
    return give_up(action, "instantActionError", "initPosition needs the numbers x, y and theta", effects);
  if (map_id && !map_id->empty() && *map_id != zone->name) {
    return give_up(action, "instantActionError", "map '" + *map_id + "' is not '" + zone->name + "'", effects);
  }
  const auto done = agent->initialise_position({*x, *y, wrap_angle(*theta)}, action.text("lastNodeId").value_or(""));
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
  if (!agent->cancelling() && actions.running(action::cancel_order)) {
    actions.end_running(action::cancel_order, wire::ActionStatus::finished);
    state_due = true;
  }
}

}  // namespace cosiva::aiv
