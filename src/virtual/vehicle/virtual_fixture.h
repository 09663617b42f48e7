#pragma once

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/virtual/vehicle/virtual_aiv.h"
#include "cosiva/wire/own/link_check.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/vda5050/codec.h"

namespace cosiva::virtual_side::test {

/// A virtual AIV, the ticks of its host, and a server that sends heartbeats. Every publication is decoded; a message
/// that cannot be decoded, or that no other party expects, is counted.
class VirtualFixture {
 public:
  /// @param zone  made from the configuration; must outlive the fixture
  VirtualFixture(const zone::ZoneConfiguration& configuration, const zone::TrafficZone& zone, zone::TrackPosition start)
      : aiv{"V1", 1001, std::make_shared<const zone::Rtm>(zone::Rtm::initialise(configuration).value()), start},
        first_zone_{zone} {
    aiv.link(now, true, effects_);
    take();
  }

  void step() {
    now += std::chrono::milliseconds{20};
    if (server_heartbeats && ++steps_ % 5 == 0) receive(std::string(wire::server_heartbeat_topic), R"({"headerId":1})");
    aiv.tick(now, effects_);
    take();
  }
  void run(double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * 50.0)); ++i) step();
  }
  bool run_until(const std::function<bool()>& done, double seconds) {
    for (int i = 0; i < static_cast<int>(std::lround(seconds * 50.0)) && !done(); ++i) step();
    return done();
  }

  void receive(const std::string& topic, const std::string& payload) {
    aiv.message(now, topic, payload, effects_);
    take();
  }
  void order(const std::vector<std::string>& node_ids, const std::string& id = "O-1") {
    wire::Order text = aiv::test::order(id).through(node_ids);
    text.header.manufacturer = aiv.id().manufacturer;
    text.header.serial_number = aiv.id().serial_number;
    receive(wire::vda_topic(aiv.id(), "order"), wire::vda5050::encode(text));
  }
  /// The last waypoint of the first zone behind the vehicle's track position; another zone may have such a track
  /// position, too.
  [[nodiscard]] std::string waypoint_behind() const {
    return first_zone_.waypoints[first_zone_.waypoint_behind(aiv.track_position())].id;
  }
  void ahead(std::vector<wire::Body> bodies) {
    receive(wire::own_topic(wire::virtual_obstacles_topic_prefix, aiv.id()),
            to_json(wire::VirtualObstacles{++aheads_, now, first_zone_.name, std::move(bodies)}));
  }
  void zone(const zone::ZoneConfiguration& configuration) {
    auto rtm = zone::Rtm::initialise(configuration);
    ASSERT_TRUE(rtm) << to_string(rtm.error());
    aiv.zone(now, std::make_shared<const zone::Rtm>(std::move(*rtm)), effects_);
    take();
  }
  void farewell() {
    aiv.farewell(now, effects_);
    take();
  }

  [[nodiscard]] const wire::State& state() const { return states.back(); }
  /// Distance from the estimated to the actual position.
  [[nodiscard]] double estimate_error_m() const {
    if (visualizations.empty() || !visualizations.back().position) return 1e3;
    return distance(visualizations.back().position->pose, aiv.X_MB());
  }
  [[nodiscard]] std::string digest() const {
    Digest digest;
    aiv.fold(digest);
    return digest.hex();
  }

  SimTime now{virtual_epoch};
  VirtualAiv aiv;
  bool server_heartbeats{true};
  std::vector<wire::State> states;
  std::vector<wire::Visualization> visualizations;
  std::vector<wire::Connection> connections;
  std::vector<wire::Factsheet> factsheets;
  std::vector<wire::VirtualObstaclesAck> felts;
  std::vector<wire::BoardsReport> reports;
  std::vector<wire::Log> logs;
  std::vector<wire::Intent> intents;
  std::vector<std::string> listens;  ///< its subscriptions besides those that the server handles
  std::vector<std::string> strange;  ///< unexpected effects

 private:
  template <typename Message>
  void keep(Result<Message> read, std::vector<Message>& all, const std::string& topic) {
    if (read)
      all.push_back(std::move(*read));
    else
      strange.push_back(topic + ": " + to_string(read.error()));
  }
  void take() {
    for (const wire::Effect& effect : effects_) {
      if (const auto* publish = std::get_if<wire::Publish>(&effect))
        take(*publish);
      else if (const auto* line = std::get_if<wire::Log>(&effect))
        logs.push_back(*line);
      else if (const auto* listen = std::get_if<wire::Listen>(&effect))
        listens = listen->filters;
      else
        strange.emplace_back("an effect of kind " + std::to_string(effect.index()));
    }
    effects_.clear();
  }
  void take(const wire::Publish& publish) {
    namespace vda = wire::vda5050;
    const std::string& topic = publish.topic;
    if (topic == wire::vda_topic(aiv.id(), "state")) return keep(vda::decode_state(publish.payload), states, topic);
    if (topic == wire::vda_topic(aiv.id(), "visualization"))
      return keep(vda::decode_visualization(publish.payload), visualizations, topic);
    if (topic == wire::vda_topic(aiv.id(), "connection"))
      return keep(vda::decode_connection(publish.payload), connections, topic);
    if (topic == wire::vda_topic(aiv.id(), "factsheet"))
      return keep(vda::decode_factsheet(publish.payload), factsheets, topic);
    if (topic == wire::own_topic(wire::virtual_obstacles_ack_topic_prefix, aiv.id()))
      return keep(wire::virtual_obstacles_ack_from_json(publish.payload), felts, topic);
    if (topic == wire::own_topic(wire::boards_topic_prefix, aiv.id()))
      return keep(wire::boards_report_from_json(publish.payload), reports, topic);
    if (topic == wire::own_topic(wire::link_check_topic_prefix, aiv.id())) return;  // its broker is not part of this
    if (wire::parse_v2x_topic(topic)) return keep(wire::intent_from_json(publish.payload), intents, topic);
    strange.push_back("unexpected topic " + topic);
  }

  const zone::TrafficZone& first_zone_;
  wire::Effects effects_;
  int steps_{0};
  std::uint32_t aheads_{0};
};

}  // namespace cosiva::virtual_side::test
