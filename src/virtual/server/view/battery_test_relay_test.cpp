// The server's information about battery tests that run elsewhere.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/virtual/server/view/battery_test_relay.h"
#include "cosiva/wire/own/battery_exchange.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
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
  EXPECT_EQ(fixture.published[0].topic, "cosiva/v1/battery/fitted/CoSiVA/AIV1");
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

/// The relay without a server around it.
class BatteryRelay : public testing::Test {
 protected:
  [[nodiscard]] Result<std::string> receive(std::string topic, std::string payload, SimTime at = SimTime{5s}) {
    return relay.on_message({at, wire::InputKind::message, std::move(topic), std::move(payload), true});
  }
  [[nodiscard]] Result<std::string> receive_change(const std::string& vehicle, const wire::BatteryChange& change) {
    return receive("cosiva/v1/battery/change/" + vehicle, to_json(change));
  }
  [[nodiscard]] Result<std::string> receive_test(const wire::BatteryTest& test) {
    return receive("cosiva/v1/battery/test", to_json(test));
  }
  [[nodiscard]] std::string shown() const {
    JsonWriter json;
    relay.write(json);
    return json.take();
  }
  [[nodiscard]] static BatteryReadyCommand ready_command(const std::string& vehicle = "CoSiVA/AIV1") {
    BatteryReadyCommand command;
    command.vehicle = vehicle;
    command.battery = "red";
    return command;
  }
  /// The error of a command that has to be refused.
  [[nodiscard]] Error refusal(const BatteryReadyCommand& command) const {
    const auto ready = relay.ready(command);
    return ready ? Error{"accepted", "", ""} : ready.error();
  }
  void report_power(SimTime at, const std::string& vehicle) {
    wire::Power power;
    power.voltage_mv = 7400;
    power.charge_permille = 500;
    relay.on_power(at, vehicle, power);
  }
  [[nodiscard]] std::size_t point_count(const std::string& vehicle) const {
    return JsonValue::parse(relay.curve_json(vehicle).value())->find("points")->array()->size();
  }

  wire::BatteryTest running{SimTime{9s}, SimTime{2s}, 1, 3, 20.0, 0.25, {}, false, {}};
  BatteryTestRelay relay;
};

TEST_F(BatteryRelay, subscribes_to_the_changes_of_all_vehicles_and_to_the_test) {
  EXPECT_THAT(BatteryTestRelay::subscriptions(), ElementsAre("cosiva/v1/battery/change/+/+", "cosiva/v1/battery/test"));
}

TEST_F(BatteryRelay, summarises_changes_and_the_beginnings_of_tests) {
  EXPECT_EQ(receive_test(running), "run 1 of 3");
  EXPECT_EQ(receive_test(running), "") << "the same test";
  running.began = SimTime{8s};
  running.run = 2;
  EXPECT_EQ(receive_test(running), "run 2 of 3");
  EXPECT_EQ(receive("cosiva/v1/battery/test", ""), "");
  EXPECT_EQ(receive_test(running), "run 2 of 3") << "the retained message was deleted in between";
  EXPECT_EQ(receive_change("CoSiVA/AIV1", {"red", 1, ""}), "changeBattery in CoSiVA/AIV1: 'red'");
  EXPECT_EQ(receive("cosiva/v1/battery/change/CoSiVA/AIV1", ""), "");
  EXPECT_EQ(receive("cosiva/v1/battery/ready/CoSiVA/AIV1", "{"), "") << "that message is for the test";
}

TEST_F(BatteryRelay, shows_each_field_of_a_change) {
  EXPECT_EQ(shown(), "null");
  ASSERT_TRUE(receive_change("CoSiVA/AIV1", {"red", 3, "too warm"}).has_value());
  EXPECT_EQ(shown(), R"({"changes":[{"vehicle":"CoSiVA/AIV1","battery":"red","run":3,"reason":"too warm",)"
                     R"("since_ms":5000}],"test":null})");
  ASSERT_TRUE(receive_change("CoSiVA/AIV1", {"blue", 4, ""}).has_value());
  EXPECT_EQ(shown(), R"({"changes":[{"vehicle":"CoSiVA/AIV1","battery":"blue","run":4,"reason":"",)"
                     R"("since_ms":5000}],"test":null})");
}

TEST_F(BatteryRelay, shows_each_field_of_a_test) {
  running.expected_end = SimTime{60s};
  running.vehicles.push_back({"CoSiVA/AIV1", "red", wire::BatteryPhase::running, "", 12.34, 61.2346});
  running.vehicles.push_back({"CoSiVA/AIV2", "blue", wire::BatteryPhase::ended, "floor", 10.06, {}});
  ASSERT_TRUE(receive_test(running).has_value());
  EXPECT_EQ(shown(), R"({"changes":[],"test":{"began_ms":2000,"received_ms":9000,"run":1,"runs":3,"floor":20,)"
                     R"("progress":0.25,"expectedEnd_ms":60000,"done":false,"vehicles":[)"
                     R"({"id":"CoSiVA/AIV1","battery":"red","phase":"running","stop":null,"autonomy_s":12.3,)"
                     R"("charge":61.235},)"
                     R"({"id":"CoSiVA/AIV2","battery":"blue","phase":"ended","stop":"floor","autonomy_s":10.1,)"
                     R"("charge":null}]}})");
}

TEST_F(BatteryRelay, shows_a_test_that_is_done_and_expects_no_end) {
  running.done = true;
  ASSERT_TRUE(receive_test(running).has_value());
  EXPECT_EQ(shown(), R"({"changes":[],"test":{"began_ms":2000,"received_ms":9000,"run":1,"runs":3,"floor":20,)"
                     R"("progress":0.25,"expectedEnd_ms":null,"done":true,"vehicles":[]}})");
}

TEST_F(BatteryRelay, keeps_its_state_when_a_message_is_unreadable) {
  ASSERT_TRUE(receive_test(running).has_value());
  ASSERT_TRUE(receive_change("CoSiVA/AIV1", {"red", 1, ""}).has_value());
  const std::string before = shown();
  EXPECT_EQ(receive("cosiva/v1/battery/test", "{").error().code, "json.syntax");
  EXPECT_EQ(receive("cosiva/v1/battery/change/CoSiVA/AIV1", "{}").error().code, "own.field");
  EXPECT_EQ(shown(), before);
}

TEST_F(BatteryRelay, refuses_the_257th_vehicle_by_name) {
  for (std::size_t i = 0; i < BatteryTestRelay::changes_max; ++i)
    ASSERT_TRUE(receive_change("ACME/A" + std::to_string(i), {"red", 1, ""}).has_value());
  const auto refused = receive_change("ACME/A256", {"red", 1, ""});
  ASSERT_FALSE(refused.has_value());
  EXPECT_EQ(refused.error(), (Error{"battery.many", "more than 256 battery changes at a time", "ACME/A256"}));
  EXPECT_TRUE(receive_change("ACME/A255", {"blue", 1, ""}).has_value()) << "a known vehicle";
}

TEST_F(BatteryRelay, forgets_changes_and_test_but_no_curve_when_the_link_comes_up) {
  ASSERT_TRUE(receive_test(running).has_value());
  report_power(SimTime{1s}, "CoSiVA/AIV1");
  relay.link_up();
  EXPECT_EQ(shown(), "null");
  EXPECT_EQ(receive_test(running), "run 1 of 3");
  ASSERT_TRUE(receive_change("CoSiVA/AIV1", {"red", 1, ""}).has_value());
  relay.link_up();
  EXPECT_EQ(shown(), "null");
  EXPECT_EQ(point_count("CoSiVA/AIV1"), 1U);
}

TEST_F(BatteryRelay, shortens_the_curves_of_a_test_s_vehicles_when_the_test_begins) {
  for (const SimTime at : {SimTime{1s}, SimTime{2s}, SimTime{3s}}) {
    report_power(at, "CoSiVA/AIV1");
    report_power(at, "CoSiVA/AIV2");
  }
  running.vehicles.push_back({"CoSiVA/AIV1", "red", {}, "", 0.0, {}});
  running.vehicles.push_back({"CoSiVA/AIV9", "red", {}, "", 0.0, {}});  // never reported its battery
  ASSERT_TRUE(receive_test(running).has_value());
  EXPECT_EQ(point_count("CoSiVA/AIV1"), 2U) << "those from 2 s on";
  EXPECT_EQ(point_count("CoSiVA/AIV2"), 3U);
  EXPECT_EQ(relay.curve_json("CoSiVA/AIV9"), std::nullopt);
  running.vehicles.push_back({"CoSiVA/AIV2", "red", {}, "", 0.0, {}});
  ASSERT_TRUE(receive_test(running).has_value());
  EXPECT_EQ(point_count("CoSiVA/AIV2"), 3U) << "the test had begun before";
}

TEST_F(BatteryRelay, writes_a_curve_to_the_precision_of_each_quantity) {
  wire::Power power;
  power.voltage_mv = 7412;
  power.temperature_01C = -45;
  power.gauge = wire::Power::Gauge{512346, 0};
  relay.on_power(SimTime{5s}, "CoSiVA/AIV1", power);
  EXPECT_EQ(relay.curve_json("CoSiVA/AIV1"), R"({"vehicle":"CoSiVA/AIV1","points":[[5000,51.235,7.412,-4.5]]})");
}

TEST_F(BatteryRelay, publishes_batteryReady_with_each_field_of_the_command) {
  ASSERT_TRUE(receive_change("CoSiVA/AIV1", {"red", 1, ""}).has_value());
  BatteryReadyCommand command = ready_command();
  command.type = "leaf33";
  command.cycles = 12.0;
  command.rest_s = 3600.0;
  command.temperature_c = 21.5;
  command.charge_percent = 99.5;
  const auto ready = relay.ready(command);
  ASSERT_TRUE(ready.has_value());
  EXPECT_EQ(ready->topic, "cosiva/v1/battery/fitted/CoSiVA/AIV1");
  EXPECT_EQ(ready->payload,
            R"({"battery":"red","type":"leaf33","cycles":12,"rest_s":3600,"temperature":21.5,"charge":99.5})");
  EXPECT_EQ(ready->qos, 1);
  EXPECT_FALSE(ready->retained);
}

TEST_F(BatteryRelay, takes_defaults_for_what_batteryReady_does_not_state) {
  ASSERT_TRUE(receive_change("CoSiVA/AIV1", {"red", 1, ""}).has_value());
  BatteryReadyCommand command = ready_command();
  command.type = "";
  EXPECT_EQ(relay.ready(command)->payload,
            R"({"battery":"red","type":"unknown","cycles":0,"rest_s":0,"temperature":22,"charge":100})");
}

TEST_F(BatteryRelay, accepts_the_numbers_of_batteryReady_up_to_their_limits) {
  ASSERT_TRUE(receive_change("CoSiVA/AIV1", {"red", 1, ""}).has_value());
  struct Limits {
    OptionalNumber BatteryReadyCommand::*number;
    std::string name;
    double low;
    double high;
    std::string text;
  };
  const std::vector<Limits> all{{&BatteryReadyCommand::cycles, "cycles", 0.0, 1'000'000.0, "0 to 1000000"},
                                {&BatteryReadyCommand::rest_s, "rest_s", 0.0, 1'000'000'000.0, "0 to 1000000000"},
                                {&BatteryReadyCommand::temperature_c, "temperature", -100.0, 200.0, "-100 to 200"},
                                {&BatteryReadyCommand::charge_percent, "charge", 0.0, 100.0, "0 to 100"}};
  for (const Limits& limits : all) {
    BatteryReadyCommand command = ready_command();
    for (const double within : {limits.low, limits.high}) {
      command.*limits.number = within;
      EXPECT_TRUE(relay.ready(command).has_value()) << limits.name << " " << within;
    }
    for (const double beyond : {std::nextafter(limits.low, -1e12), std::nextafter(limits.high, 1e12),
                                std::numeric_limits<double>::quiet_NaN()}) {
      command.*limits.number = beyond;
      EXPECT_EQ(refusal(command), (Error{"battery." + limits.name, "give a number from " + limits.text, limits.name}));
    }
  }
}

TEST_F(BatteryRelay, limits_the_names_of_batteryReady_to_64_bytes) {
  ASSERT_TRUE(receive_change("CoSiVA/AIV1", {"red", 1, ""}).has_value());
  BatteryReadyCommand command = ready_command();
  command.battery = std::string(64, 'b');
  command.type = std::string(64, 't');
  EXPECT_TRUE(relay.ready(command).has_value());
  command.battery += "b";
  EXPECT_EQ(refusal(command), (Error{"battery.battery", "give the battery's own id, of 1 to 64 bytes", "battery"}));
  command.battery = "";
  EXPECT_EQ(refusal(command).code, "battery.battery");
  command.battery = "b";
  *command.type += "t";
  EXPECT_EQ(refusal(command), (Error{"battery.type", "give its type's name, of at most 64 bytes", "type"}));
  command.type = "t";
  command.type_is_text = false;
  EXPECT_EQ(refusal(command).code, "battery.type");
}

TEST_F(BatteryRelay, refuses_batteryReady_of_no_vehicle_and_of_one_that_needs_no_battery) {
  EXPECT_EQ(refusal(ready_command("")),
            (Error{"battery.vehicle", "give the vehicle as manufacturer/serial number", "vehicle"}));
  ASSERT_TRUE(receive_change("CoSiVA/AIV1", {"red", 1, ""}).has_value());
  EXPECT_EQ(
      refusal(ready_command(std::string(81, 'x'))),
      (Error{"battery.not_requested", "no test wants a battery changed in '" + std::string(80, 'x') + "' now", ""}));
}

/// One curve, whose points have their second as their charge.
class CurvePoints : public testing::Test {
 protected:
  void add(SimDuration at) { curve.add({SimTime{at}, static_cast<float>(to_seconds(at)), 7.4F, 22.0F}); }
  [[nodiscard]] std::vector<float> charges() const {
    std::vector<float> all;
    for (const BatteryCurve::Point& point : curve.points()) all.push_back(point.charge_percent);
    return all;
  }
  BatteryCurve curve;
};

TEST_F(CurvePoints, are_at_least_a_second_apart) {
  for (const SimDuration at :
       {SimDuration{0s}, SimDuration{999ms}, SimDuration{1s}, SimDuration{1999ms}, SimDuration{2s}})
    add(at);
  EXPECT_THAT(charges(), ElementsAre(0.0F, 1.0F, 2.0F));
}

TEST_F(CurvePoints, begin_again_when_the_clock_was_set_back) {
  add(10s);
  add(11s);
  add(11s);
  EXPECT_THAT(charges(), ElementsAre(10.0F, 11.0F)) << "the same time is no step back";
  add(10999ms);
  EXPECT_THAT(charges(), SizeIs(1));
  add(11999ms);
  EXPECT_THAT(charges(), SizeIs(2));
}

TEST_F(CurvePoints, are_thinned_out_by_half_when_there_are_240) {
  for (int i = 0; i < 240; ++i) add(1s * i);
  EXPECT_THAT(charges(), SizeIs(240));
  add(240s);
  const std::vector<float> all = charges();
  ASSERT_THAT(all, SizeIs(121));
  for (std::size_t i = 0; i < all.size(); ++i) EXPECT_EQ(all[i], 2.0F * static_cast<float>(i));
  add(241s);
  EXPECT_THAT(charges(), SizeIs(121)) << "two seconds apart from now on";
  add(242s);
  EXPECT_THAT(charges(), SizeIs(122));
}

TEST_F(CurvePoints, from_a_time_on_remain_and_are_dense_again_only_when_none_did) {
  for (int i = 0; i <= 242; ++i) add(1s * i);
  curve.forget_before(SimTime{240s});
  EXPECT_THAT(charges(), ElementsAre(240.0F, 242.0F));
  add(243s);
  EXPECT_THAT(charges(), SizeIs(2));
  curve.forget_before(SimTime{300s});
  EXPECT_THAT(charges(), IsEmpty());
  add(300s);
  add(301s);
  EXPECT_THAT(charges(), ElementsAre(300.0F, 301.0F));
}

}  // namespace
}  // namespace cosiva::virtual_side
