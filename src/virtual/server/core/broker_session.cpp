#include "cosiva/virtual/server/core/broker_session.h"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/wire/own/v2x.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration sync_time_min{std::chrono::milliseconds{300}};
constexpr SimDuration sync_time_max{std::chrono::seconds{2}};

std::string connection_json(std::string_view state, SimTime now) {
  JsonWriter json;
  json.begin_object().field("connectionState", state).field("timestamp", to_iso8601(now)).end_object();
  return json.take();
}

}  // namespace

void BrokerSession::on_link(bool up) {
  if (up == context_.link.up()) return;
  if (up)
    context_.link.came_up(context_.now);
  else
    context_.link.went_down();
  augmented_.hosted.link(context_.now, up);
  if (up) return came_up();
  zones_.link_went_down();
  context_.publisher.log('w', "lost the connection to the broker; vehicles stop by themselves until it is restored");
}

void BrokerSession::came_up() {
  zones_.link_came_up();
  context_.areas.link_up();
  instruments_.batteries.link_up();
  for (AivProxy& proxy : context_.registry) proxy.reported_state.on_link_up();
  std::string online = connection_json("ONLINE", context_.now);
  const std::string& topic = context_.topics.connection;
  context_.traces.add(context_.now, "AIV_Server", "*", "connection", "ONLINE", topic, online);
  augmented_.hosted.message(context_.now, std::string(wire::server_connection_topic), online);
  context_.publisher.publish(topic, std::move(online), 1, true);
  zones_.publish_own();
}

void BrokerSession::send_heartbeat() {
  auto heartbeat = context_.link.take_heartbeat(context_.now);
  if (!heartbeat) return;
  const std::string& topic = context_.topics.heartbeat;
  context_.traces.add(context_.now, "AIV_Server", "*", "heartbeat", *heartbeat, topic, *heartbeat);
  // A hosted AIV receives the heartbeat without the broker, and yet has to brake like the others when the broker is
  // frozen. The reports of the vehicles return from a broker that is alive, at least those of the hosted AIV itself.
  if (context_.link.take_message_received())
    augmented_.hosted.message(context_.now, std::string(wire::server_heartbeat_topic), *heartbeat);
  context_.publisher.publish(topic, std::move(*heartbeat), 0, false);
}

void BrokerSession::synchronise_if_due() {
  if (!context_.link.up()) return;
  const bool begins = !context_.link.synchronised();
  if (begins && !is_synchronisation_due()) return;
  if (begins) context_.link.set_synchronised();
  if (begins && context_.areas.several()) {
    augmented_.restored.clear();
    ownership_.publish_lost_owners();
  }
  world_.put_restored();  // the zone may become known later than the vehicles
  if (begins) world_.sign_off_orphans();
  COSIVA_EXPECT(context_.link.synchronised());
}

bool BrokerSession::is_synchronisation_due() const {
  const SimDuration since = context_.now - context_.link.up_since();
  if (since >= sync_time_max) return true;
  if (since < sync_time_min) return false;
  // A vehicle that drives on an order of an earlier process must report before any vehicle is sent across its path.
  return std::ranges::all_of(context_.registry, [](const AivProxy& proxy) {
    return proxy.retired() || proxy.connection.state() != wire::ConnectionState::online ||
           proxy.reported_state.since_link();
  });
}

wire::Will BrokerSession::will() const {
  return {{context_.topics.connection, connection_json("CONNECTIONBROKEN", context_.now), 1, true}};
}

void BrokerSession::farewell(SimTime now, wire::Effects& effects) {
  context_.publisher.open(now, effects);
  augmented_.hosted.farewell(now);
  effects.emplace_back(wire::Publish{context_.topics.connection, connection_json("OFFLINE", now), 1, true});
  context_.traces.add(now, "AIV_Server", "*", "connection", "OFFLINE");
}

std::vector<std::string> BrokerSession::subscriptions() const {
  const std::string& prefix = context_.topic_prefix;
  const std::string hosted = prefix + "v2/" + std::string(wire::virtual_manufacturer) + "/+/";
  std::vector<std::string> filters{prefix + "+/+/+/state",
                                   prefix + "+/+/+/visualization",
                                   prefix + "+/+/+/connection",
                                   prefix + "+/+/+/factsheet",
                                   wire::topics_below(wire::zone_topic_prefix, 1),
                                   wire::topics_below(wire::virtual_obstacles_ack_topic_prefix, 2),
                                   wire::topics_below(wire::detected_obstacle_topic_prefix, 2),
                                   wire::topics_below(wire::boards_topic_prefix, 2),
                                   wire::topics_below(wire::v2x_topic_prefix, wire::v2x_topic_levels),
                                   hosted + "order",
                                   hosted + "instantActions"};
  std::ranges::move(BatteryTestRelay::subscriptions(), std::back_inserter(filters));
  std::ranges::move(GroundTruthComparator::subscriptions(), std::back_inserter(filters));
  std::ranges::move(CrossingUnits::subscriptions(), std::back_inserter(filters));
  if (!context_.areas.several()) return filters;
  // The server's own zone is received with the zones of the other areas.
  std::erase(filters, wire::topics_below(wire::zone_topic_prefix, 1));
  const std::string area{wire::area_topic_prefix};
  filters.insert(filters.end(),
                 {area + "+/zone/+", area + "+/server/connection", wire::topics_below(wire::owner_topic_prefix, 2)});
  return filters;
}

}  // namespace cosiva::virtual_side
