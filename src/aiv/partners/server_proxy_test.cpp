#include "cosiva/aiv/partners/server_proxy.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {
namespace {

struct ServerProxyTest : ::testing::Test {
  ServerProxy server_proxy{{"CoSiVA", "AIV1"}, wire::default_interface};
  wire::Effects effects;
  const wire::Publish& last() { return std::get<wire::Publish>(effects.back()); }
};

TEST_F(ServerProxyTest, sends_link_checks_to_itself_while_it_is_online) {
  server_proxy.publish(SimTime{}, wire::LinkCheck{}, effects);
  EXPECT_TRUE(effects.empty());
  server_proxy.set_online(true);
  server_proxy.publish(SimTime{}, wire::LinkCheck{}, effects);
  server_proxy.publish(SimTime{}, wire::LinkCheck{}, effects);
  EXPECT_EQ(last().topic, "cosiva/v1/link_check/CoSiVA/AIV1");
  EXPECT_EQ(last().topic, server_proxy.topics().link_check);
  EXPECT_EQ(last().payload, R"({"headerId":1,"timestamp":"1970-01-01T00:00:00.000Z"})");
  EXPECT_EQ(last().qos, 0);
  EXPECT_FALSE(last().retained);
}

TEST_F(ServerProxyTest, publishes_nothing_while_the_broker_is_away) {
  server_proxy.publish(SimTime{}, wire::State{}, effects);
  server_proxy.publish(SimTime{}, wire::ConnectionState::online, effects);
  EXPECT_TRUE(effects.empty());
}

TEST_F(ServerProxyTest, counts_the_headers_of_each_topic_alone) {
  server_proxy.publish(SimTime{}, wire::State{}, effects);
  server_proxy.set_online(true);
  for (const char* id : {"\"headerId\":0", "\"headerId\":1"}) {
    server_proxy.publish(SimTime{}, wire::State{}, effects);
    EXPECT_EQ(last().topic, server_proxy.topics().state);
    EXPECT_NE(last().payload.find(id), std::string::npos) << last().payload;
    server_proxy.publish(SimTime{}, wire::BoardsReport{}, effects);
    EXPECT_EQ(last().topic, server_proxy.topics().boards);
    EXPECT_NE(last().payload.find(id), std::string::npos) << last().payload;
  }
}

TEST_F(ServerProxyTest, retains_connection_and_factsheet) {
  server_proxy.set_online(true);
  server_proxy.publish(SimTime{}, wire::ConnectionState::online, effects);
  EXPECT_EQ(last().topic, server_proxy.topics().connection);
  EXPECT_TRUE(last().retained);
  server_proxy.publish(SimTime{}, wire::Factsheet{}, effects);
  EXPECT_EQ(last().topic, server_proxy.topics().factsheet);
  EXPECT_TRUE(last().retained);
}

TEST_F(ServerProxyTest, refuses_a_message_for_another_vehicle_and_an_unsupported_version) {
  EXPECT_TRUE(server_proxy.accepts({0, SimTime{}, "2.1.0", "CoSiVA", "AIV1"}));
  EXPECT_TRUE(server_proxy.accepts({0, SimTime{}, "v2", "CoSiVA", "AIV1"}));
  EXPECT_FALSE(server_proxy.accepts({0, SimTime{}, "2.1.0", "CoSiVA", "AIV2"}));
  EXPECT_FALSE(server_proxy.accepts({0, SimTime{}, "3.0.0", "CoSiVA", "AIV1"}));
}

TEST_F(ServerProxyTest, has_the_topics_of_the_standard_and_of_cosiva) {
  const ServerProxyTopics& topics = server_proxy.topics();
  EXPECT_EQ(topics.order, "uagv/v2/CoSiVA/AIV1/order");
  EXPECT_EQ(topics.instant_actions, "uagv/v2/CoSiVA/AIV1/instantActions");
  EXPECT_EQ(topics.connection, "uagv/v2/CoSiVA/AIV1/connection");
  EXPECT_EQ(topics.state, "uagv/v2/CoSiVA/AIV1/state");
  EXPECT_EQ(topics.visualization, "uagv/v2/CoSiVA/AIV1/visualization");
  EXPECT_EQ(topics.factsheet, "uagv/v2/CoSiVA/AIV1/factsheet");
  EXPECT_EQ(topics.virtual_obstacles, "cosiva/v1/virtual_obstacles/CoSiVA/AIV1");
  EXPECT_EQ(topics.virtual_obstacles_ack, "cosiva/v1/virtual_obstacles_ack/CoSiVA/AIV1");
  EXPECT_EQ(topics.owner, "cosiva/v1/owner/CoSiVA/AIV1");
  EXPECT_EQ(topics.estimate_request, "cosiva/v1/estimate/request/CoSiVA/AIV1");
  EXPECT_EQ(topics.estimate_response, "cosiva/v1/estimate/response/CoSiVA/AIV1");
  EXPECT_EQ(topics.detected_obstacle, "cosiva/v1/detected_obstacle/CoSiVA/AIV1");
  EXPECT_EQ(topics.boards, "cosiva/v1/boards/CoSiVA/AIV1");
}

TEST_F(ServerProxyTest, publishes_each_message_on_its_topic_with_its_quality_and_only_while_online) {
  struct Case {
    std::string topic;
    int qos;
    bool retained;
    std::function<void()> publish;
  };
  const ServerProxyTopics& topics = server_proxy.topics();
  const std::vector<Case> cases{
      {topics.connection, 1, true, [&] { server_proxy.publish(SimTime{}, wire::ConnectionState::online, effects); }},
      {topics.state, 0, false, [&] { server_proxy.publish(SimTime{}, wire::State{}, effects); }},
      {topics.visualization, 0, false, [&] { server_proxy.publish(SimTime{}, wire::Visualization{}, effects); }},
      {topics.factsheet, 0, true, [&] { server_proxy.publish(SimTime{}, wire::Factsheet{}, effects); }},
      {topics.virtual_obstacles_ack, 0, false, [&] { server_proxy.publish(wire::VirtualObstaclesAck{}, effects); }},
      {topics.detected_obstacle, 0, false,
       [&] { server_proxy.publish(SimTime{}, wire::DetectedObstacleReport{}, effects); }},
      {topics.boards, 0, false, [&] { server_proxy.publish(SimTime{}, wire::BoardsReport{}, effects); }},
      {topics.estimate_response, 0, false, [&] { server_proxy.publish_estimate("{}", effects); }}};
  for (const bool online : {false, true}) {
    server_proxy.set_online(online);
    EXPECT_EQ(server_proxy.online(), online);
    for (const Case& one : cases) {
      effects.clear();
      one.publish();
      ASSERT_EQ(effects.size(), online ? 1U : 0U) << one.topic;
      if (!online) continue;
      EXPECT_EQ(last().topic, one.topic);
      EXPECT_EQ(last().qos, one.qos) << one.topic;
      EXPECT_EQ(last().retained, one.retained) << one.topic;
      EXPECT_FALSE(last().payload.empty()) << one.topic;
      EXPECT_FALSE(last().typed) << one.topic;
    }
  }
}

TEST_F(ServerProxyTest, passes_frequent_messages_on_as_values_in_one_process) {
  ServerProxy inside{{"CoSiVA", "AIV1"}, wire::default_interface, true};
  inside.set_online(true);
  const auto expect_values = [&](const std::string& topic) {
    EXPECT_EQ(last().topic, topic);
    EXPECT_TRUE(last().typed) << topic;
    EXPECT_TRUE(last().payload.empty()) << topic;
    EXPECT_EQ(last().qos, 0);
    EXPECT_FALSE(last().retained);
  };
  inside.publish(SimTime{}, wire::State{}, effects);
  expect_values(inside.topics().state);
  inside.publish(SimTime{}, wire::Visualization{}, effects);
  expect_values(inside.topics().visualization);
  inside.publish(SimTime{}, wire::DetectedObstacleReport{}, effects);
  expect_values(inside.topics().detected_obstacle);
  inside.publish(SimTime{}, wire::BoardsReport{}, effects);
  expect_values(inside.topics().boards);
  inside.publish(SimTime{}, wire::ConnectionState::online, effects);
  EXPECT_FALSE(last().payload.empty()) << "rare messages stay texts";
}

TEST_F(ServerProxyTest, counts_and_dates_each_message) {
  server_proxy.set_online(true);
  const SimTime now = virtual_epoch;
  for (const std::string number : {"0", "1", "2"}) {
    const auto expect_number = [&] {
      EXPECT_THAT(last().payload, testing::HasSubstr(R"("headerId":)" + number + ","));
      EXPECT_THAT(last().payload, testing::HasSubstr(R"("timestamp":"2023-07-11T00:00:00.000Z")"));
    };
    server_proxy.publish(now, wire::ConnectionState::online, effects);
    expect_number();
    server_proxy.publish(now, wire::State{}, effects);
    expect_number();
    server_proxy.publish(now, wire::Visualization{}, effects);
    expect_number();
    server_proxy.publish(now, wire::Factsheet{}, effects);
    expect_number();
    server_proxy.publish(now, wire::DetectedObstacleReport{}, effects);
    expect_number();
    server_proxy.publish(now, wire::BoardsReport{}, effects);
    expect_number();
  }
}

TEST_F(ServerProxyTest, leaves_a_retained_will_of_a_broken_connection) {
  const wire::Publish will = server_proxy.will(virtual_epoch).message;
  EXPECT_EQ(will.topic, server_proxy.topics().connection);
  EXPECT_EQ(will.qos, 1);
  EXPECT_TRUE(will.retained);
  EXPECT_EQ(will.payload, R"({"headerId":0,"timestamp":"2023-07-11T00:00:00.000Z","version":"2.1.0",)"
                          R"("manufacturer":"CoSiVA","serialNumber":"AIV1","connectionState":"CONNECTIONBROKEN"})");
}

TEST_F(ServerProxyTest, accepts_any_version_two_and_no_other) {
  for (const char* version : {"2", "2.0", "2.1.0", "v2", "V2", "v2.0"})
    EXPECT_TRUE(server_proxy.accepts({0, SimTime{}, version, "CoSiVA", "AIV1"})) << version;
  for (const char* version : {"", "1.1", "3.0.0", "20", "v", "two", "vv2"})
    EXPECT_EQ(server_proxy.accepts({0, SimTime{}, version, "CoSiVA", "AIV1"}).error().location, "version") << version;
  for (const wire::VehicleId& other : {wire::VehicleId{"CoSiVA", "AIV2"}, wire::VehicleId{"Other", "AIV1"}}) {
    const auto refused = server_proxy.accepts({0, SimTime{}, "2.1.0", other.manufacturer, other.serial_number});
    EXPECT_EQ(refused.error().code, "validationError");
    EXPECT_EQ(refused.error().location, "serialNumber");
  }
}

TEST_F(ServerProxyTest, delivers_each_message_of_the_server_by_its_topic_and_no_other) {
  const ServerProxyTopics& topics = server_proxy.topics();
  const wire::ServerTopics server = wire::server_topics("area_b");
  using enum ServerMessage;
  const std::vector<std::pair<std::string, ServerMessage>> messages{{topics.order, order},
                                                                    {topics.instant_actions, instant_actions},
                                                                    {topics.virtual_obstacles, virtual_obstacles},
                                                                    {topics.estimate_request, estimate_request},
                                                                    {topics.battery_change, battery_change},
                                                                    {topics.battery_fitted, battery_fitted},
                                                                    {topics.owner, owner},
                                                                    {server.heartbeat, heartbeat},
                                                                    {server.connection, connection},
                                                                    {server.zone_prefix + "toml", zone}};
  for (const auto& [topic, kind] : messages) EXPECT_EQ(server_proxy.deliver(topic, server), kind) << topic;
  const wire::ServerTopics other = wire::server_topics({});
  for (const std::string& topic : {topics.state, topics.link_check, other.heartbeat, other.zone_prefix + "toml"})
    EXPECT_EQ(server_proxy.deliver(topic, server), none) << topic;
  EXPECT_EQ(server_proxy.counts(), (wire::ProxyCounts{"AIV_Server", 0, messages.size()}));
}

TEST_F(ServerProxyTest, counts_what_it_sends_to_the_server_and_not_what_it_sends_to_itself) {
  server_proxy.publish(SimTime{}, wire::State{}, effects);
  EXPECT_EQ(server_proxy.counts().sent, 0U) << "the broker is away";
  server_proxy.set_online(true);
  server_proxy.publish(SimTime{}, wire::State{}, effects);
  server_proxy.publish(SimTime{}, wire::BoardsReport{}, effects);
  server_proxy.publish_estimate("{}", effects);
  server_proxy.publish(SimTime{}, wire::LinkCheck{}, effects);
  EXPECT_EQ(server_proxy.counts().sent, 3U);
  EXPECT_EQ(effects.size(), 4U);
}

}  // namespace
}  // namespace cosiva::aiv
