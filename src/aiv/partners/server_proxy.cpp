#include "cosiva/aiv/partners/server_proxy.h"

#include <algorithm>
#include <utility>
#include <variant>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"
#include "cosiva/wire/in_process/typed_message.h"
#include "cosiva/wire/own/estimate_exchange.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::aiv {

namespace vda = wire::vda5050;

namespace {

template <typename Message>
wire::Publish as_value(const std::string& topic, Message&& message) {
  wire::Publish publish{topic, {}, 0, false};
  publish.typed = wire::typed(std::forward<Message>(message));
  return publish;
}

ServerProxyTopics topics_of(const wire::VehicleId& id, std::string_view interface_name) {
  return {
      .order = wire::vda_topic(id, "order", interface_name),
      .instant_actions = wire::vda_topic(id, "instantActions", interface_name),
      .virtual_obstacles = wire::own_topic(wire::virtual_obstacles_topic_prefix, id),
      .owner = wire::own_topic(wire::owner_topic_prefix, id),
      .estimate_request = wire::own_topic(wire::estimate_request_topic_prefix, id),
      .battery_change = wire::own_topic(wire::battery_change_topic_prefix, id),
      .battery_fitted = wire::own_topic(wire::battery_fitted_topic_prefix, id),
      .link_check = wire::own_topic(wire::link_check_topic_prefix, id),
      .connection = wire::vda_topic(id, "connection", interface_name),
      .state = wire::vda_topic(id, "state", interface_name),
      .visualization = wire::vda_topic(id, "visualization", interface_name),
      .factsheet = wire::vda_topic(id, "factsheet", interface_name),
      .virtual_obstacles_ack = wire::own_topic(wire::virtual_obstacles_ack_topic_prefix, id),
      .estimate_response = wire::own_topic(wire::estimate_response_topic_prefix, id),
      .detected_obstacle = wire::own_topic(wire::detected_obstacle_topic_prefix, id),
      .boards = wire::own_topic(wire::boards_topic_prefix, id),
      .battery_ready = wire::own_topic(wire::battery_ready_topic_prefix, id),
  };
}

}  // namespace

ServerProxy::ServerProxy(wire::VehicleId id, std::string_view interface_name, bool as_values)
    : id_{std::move(id)}, as_values_{as_values}, topics_{topics_of(id_, interface_name)} {}

wire::Header ServerProxy::header(SimTime now, std::uint32_t header_id) const {
  return {header_id, now, std::string(vda::version), id_.manufacturer, id_.serial_number};
}

wire::Will ServerProxy::will(SimTime now) const {
  const wire::Connection last_will{header(now, next_.connection), wire::ConnectionState::connection_broken};
  return {wire::Publish{topics_.connection, vda::encode(last_will), 1, true}};
}

void ServerProxy::publish(SimTime now, wire::ConnectionState state, wire::Effects& effects) {
  if (!online_) return;
  const wire::Connection connection{header(now, next_.connection++), state};
  send({topics_.connection, vda::encode(connection), 1, true}, effects);
}

void ServerProxy::publish(SimTime now, wire::State&& state, wire::Effects& effects) {
  if (!online_) return;
  state.header = header(now, next_.state++);
  if (as_values_) return send(as_value(topics_.state, std::move(state)), effects);
  send({topics_.state, vda::encode(state), 0, false}, effects);
}

void ServerProxy::publish(SimTime now, wire::Visualization&& visualization, wire::Effects& effects) {
  if (!online_) return;
  visualization.header = header(now, next_.visualization++);
  if (as_values_) return send(as_value(topics_.visualization, std::move(visualization)), effects);
  send({topics_.visualization, vda::encode(visualization), 0, false}, effects);
}

void ServerProxy::publish(SimTime now, wire::Factsheet&& factsheet, wire::Effects& effects) {
  if (!online_) return;
  factsheet.header = header(now, next_.factsheet++);
  send({topics_.factsheet, vda::encode(factsheet), 0, true}, effects);
}

void ServerProxy::publish(const wire::VirtualObstaclesAck& perceived, wire::Effects& effects) {
  if (online_) send({topics_.virtual_obstacles_ack, to_json(perceived), 0, false}, effects);
}

void ServerProxy::publish(SimTime now, wire::DetectedObstacleReport&& detected, wire::Effects& effects) {
  if (!online_) return;
  detected.header_id = next_.detected_obstacle++;
  detected.timestamp = now;
  if (as_values_) return send(as_value(topics_.detected_obstacle, std::move(detected)), effects);
  send({topics_.detected_obstacle, to_json(detected), 0, false}, effects);
}

void ServerProxy::publish(SimTime now, wire::BoardsReport&& report, wire::Effects& effects) {
  if (!online_) return;
  report.header_id = next_.boards++;
  report.timestamp = now;
  if (as_values_) return send(as_value(topics_.boards, std::move(report)), effects);
  send({topics_.boards, to_json(report), 0, false}, effects);
}

void ServerProxy::publish(SimTime now, wire::LinkCheck&& check, wire::Effects& effects) {
  if (!online_) return;
  check.header_id = next_.link_check++;
  check.timestamp = now;
  effects.emplace_back(wire::Publish{topics_.link_check, to_json(check), 0, false});
}

void ServerProxy::publish(const wire::BatteryReady& ready, wire::Effects& effects) {
  if (online_) send({topics_.battery_ready, to_json(ready), 1, false}, effects);
}

void ServerProxy::publish_estimate(std::string&& json, wire::Effects& effects) {
  if (online_) send({topics_.estimate_response, std::move(json), 0, false}, effects);
}

void ServerProxy::send(wire::Publish&& message, wire::Effects& effects) {
  COSIVA_EXPECT(online_);
  ++sent_;
  effects.emplace_back(std::move(message));
}

ServerMessage ServerProxy::kind_of(std::string_view topic, const wire::ServerTopics& server) const {
  using enum ServerMessage;
  if (topic == server.heartbeat) return heartbeat;
  if (topic == topics_.virtual_obstacles) return virtual_obstacles;
  if (topic == topics_.order) return order;
  if (topic == topics_.instant_actions) return instant_actions;
  if (topic == server.connection) return connection;
  if (topic == topics_.estimate_request) return estimate_request;
  if (topic == topics_.battery_change) return battery_change;
  if (topic == topics_.battery_fitted) return battery_fitted;
  if (topic == topics_.owner) return owner;
  return topic.starts_with(server.zone_prefix) ? zone : none;
}

ServerMessage ServerProxy::deliver(std::string_view topic, const wire::ServerTopics& server) {
  const ServerMessage kind = kind_of(topic, server);
  if (kind != ServerMessage::none) ++delivered_;
  return kind;
}

Result<void> ServerProxy::accepts(const wire::Header& header) const {
  const wire::VehicleId named{header.manufacturer, header.serial_number};
  if (named != id_) {
    return fail("validationError", "the header names '" + to_string(named) + "', the topic '" + to_string(id_) + "'",
                "serialNumber");
  }
  // Peers write "2.1.0", "2.0.0", and even "v2".
  std::string_view version = header.version;
  if (version.starts_with('v') || version.starts_with('V')) version.remove_prefix(1);
  if (version.substr(0, version.find('.')) != "2")
    return fail("validationError", "version '" + header.version + "', expected 2.x", "version");
  return {};
}

void ServerProxy::archive(Archive& archive) { archive(online_, next_, sent_, delivered_); }

}  // namespace cosiva::aiv
