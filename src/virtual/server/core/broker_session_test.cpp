#include "cosiva/virtual/server/core/broker_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <variant>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/wire/own/battery_exchange.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

/// A server whose link has been up since virtual_epoch, and V7, a virtual AIV of an earlier process that ended without
/// signing off: the startup synchronisation signs it off, which shows when that is done.
class BrokerLink : public testing::Test {
 protected:
  static constexpr std::string_view orphan_topic = "uagv/v2/CoSiVA.virtual/V7/connection";
  static constexpr std::string_view v1_topic = "uagv/v2/CoSiVA.virtual/V1/connection";

  void report_orphan(wire::ConnectionState state = wire::ConnectionState::online) {
    const wire::Connection message{{3, fixture.now, "2.1.0", "CoSiVA.virtual", "V7"}, state};
    fixture.feed(wire::InputKind::message, std::string(orphan_topic), vda::encode(message), true);
  }
  void tick_at(SimDuration since_start) {
    fixture.now = virtual_epoch + since_start;
    fixture.feed(wire::InputKind::tick, "", "");
  }
  void set_link(const std::string& state) { fixture.feed(wire::InputKind::link, "", state); }
  void send_state(FixtureVehicle& vehicle) { fixture.send(vehicle, "state", vda::encode(vehicle.state(fixture.now))); }
  void add_v1() {
    fixture.send_command(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"north","s":0.5}})");
  }
  [[nodiscard]] std::size_t sign_offs() const { return fixture.published_on(orphan_topic).size(); }
  [[nodiscard]] std::vector<wire::ConnectionState> connections_of_v1() const {
    std::vector<wire::ConnectionState> states;
    for (const wire::Publish& message : fixture.published_on(v1_topic))
      states.push_back(vda::decode_connection(message.payload)->state);
    return states;
  }
  [[nodiscard]] std::ptrdiff_t published_by_v1() const {
    return std::ranges::count_if(fixture.published, [](const wire::Publish& message) {
      return message.topic.starts_with("uagv/v2/CoSiVA.virtual/V1/");
    });
  }
  ServerFixture fixture;
};

TEST_F(BrokerLink, is_synchronised_after_three_hundred_milliseconds_where_no_vehicle_is_online) {
  report_orphan();
  tick_at(299ms);
  EXPECT_EQ(sign_offs(), 0U);
  tick_at(300ms);
  ASSERT_EQ(sign_offs(), 1U);
  const wire::Publish message = fixture.published_on(orphan_topic)[0];
  EXPECT_TRUE(message.retained);
  EXPECT_EQ(message.qos, 1);
  const auto offline = vda::decode_connection(message.payload);
  ASSERT_TRUE(offline.has_value());
  EXPECT_EQ(offline->state, wire::ConnectionState::offline);
  EXPECT_EQ(offline->header, (wire::Header{0, virtual_epoch + 300ms, "2.1.0", "CoSiVA.virtual", "V7"}));
}

TEST_F(BrokerLink, waits_two_seconds_at_most_for_the_report_of_a_vehicle_that_is_online) {
  report_orphan();
  fixture.add("AIV1", {0, 0.5});
  for (const SimDuration at : {SimDuration{300ms}, SimDuration{1999ms}}) {
    tick_at(at);
    EXPECT_EQ(sign_offs(), 0U);
  }
  tick_at(2000ms);
  EXPECT_EQ(sign_offs(), 1U);
}

TEST_F(BrokerLink, waits_for_no_vehicle_that_has_reported_or_is_offline) {
  report_orphan();
  send_state(fixture.add("AIV1", {0, 0.5}));
  fixture.connection(fixture.add("AIV2", {2, 0.5}), wire::ConnectionState::offline);
  tick_at(300ms);
  EXPECT_EQ(sign_offs(), 1U);
}

TEST_F(BrokerLink, waits_again_for_each_vehicle_when_it_comes_up_again) {
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  send_state(aiv);
  tick_at(1000ms);
  set_link("down");
  set_link("up");
  report_orphan();
  tick_at(1300ms);
  EXPECT_EQ(sign_offs(), 0U) << "its state is from before";
  send_state(aiv);
  tick_at(1320ms);
  EXPECT_EQ(sign_offs(), 1U);
}

TEST_F(BrokerLink, signs_off_neither_the_virtual_aivs_of_this_server_nor_those_that_are_offline) {
  report_orphan(wire::ConnectionState::offline);
  add_v1();
  fixture.run_for(3s);
  set_link("down");
  set_link("up");
  fixture.run_for(3s);
  EXPECT_EQ(sign_offs(), 0U);
  EXPECT_THAT(connections_of_v1(), testing::Each(wire::ConnectionState::online));
  EXPECT_EQ(fixture.aiv("CoSiVA.virtual/V1").text("connection"), "ONLINE");
}

TEST_F(BrokerLink, that_is_down_is_logged_and_carries_no_heartbeat) {
  fixture.run_for(200ms);
  set_link("up");
  EXPECT_THAT(fixture.published_on(wire::server_connection_topic), SizeIs(1)) << "it was up already";
  EXPECT_FALSE(fixture.logged("lost the connection"));
  set_link("down");
  EXPECT_TRUE(fixture.logged("lost the connection to the broker; vehicles stop by themselves until it is restored"));
  const std::size_t lines = fixture.logs.size();
  set_link("down");
  EXPECT_EQ(fixture.logs.size(), lines);
  const auto before = fixture.published_on(wire::server_heartbeat_topic);
  ASSERT_FALSE(before.empty());
  EXPECT_EQ(before[0].qos, 0);
  EXPECT_FALSE(before[0].retained);
  fixture.run_for(500ms);
  EXPECT_THAT(fixture.published_on(wire::server_heartbeat_topic), SizeIs(before.size()));
}

TEST_F(BrokerLink, state_is_passed_on_to_the_virtual_aivs) {
  fixture.run_for(400ms);
  add_v1();
  fixture.run_for(1s);
  EXPECT_THAT(connections_of_v1(), ElementsAre(wire::ConnectionState::online));
  set_link("down");
  const auto before = published_by_v1();
  fixture.run_for(500ms);
  EXPECT_EQ(published_by_v1(), before) << "it publishes nothing without a link";
  set_link("up");
  EXPECT_THAT(connections_of_v1(), ElementsAre(wire::ConnectionState::online, wire::ConnectionState::online));
}

TEST_F(BrokerLink, on_which_nothing_arrives_any_more_stops_the_virtual_aivs_until_messages_return) {
  const auto speed_mps = [&] {
    const auto all = fixture.published_on("uagv/v2/CoSiVA.virtual/V1/visualization");
    return all.empty() ? 0.0 : vda::decode_visualization(all.back().payload)->velocity->vx_mps;
  };
  fixture.run_for(500ms);
  add_v1();
  fixture.run_for(4s);
  ASSERT_GT(speed_mps(), 0.25);
  fixture.broker_frozen = true;
  fixture.run_for(500ms);
  EXPECT_GT(speed_mps(), 0.25);
  // Braking begins up to a heartbeat later than on a vehicle of its own: 0.62 s. From 0.5 m/s at 0.6 m/s²: 0.83 s.
  fixture.run_for(1s);
  EXPECT_EQ(speed_mps(), 0.0);
  fixture.run_for(3s);
  EXPECT_EQ(speed_mps(), 0.0);
  fixture.broker_frozen = false;
  fixture.run_for(1500ms);
  EXPECT_GT(speed_mps(), 0.25);
}

TEST_F(BrokerLink, ends_with_the_farewell_of_the_virtual_aivs_and_of_the_server) {
  fixture.run_for(400ms);
  add_v1();
  fixture.run_for(1s);
  wire::Effects effects;
  fixture.server->farewell(fixture.now, effects);
  ASSERT_FALSE(effects.empty());
  const auto* last = std::get_if<wire::Publish>(&effects.back());
  ASSERT_NE(last, nullptr);
  EXPECT_EQ(last->topic, wire::server_connection_topic);
  EXPECT_TRUE(last->retained);
  EXPECT_EQ(last->qos, 1);
  EXPECT_EQ(JsonValue::parse(last->payload)->text("timestamp"), to_iso8601(fixture.now));
  EXPECT_TRUE(std::ranges::any_of(effects, [](const wire::Effect& effect) {
    const auto* message = std::get_if<wire::Publish>(&effect);
    return message != nullptr && message->topic == v1_topic &&
           vda::decode_connection(message->payload)->state == wire::ConnectionState::offline;
  }));
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 100'000));
  const JsonValue& trace = traces.find("traces")->array()->back();
  EXPECT_EQ(trace.text("from"), "AIV_Server");
  EXPECT_EQ(trace.text("to"), "*");
  EXPECT_EQ(trace.text("kind"), "connection");
  EXPECT_EQ(trace.text("content"), "OFFLINE");
}

TEST_F(BrokerLink, that_comes_up_again_brings_all_battery_changes_anew) {
  fixture.feed(wire::InputKind::message, "cosiva/v1/battery/change/CoSiVA/AIV1",
               wire::to_json(wire::BatteryChange{"B2", 1, ""}), true);
  const JsonValue requested = fixture.snapshot();
  ASSERT_NE(requested.find("battery")->find("changes"), nullptr);
  EXPECT_THAT(*requested.find("battery")->find("changes")->array(), SizeIs(1));
  set_link("down");
  set_link("up");
  EXPECT_TRUE(fixture.snapshot().find("battery")->is_null());
}

TEST(BrokerSession, traces_its_presence_and_its_heartbeats) {
  ServerFixture fixture;
  fixture.feed(wire::InputKind::tick, "", "");
  std::vector<std::string> presence;
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(0, 1000));
  for (const JsonValue& trace : *traces.find("traces")->array()) {
    if (trace.text("kind") != "connection" && trace.text("kind") != "heartbeat") continue;
    presence.push_back(*trace.text("kind") + " " + *trace.text("content"));
  }
  EXPECT_THAT(presence, ElementsAre("connection ONLINE",
                                    "heartbeat {\"headerId\":0,\"timestamp\":\"2023-07-11T00:00:00.000Z\"}"));
}

TEST(BrokerSession, of_a_control_area_subscribes_to_the_other_areas_and_to_the_owners) {
  ServerOptions options;
  options.area = "a";
  EXPECT_THAT(
      ServerCore{options}.subscriptions(),
      ElementsAre("uagv/+/+/+/state", "uagv/+/+/+/visualization", "uagv/+/+/+/connection", "uagv/+/+/+/factsheet",
                  "cosiva/v1/virtual_obstacles_ack/+/+", "cosiva/v1/detected_obstacle/+/+", "cosiva/v1/boards/+/+",
                  "cosiva/v1/v2x/+/+/+/+", "uagv/v2/CoSiVA.virtual/+/order", "uagv/v2/CoSiVA.virtual/+/instantActions",
                  "cosiva/v1/battery/change/+/+", "cosiva/v1/battery/test", "cosiva/v1/gvs/detections",
                  "cosiva/v1/gvs/connection", "cosiva/v1/reference/poses", "cosiva/v1/unit/+/+",
                  "cosiva/v1/area/+/zone/+", "cosiva/v1/area/+/server/connection", "cosiva/v1/owner/+/+"));
}

TEST(BrokerSession, of_a_control_area_restores_no_virtual_aivs) {
  for (const std::string area : {"", "a"}) {
    ServerOptions options;
    options.area = area;
    options.zone = oval();
    ServerCore server{options};
    wire::Effects effects;
    server.handle({virtual_epoch, wire::InputKind::restore, "",
                   R"({"version":1,"virtualObjects":[],"aivs":[{"id":"V1","section":"south","s":0.5}],"paused":[]})"},
                  effects);
    server.handle({virtual_epoch, wire::InputKind::link, "", "up"}, effects);
    server.handle({virtual_epoch + 300ms, wire::InputKind::tick, "", ""}, effects);
    const JsonValue snapshot = *JsonValue::parse(server.snapshot_json());
    EXPECT_EQ(snapshot.find("bijection")->number("augmented"), area.empty() ? 1.0 : 0.0) << area;
  }
}

}  // namespace
}  // namespace cosiva::virtual_side
