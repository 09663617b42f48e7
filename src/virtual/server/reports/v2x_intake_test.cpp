// V2X messages between vehicles: virtual AIVs receive them, and the HMI shows them.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/wire/own/v2x.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class V2xFixture : public testing::Test {
 protected:
  V2xFixture() {
    for (FixtureVehicle* vehicle : {&first, &second}) vehicle->blocked = true;
    fixture.run_for(1s);
  }
  wire::Intent intent_of(const FixtureVehicle& vehicle) {
    wire::Intent intent;
    intent.header_id = ++published_count;
    intent.timestamp = fixture.now;
    intent.map_id = "oval";
    intent.vehicle = vehicle.id;
    intent.pose = vehicle.pose();
    intent.speed_mps = 0.4;
    return intent;
  }
  void publish_intent(const wire::Intent& intent, bool retained = false) {
    fixture.feed(wire::InputKind::message,
                 wire::v2x_topic("oval", wire::cell_of(position(intent.pose)), intent.vehicle), to_json(intent),
                 retained);
  }
  [[nodiscard]] JsonValue::Array traces() const {
    JsonValue::Array found;
    const JsonValue all = *JsonValue::parse(fixture.server->traces_json(0, 1'000'000));
    for (const JsonValue& trace : *all.find("traces")->array())
      if (trace.text("kind") == "V2X") found.push_back(trace);
    return found;
  }

  ServerFixture fixture;
  FixtureVehicle& first{fixture.add("AIV1", {0, 0.5})};
  FixtureVehicle& second{fixture.add("AIV2", {0, 1.2})};
  std::uint32_t published_count{0};
};

TEST_F(V2xFixture, is_shown_from_one_vehicle_to_the_nearest_receiver) {
  wire::Intent intent = intent_of(first);
  intent.crossings = {{"X1", 0.31, 0.71, 0.9, 1.9, false}};
  publish_intent(intent);
  ASSERT_THAT(traces(), SizeIs(1));
  const JsonValue trace = traces()[0];
  EXPECT_EQ(trace.text("from"), "CoSiVA/AIV1");
  EXPECT_EQ(trace.text("to"), "CoSiVA/AIV2");
  EXPECT_EQ(trace.text("content"), "0.400 m/s; X1 in 0.900 s, not yet its own");
}

TEST_F(V2xFixture, is_shown_once_a_second_from_each_vehicle) {
  for (int i = 0; i < 15; ++i) {
    publish_intent(intent_of(first));
    publish_intent(intent_of(second));
    fixture.run_for(200ms);
  }
  EXPECT_THAT(traces(), SizeIs(6));
}

TEST_F(V2xFixture, of_unknown_senders_with_false_names_or_retained_is_not_shown) {
  wire::Intent unknown_sender = intent_of(first);
  unknown_sender.vehicle.serial_number = "NOBODY";
  publish_intent(unknown_sender);
  publish_intent(intent_of(first), true);
  fixture.feed(wire::InputKind::message, "cosiva/v1/v2x/oval/0_0/CoSiVA/AIV1", "{\"headerId\":NaN}");
  fixture.feed(wire::InputKind::message, "cosiva/v1/v2x/oval/0_0/CoSiVA/AIV2", to_json(intent_of(first)));
  fixture.feed(wire::InputKind::message, "cosiva/v1/v2x/nonsense", "{}");
  EXPECT_THAT(traces(), IsEmpty());
  EXPECT_EQ(fixture.snapshot().find("aivs")->array()->size(), 2U) << "V2X messages register no vehicle";
}

TEST_F(V2xFixture, virtual_AIVs_publish_to_the_broker_and_receive_from_nearby_vehicles) {
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","id":"V1"}})");
  const auto published_by_v1 = [&] {
    return std::ranges::count_if(fixture.published, [](const wire::Publish& publish) {
      const auto topic = wire::parse_v2x_topic(publish.topic);
      return topic && topic->vehicle.serial_number == "V1";
    });
  };
  fixture.run_for(3s);
  const auto alone = published_by_v1();
  EXPECT_GE(alone, 2);
  for (int i = 0; i < 15; ++i) {
    publish_intent(intent_of(first));
    fixture.run_for(200ms);
  }
  EXPECT_GE(published_by_v1() - alone, 2 * alone)
      << "with another vehicle nearby it publishes more often: it has received messages";
}

TEST_F(V2xFixture, summary_states_that_the_sender_brakes_and_is_inside_a_crossing_of_its_own) {
  wire::Intent intent = intent_of(first);
  intent.braking = true;
  intent.crossings = {{"X1", 0.0, 0.4, 0.0, 1.0, true}, {"X2", 0.5, 0.9, 1.2, 2.2, false}};
  publish_intent(intent);
  ASSERT_THAT(traces(), SizeIs(1));
  EXPECT_EQ(traces()[0].text("content"), "0.400 m/s, brakes; X1, inside, its own");
}

TEST_F(V2xFixture, is_shown_to_the_nearest_of_several_receivers) {
  FixtureVehicle& third = fixture.add("AIV3", {0, 0.9});
  third.blocked = true;
  fixture.run_for(1s);
  publish_intent(intent_of(first));
  ASSERT_THAT(traces(), SizeIs(1));
  EXPECT_EQ(traces()[0].text("to"), "CoSiVA/AIV3");
  EXPECT_EQ(traces()[0].text("content"), "0.400 m/s; to 2 near it");
}

TEST_F(V2xFixture, is_shown_to_all_where_no_vehicle_is_near) {
  second.put({500.0, 500.0, 0.0});
  fixture.run_for(500ms);
  publish_intent(intent_of(first));
  ASSERT_THAT(traces(), SizeIs(1));
  EXPECT_EQ(traces()[0].text("to"), "*");
  EXPECT_EQ(traces()[0].text("content"), "0.400 m/s");
}

TEST_F(V2xFixture, vehicles_are_near_in_the_eight_cells_around_the_sender_s) {
  for (int x = -2; x <= 2; ++x) {
    for (int y = -2; y <= 2; ++y) {
      Point2 there = position(first.pose());
      there.x_m += wire::v2x_cell_m * x;
      there.y_m += wire::v2x_cell_m * y;
      second.put({there.x_m, there.y_m, 0.0});
      fixture.run_for(1s);
      publish_intent(intent_of(first));
      const bool near = x >= -1 && x <= 1 && y >= -1 && y <= 1;
      EXPECT_EQ(traces().back().text("to"), near ? "CoSiVA/AIV2" : "*") << x << " " << y;
    }
  }
}

TEST_F(V2xFixture, vehicles_are_near_in_the_eight_cells_around_every_cell) {
  for (const double side_m : {-4.5, 4.5}) {
    first.put({side_m, side_m, 0.0});
    second.put({side_m, side_m, 0.0});
    fixture.run_for(1s);
    publish_intent(intent_of(first));
    EXPECT_EQ(traces().back().text("to"), "CoSiVA/AIV2") << side_m;
    second.put({-side_m, side_m, 0.0});
    fixture.run_for(1s);
    publish_intent(intent_of(first));
    EXPECT_EQ(traces().back().text("to"), "*") << side_m;
    second.put({side_m, -side_m, 0.0});
    fixture.run_for(1s);
    publish_intent(intent_of(first));
    EXPECT_EQ(traces().back().text("to"), "*") << side_m;
  }
}

TEST_F(V2xFixture, of_a_false_name_or_unreadable_is_counted_as_refused) {
  fixture.feed(wire::InputKind::message, "cosiva/v1/v2x/oval/0_0/CoSiVA/AIV2", to_json(intent_of(first)));
  fixture.feed(wire::InputKind::message, "cosiva/v1/v2x/oval/0_0/CoSiVA/AIV1", "{");
  const JsonValue summary = *JsonValue::parse(fixture.server->summary_json());
  for (const JsonValue& aiv : *summary.find("aivs")->array()) EXPECT_EQ(aiv.number("refused"), 1.0) << *aiv.text("id");
}

TEST_F(V2xFixture, that_is_unreadable_is_logged_at_once_by_each_virtual_AIV_that_receives_it) {
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","id":"V1","section":"north","s":0.5}})");
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","id":"V2","section":"north","s":1.5}})");
  fixture.run_for(3s);
  fixture.logs.clear();
  fixture.feed(wire::InputKind::message, "cosiva/v1/v2x/oval/0_0/CoSiVA/AIV1", "{");
  for (const std::string vehicle : {"V1", "V2"})
    EXPECT_TRUE(
        fixture.logged("CoSiVA.virtual/" + vehicle + ": intent on 'cosiva/v1/v2x/oval/0_0/CoSiVA/AIV1' not used: "))
        << vehicle;
}

TEST_F(V2xFixture, summary_states_that_a_crossing_less_than_a_metre_in_front_is_not_entered_yet) {
  wire::Intent intent = intent_of(first);
  intent.crossings = {{"X1", 0.001, 0.4, 0.0, 1.0, true}};
  publish_intent(intent);
  ASSERT_THAT(traces(), SizeIs(1));
  EXPECT_EQ(traces()[0].text("content"), "0.400 m/s; X1 in 0.000 s, its own");
}

}  // namespace
}  // namespace cosiva::virtual_side
