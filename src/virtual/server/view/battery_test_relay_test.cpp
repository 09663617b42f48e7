// The server's information about battery tests that run elsewhere.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/virtual/server/view/battery_test_relay.h"
#include "cosiva/wire/own/battery_exchange.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

class BatteryFixture : public testing::Test {
 protected:
  void change(const std::string& vehicle, const std::string& payload) {
    fixture.feed(wire::InputKind::message, "cosiva/v1/battery/change/" + vehicle, payload, true);
  }
  void request(const std::string& vehicle, const std::string& battery) {
    change(vehicle, to_json(wire::BatteryChange{battery, 1, {}}));
  }
  void test(const wire::BatteryTest& test) {
    fixture.feed(wire::InputKind::message, std::string(wire::battery_test_topic), to_json(test), true);
  }
  /// The vehicle's own report, with this charge.
  void report(double charge) {
    wire::BoardsReport boards;
    boards.timestamp = fixture.now;
    wire::Power power;
    power.voltage_mv = 7400;
    power.temperature_01C = 225;
    power.charge_permille = static_cast<std::uint16_t>(1000.0 * charge);
    boards.power = power;
    fixture.feed(wire::InputKind::message, "cosiva/v1/boards/CoSiVA/AIV1", to_json(boards));
  }
  [[nodiscard]] JsonValue battery() const { return *fixture.snapshot().find("battery"); }
  [[nodiscard]] JsonValue::Array points() const {
    return *JsonValue::parse(*fixture.server->battery_curve_json("CoSiVA/AIV1"))->find("points")->array();
  }

  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
};

TEST_F(BatteryFixture, nothing_is_shown_before_a_message_was_received) { EXPECT_TRUE(battery().is_null()); }

TEST_F(BatteryFixture, a_requested_change_is_shown_until_it_is_withdrawn) {
  request("CoSiVA/AIV1", "red");
  request("ACME/A7", "blue");
  const JsonValue::Array changes = *battery().find("changes")->array();
  ASSERT_THAT(changes, SizeIs(2));
  EXPECT_EQ(changes[1].text("vehicle"), "CoSiVA/AIV1");
  EXPECT_EQ(changes[1].text("battery"), "red");
  EXPECT_EQ(changes[1].number("run"), 1.0);
  change("CoSiVA/AIV1", "");
  change("ACME/A7", "");
  EXPECT_TRUE(battery().is_null());
}

TEST_F(BatteryFixture, a_test_is_shown_with_the_state_that_it_reports) {
  wire::BatteryTest running{fixture.now, fixture.now, 2, 4, 20.0, 0.5, fixture.now + 60s, false, {}};
  running.vehicles.push_back({"CoSiVA/AIV1", "red", wire::BatteryPhase::running, "", 12.34, 61.2345});
  running.vehicles.push_back({"CoSiVA/AIV2", "blue", wire::BatteryPhase::ended, "floor", 10.0, {}});
  test(running);
  const JsonValue battery_json = battery();
  const JsonValue& shown = *battery_json.find("test");
  EXPECT_EQ(shown.number("run"), 2.0);
  EXPECT_EQ(shown.number("expectedEnd_ms"), *shown.number("received_ms") + 60'000.0);
  const JsonValue::Array& vehicles = *shown.find("vehicles")->array();
  EXPECT_EQ(vehicles[0].text("phase"), "running");
  EXPECT_TRUE(vehicles[0].find("stop")->is_null());
  EXPECT_NEAR(*vehicles[0].number("charge"), 61.2345, 1e-3);
  EXPECT_EQ(vehicles[1].text("stop"), "floor");
  EXPECT_TRUE(vehicles[1].find("charge")->is_null());
  fixture.feed(wire::InputKind::message, std::string(wire::battery_test_topic), "", true);
  EXPECT_TRUE(battery().is_null());
}

TEST_F(BatteryFixture, an_unreadable_message_is_ignored_and_logged) {
  request("CoSiVA/AIV1", "red");
  change("CoSiVA/AIV1", "{");
  fixture.feed(wire::InputKind::message, std::string(wire::battery_test_topic), R"({"run":1})");
  EXPECT_THAT(*battery().find("changes")->array(), SizeIs(1));
  EXPECT_TRUE(battery().find("test")->is_null());
  EXPECT_THAT(fixture.logs, testing::Contains(HasSubstr("cosiva/v1/battery/test")));
}

TEST_F(BatteryFixture, invented_names_use_bounded_memory) {
  for (int i = 0; i < 400; ++i) request("ACME/A" + std::to_string(i), "x");
  EXPECT_THAT(*battery().find("changes")->array(), SizeIs(BatteryTestRelay::changes_max));
  request("ACME/A7", "another");  // a known vehicle
  EXPECT_THAT(fixture.server->snapshot_json(), HasSubstr("another"));
}

TEST_F(BatteryFixture, batteryReady_goes_to_the_requesting_test_with_defaults_for_missing_fields) {
  const std::string in = R"({"command":"batteryReady","vehicle":"CoSiVA/AIV1","battery":"red"})";
  EXPECT_THAT(fixture.refusal(in), HasSubstr("no test wants"));
  request("CoSiVA/AIV1", "red");
  EXPECT_EQ(fixture.refusal(in), "");
  fixture.published.clear();
  fixture.send_command(in);
  ASSERT_THAT(fixture.published, SizeIs(1));
  EXPECT_EQ(fixture.published[0].topic, "cosiva/v1/battery/ready/CoSiVA/AIV1");
  EXPECT_FALSE(fixture.published[0].retained);
  EXPECT_EQ(wire::battery_ready_from_json(fixture.published[0].payload),
            (wire::BatteryReady{"red", "unknown", 0.0, 0.0, 22.0, 100.0}));
  EXPECT_THAT(*battery().find("changes")->array(), SizeIs(1)) << "the test reports whether the battery is accepted";
}

TEST_F(BatteryFixture, batteryReady_with_a_wrong_field_is_rejected_with_the_name_of_the_field) {
  request("CoSiVA/AIV1", "red");
  const auto refusal = [&](const std::string& rest) {
    return fixture.refusal(R"({"command":"batteryReady","vehicle":"CoSiVA/AIV1",)" + rest + "}");
  };
  EXPECT_EQ(refusal(R"("battery":"red","type":"leaf33","cycles":3,"rest_s":60,"temperature":21,"charge":99)"), "");
  EXPECT_THAT(refusal(R"("charge":99)"), HasSubstr("battery's own id"));
  EXPECT_THAT(refusal(R"("battery":"red","charge":101)"), HasSubstr("0 to 100"));
  EXPECT_THAT(refusal(R"("battery":"red","temperature":"warm")"), HasSubstr("temperature"));
  EXPECT_THAT(refusal(R"("battery":"red","type":5)"), HasSubstr("type"));
  EXPECT_THAT(fixture.refusal(R"({"command":"batteryReady","battery":"red"})"), HasSubstr("vehicle"));
  fixture.published.clear();
  fixture.send_command(R"({"command":"batteryReady","vehicle":"CoSiVA/AIV1","battery":"red","charge":-1})");
  EXPECT_THAT(fixture.published, IsEmpty());
}

TEST_F(BatteryFixture, retained_messages_are_restored_after_a_new_connection) {
  request("CoSiVA/AIV1", "red");
  fixture.feed(wire::InputKind::link, "", "down");
  fixture.feed(wire::InputKind::link, "", "up");
  EXPECT_TRUE(battery().is_null())
      << "requests may have been withdrawn meanwhile; the broker sends the retained ones again";
}

TEST_F(BatteryFixture, a_curve_reaches_back_to_its_beginning_for_any_duration) {
  EXPECT_FALSE(fixture.server->battery_curve_json("CoSiVA/AIV1"));
  fixture.run_for(1s);
  for (int i = 0; i <= 1000; ++i) {
    report(1.0 - 0.0005 * i);
    fixture.now += 1s;
  }
  const JsonValue::Array all = points();
  EXPECT_LE(all.size(), BatteryCurve::points_max);
  EXPECT_GE(all.size(), BatteryCurve::points_max / 2);
  EXPECT_NEAR(*(*all.front().array())[1].number(), 100.0, 0.1);
  EXPECT_LT(*(*all.back().array())[1].number(), 51.0);
  EXPECT_NEAR(*(*all.back().array())[2].number(), 7.4, 1e-3);
  EXPECT_NEAR(*(*all.back().array())[3].number(), 22.5, 1e-3);
}

TEST_F(BatteryFixture, a_new_test_begins_a_new_curve) {
  fixture.run_for(1s);
  for (int i = 0; i < 20; ++i) {
    report(0.5);
    fixture.now += 1s;
  }
  wire::BatteryTest begun{fixture.now, fixture.now - 5s, 1, 1, 20.0, 0.0, {}, false, {}};
  begun.vehicles.push_back({"CoSiVA/AIV1", "red", {}, "", 0.0, {}});
  test(begun);
  EXPECT_THAT(points(), SizeIs(5));
}

}  // namespace
}  // namespace cosiva::virtual_side
