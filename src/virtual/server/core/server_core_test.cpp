#include "cosiva/virtual/server/core/server_core.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/testing/server_fixture.h"
#include "cosiva/wire/own/control_areas.h"
#include "cosiva/wire/own/gvs.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<std::string> kinds(const ServerFixture& fixture, const std::string& from) {
  std::vector<std::string> found;
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(1, 1000));
  for (const JsonValue& trace : *traces.find("traces")->array())
    if (from.empty() || trace.text("from") == from) found.push_back(*trace.text("to") + "." + *trace.text("kind"));
  return found;
}

TEST(ServerCore, publishes_online_heartbeats_and_the_zone_when_its_link_comes_up) {
  ServerFixture fixture;
  const auto connection = fixture.published_on(wire::server_connection_topic);
  ASSERT_THAT(connection, SizeIs(1));
  EXPECT_TRUE(connection[0].retained);
  EXPECT_EQ(connection[0].qos, 1);
  EXPECT_EQ(JsonValue::parse(connection[0].payload)->text("connectionState"), "ONLINE");
  const auto zone = fixture.published_on("cosiva/v1/zone/toml");
  ASSERT_THAT(zone, SizeIs(1));
  EXPECT_TRUE(zone[0].retained);
  EXPECT_EQ(zone[0].payload, oval().text) << "byte for byte";
  fixture.run_for(1s);
  EXPECT_THAT(fixture.published_on(wire::server_heartbeat_topic), SizeIs(11))
      << "at the first tick and at 100, 200 … 1000 ms";
}

TEST(ServerCore, has_a_last_will_and_publishes_offline_at_the_end) {
  ServerFixture fixture;
  const auto will = fixture.server->will();
  ASSERT_TRUE(will.has_value());
  EXPECT_EQ(JsonValue::parse(will->message.payload)->text("connectionState"), "CONNECTIONBROKEN");
  EXPECT_TRUE(will->message.retained);
  wire::Effects effects;
  fixture.server->farewell(fixture.now, effects);
  ASSERT_THAT(effects, SizeIs(1));
  EXPECT_EQ(JsonValue::parse(std::get<wire::Publish>(effects[0]).payload)->text("connectionState"), "OFFLINE");
}

TEST(ServerCore, subscribes_to_the_topics_of_vehicles_under_its_interface_and_to_zones) {
  ServerOptions options;
  options.interface_name = "plant7";
  EXPECT_THAT(ServerCore{options}.subscriptions(),
              ElementsAre("plant7/+/+/+/state", "plant7/+/+/+/visualization", "plant7/+/+/+/connection",
                          "plant7/+/+/+/factsheet", "cosiva/v1/zone/+", "cosiva/v1/virtual_obstacles_ack/+/+",
                          "cosiva/v1/detected_obstacle/+/+", "cosiva/v1/boards/+/+", "cosiva/v1/v2x/+/+/+/+",
                          "plant7/v2/CoSiVA.virtual/+/order", "plant7/v2/CoSiVA.virtual/+/instantActions",
                          "cosiva/v1/battery/change/+/+", "cosiva/v1/battery/test", "cosiva/v1/gvs/detections",
                          "cosiva/v1/gvs/connection", "cosiva/v1/reference/poses", "cosiva/v1/unit/+/+"));
}

TEST(ServerCore, builds_the_zone_in_the_article_s_order_and_shows_each_step) {
  ServerFixture fixture;
  const auto steps = kinds(fixture, "");
  EXPECT_THAT(
      std::vector(steps.begin(), steps.begin() + 8),
      ElementsAre("Simulator.zoneConfiguration", "RTM.initialise", "RTM.circuitFactory", "Simulator.circuitFactory",
                  "CircuitFactory.circuit", "Simulator.circuit", "Circuit.draw", "Simulator.draw"));
  EXPECT_EQ(fixture.server->zone_revision(), 1U);
  EXPECT_EQ(JsonValue::parse(fixture.server->zone_json())->text("name"), "oval");
}

TEST(ServerCore, takes_the_zone_from_the_physical_side_and_does_not_build_the_same_zone_twice) {
  ServerCore server{ServerOptions{}};
  wire::Effects effects;
  EXPECT_EQ(server.zone_json(), "null");
  const SimTime now = virtual_epoch;
  server.handle({now, wire::InputKind::message, "cosiva/v1/zone/toml", oval().text, true}, effects);
  EXPECT_EQ(server.zone_revision(), 1U);
  server.handle({now, wire::InputKind::message, "cosiva/v1/zone/toml", oval().text, true}, effects);
  EXPECT_EQ(server.zone_revision(), 1U);
}

TEST(ServerCore, keeps_its_zone_when_an_invalid_one_arrives) {
  ServerFixture fixture;
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", "name = ");
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/clay", "tablets");
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", "");
  EXPECT_EQ(fixture.server->zone_revision(), 1U);
  EXPECT_TRUE(fixture.logged("zone configuration refused"));
}

TEST(ServerCore, switches_the_zone_while_vehicles_drive_and_continues_on_the_new_one) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  std::string longer = oval().text;
  longer.replace(longer.find("\"oval\""), 6, "\"oval two\"");
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", longer);
  EXPECT_EQ(fixture.server->zone_revision(), 2U);
  fixture.run_for(10s);
  ASSERT_FALSE(aiv.orders.empty());
  EXPECT_EQ(aiv.orders.back().nodes.front().position->map_id, "oval two");
  EXPECT_EQ(*fixture.bijection().number("matched"), 1.0);
}

TEST(ServerCore, registers_a_vehicle_at_its_first_message_and_shows_its_twin_at_its_first_position) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV7", {0, 0.5});
  EXPECT_EQ(*fixture.bijection().number("virtual"), 0.0);
  EXPECT_THAT(*fixture.snapshot().find("aivs")->array(), IsEmpty());
  fixture.send(aiv, "state", vda::encode(aiv.state(fixture.now)));
  const JsonValue shown = fixture.aiv("CoSiVA/AIV7");
  EXPECT_EQ(*shown.number("number"), 7.0);
  EXPECT_NEAR(*shown.number("x"), 0.5, 1e-9);
  EXPECT_EQ(shown.text("section"), "south");
  EXPECT_NEAR(*shown.number("s"), 0.5, 1e-6);
  EXPECT_EQ(*fixture.bijection().number("matched"), 1.0);
  EXPECT_EQ(*fixture.bijection().find("events")->find("by_kind")->number("arrival"), 1.0);
  EXPECT_THAT(kinds(fixture, "AIV_Server"), testing::Contains("Simulator.appear"));
}

TEST(ServerCore, lists_the_vehicles_that_can_be_stopped_without_it) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv"}})");
  fixture.run_for(3s);
  auto targets = fixture.server->stop_targets();
  ASSERT_THAT(targets, SizeIs(1)) << "a virtual AIV drives inside the server";
  EXPECT_EQ(targets[0].name, "CoSiVA/AIV1");
  EXPECT_EQ(targets[0].actions_topic, "uagv/v2/CoSiVA/AIV1/instantActions");
  EXPECT_EQ(targets[0].state_topic, "uagv/v2/CoSiVA/AIV1/state");
  EXPECT_EQ(targets[0].version, "2.1.0");
  EXPECT_FALSE(targets[0].latched);
  fixture.command("stop", "*");
  EXPECT_TRUE(fixture.server->stop_targets()[0].latched);
  fixture.command("restart", "CoSiVA/AIV1");
  EXPECT_FALSE(fixture.server->stop_targets()[0].latched);
}

TEST(ServerCore, assigns_unique_display_numbers_by_serial_number) {
  ServerFixture fixture;
  for (const auto& [make, serial] : {std::pair{"CoSiVA", "AIV3"}, {"Acme", "truck-3"}, {"Acme", "nameless"}}) {
    FixtureVehicle& aiv = fixture.add(serial, {0, 0.5}, make);
    fixture.send(aiv, "state", vda::encode(aiv.state(fixture.now)));
  }
  EXPECT_EQ(*fixture.aiv("CoSiVA/AIV3").number("number"), 3.0);
  EXPECT_EQ(*fixture.aiv("Acme/truck-3").number("number"), 1.0);
  EXPECT_EQ(*fixture.aiv("Acme/nameless").number("number"), 2.0);
}

TEST(ServerCore, reports_how_late_its_cycle_ran) {
  ServerFixture fixture;
  fixture.run_for(2s);
  EXPECT_EQ(fixture.bijection().find("late_ms")->number("max"), 0.0) << "its cycle equals the fixture's step";
  fixture.now += 480ms;
  fixture.run_for(2s);
  EXPECT_NEAR(*fixture.bijection().find("late_ms")->number("max"), 480.0, 1e-6);
}

TEST(ServerCore, holds_the_bijection_of_a_driving_vehicle) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(60s);
  const JsonValue metrics = fixture.bijection();
  EXPECT_EQ(*metrics.number("matched_ratio"), 1.0);
  EXPECT_GT(*metrics.number("held_ratio"), 0.99);
  // At constant speed on the path the prediction is exact; only starts differ.
  EXPECT_LT(*metrics.find("divergence_m")->number("p50"), 1e-3);
  EXPECT_LT(*metrics.find("divergence_m")->number("p99"), 0.01);
  EXPECT_LE(*metrics.find("age_ms")->number("p99"), 150.0);
}

TEST(ServerCore, requests_a_missing_factsheet_once) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(10s);
  EXPECT_EQ(
      std::ranges::count_if(aiv.actions, [](const auto& m) { return m.actions[0].action_type == "factsheetRequest"; }),
      1);
}

TEST(ServerCore, numbers_its_traces_permanently_and_stores_the_latest) {
  ServerOptions options;
  options.traces_max = 50;
  ServerFixture fixture{oval(), options};
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(20s);
  const JsonValue all = *JsonValue::parse(fixture.server->traces_json(0, 1000));
  EXPECT_THAT(*all.find("traces")->array(), SizeIs(50));
  const double next = *all.number("next");
  EXPECT_EQ(*all.find("traces")->array()->back().number("n"), next - 1);
  const JsonValue none = *JsonValue::parse(fixture.server->traces_json(static_cast<std::uint64_t>(next), 10));
  EXPECT_THAT(*none.find("traces")->array(), IsEmpty());
  const JsonValue one = *JsonValue::parse(fixture.server->traces_json(static_cast<std::uint64_t>(next) - 5, 2));
  EXPECT_THAT(*one.find("traces")->array(), SizeIs(2));
}

/// The traces of this kind, each with its raw content.
std::vector<JsonValue> traced(const ServerFixture& fixture, std::string_view kind, std::string_view from) {
  std::vector<JsonValue> found;
  const JsonValue all = *JsonValue::parse(fixture.server->traces_json(0, 100'000));
  for (const JsonValue& trace : *all.find("traces")->array()) {
    if (trace.text("kind") != kind || trace.text("from") != from) continue;
    const auto whole = fixture.server->trace_json(static_cast<std::uint64_t>(*trace.number("n")));
    found.push_back(*JsonValue::parse(*whole));
  }
  return found;
}

TEST(ServerCore, traces_a_refused_message_with_its_text_and_the_reason) {
  ServerFixture fixture;
  FixtureVehicle& one = fixture.add("AIV1", {0, 0.5});
  const std::string broken = R"({"headerId":"seven"})";
  fixture.send(one, "factsheet", broken);
  const auto traces = traced(fixture, "factsheet", "CoSiVA/AIV1");
  ASSERT_THAT(traces, SizeIs(1));
  EXPECT_EQ(traces[0].text("raw"), broken);
  EXPECT_THAT(*traces[0].text("content"), testing::StartsWith("refused: "));
  EXPECT_THAT(*traces[0].text("content"), HasSubstr("headerId"));
}

TEST(ServerCore, traces_the_responses_of_the_sections_where_a_twin_enters_a_new_one) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 1.5});
  fixture.run_for(5s);  // at 0.3 m/s beyond the end of the first section, 2 m long, onto the half circle of 1.57 m
  const auto requested = traced(fixture, "nextAIVposition", "Simulator");
  const auto responses = traced(fixture, "position", "Circuit");
  ASSERT_THAT(requested, SizeIs(2)) << "the first section is too short (phase b), the second is not (phase c)";
  ASSERT_THAT(responses, SizeIs(2));
  EXPECT_THAT(*requested[0].text("content"),
              AllOf(testing::StartsWith("CoSiVA/AIV1 on south 1.9"), testing::EndsWith(" m to travel")));
  EXPECT_THAT(*responses[0].text("content"), testing::StartsWith("CoSiVA/AIV1 on south 2.00 m: 0.0"));
  EXPECT_THAT(*requested[1].text("content"), testing::StartsWith("CoSiVA/AIV1 on east 0.00 m: 0.0"));
  EXPECT_THAT(*responses[1].text("content"), testing::StartsWith("CoSiVA/AIV1 on east 0.0"));
}

TEST(ServerCore, gives_the_same_digest_for_the_same_inputs) {
  const auto run = [] {
    ServerFixture fixture{zone_file("lacet4.toml")};
    fixture.loss = 0.05;
    for (int i = 1; i <= 4; ++i)
      fixture.add("AIV" + std::to_string(i), fixture.zone->start_positions(4)[static_cast<std::size_t>(i - 1)]);
    fixture.run_for(20s);
    fixture.command("stop", "*");
    fixture.run_for(5s);
    Digest digest;
    fixture.server->fold(digest);
    for (const auto& message : fixture.published) digest.add(std::string_view{message.payload});
    return digest;
  };
  EXPECT_EQ(run(), run());
}

TEST(ServerOptions, are_preserved_by_their_json) {
  ServerOptions options;
  options.interface_name = "plant7";
  options.zone = oval();
  options.drive = false;
  options.lost_after = 2s;
  options.contract.age_p99_ms = 99.5;
  options.traces_max = 7;
  options.cycle = 100ms;
  options.virtual_rules = {};
  options.v2x = false;
  options.convoys = true;
  const auto back = server_options_from_json(to_json(options));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(to_json(*back), to_json(options));
  EXPECT_EQ(back->zone, options.zone);
  EXPECT_EQ(ServerCore{*back}.tick_period(), 100ms);
}

TEST(ServerOptions, of_a_journal_older_than_V2X_and_convoys_have_neither) {
  EXPECT_FALSE(server_options_from_json("{}")->v2x);
  EXPECT_FALSE(server_options_from_json("{}")->convoys);
  EXPECT_TRUE(server_options_from_json(to_json(ServerOptions{}))->v2x);
  ServerOptions together;
  together.convoys = true;
  EXPECT_TRUE(server_options_from_json(to_json(together))->convoys);
}

TEST(ServerOptions, of_a_journal_older_than_rules_have_crisp_virtual_AIVs) {
  EXPECT_EQ(server_options_from_json("{}")->virtual_rules, aiv::SpeedRules{});
  EXPECT_EQ(server_options_from_json(to_json(ServerOptions{}))->virtual_rules.kind, aiv::SpeedRules::Kind::fuzzy);
}

TEST(ServerOptions, refuse_invalid_values_and_name_the_field) {
  for (const auto& [json, field] : {std::pair{R"({"lost_after_ms":-1})", "lost_after_ms"},
                                    {R"({"cycle_ms":0.5})", "cycle_ms"},
                                    {R"({"traces_max":"many"})", "traces_max"},
                                    {R"({"zone":{"format":"x"}})", "zone"},
                                    {R"({"contract":{"age_p99_ms":0}})", "age_p99_ms"},
                                    {R"({"contract":3})", "contract"}}) {
    const auto read = server_options_from_json(json);
    ASSERT_FALSE(read.has_value()) << json;
    EXPECT_EQ(read.error().location, field);
  }
  EXPECT_FALSE(server_options_from_json("[]").has_value());
  EXPECT_FALSE(server_options_from_json("{").has_value());
}

/// Servers with the link up that differ in their last inputs only.
class Folded : public testing::Test {
 protected:
  Folded() { options.zone = oval(); }
  using Inputs = std::vector<std::pair<std::string, std::string>>;  ///< topic and payload; a command has no topic

  [[nodiscard]] static wire::State state(std::uint32_t header_id, double x_m, SimTime at = virtual_epoch) {
    wire::State made;
    made.header = {header_id, at, "2.1.0", "CoSiVA", "AIV1"};
    made.position = wire::AgvPosition{{x_m, 0.0, 0.0}, "oval", true, {}, {}};
    return made;
  }
  [[nodiscard]] static std::pair<std::string, std::string> sent(const wire::State& message) {
    return {"uagv/v2/CoSiVA/AIV1/state", vda::encode(message)};
  }
  [[nodiscard]] static std::pair<std::string, std::string> connection_of(const std::string& manufacturer,
                                                                         const std::string& serial) {
    const wire::Connection message{{1, virtual_epoch, "2.1.0", manufacturer, serial}, wire::ConnectionState::online};
    return {"uagv/v2/" + manufacturer + "/" + serial + "/connection", vda::encode(message)};
  }
  [[nodiscard]] Digest digest_of(const Inputs& inputs, bool last_is_retained = false) const {
    ServerCore server{options};
    wire::Effects effects;
    server.handle({virtual_epoch, wire::InputKind::link, "", "up"}, effects);
    for (const auto& [topic, payload] : inputs) {
      const bool retained = last_is_retained && &topic == &inputs.back().first;
      const auto kind = topic.empty() ? wire::InputKind::command : wire::InputKind::message;
      server.handle({virtual_epoch, kind, topic, payload, retained}, effects);
    }
    Digest digest;
    server.fold(digest);
    return digest;
  }
  void expect_different(const Inputs& one, const Inputs& other) const { EXPECT_NE(digest_of(one), digest_of(other)); }
  ServerOptions options;
  const std::pair<std::string, std::string> cleared{"uagv/v2/CoSiVA/AIV1/state", ""};
};

TEST_F(Folded, server_has_the_digest_of_its_inputs) {
  const Inputs inputs{
      connection_of("CoSiVA", "AIV1"), sent(state(1, 0.5)), {"", R"({"command":"stop","vehicle":"*"})"}};
  EXPECT_EQ(digest_of(inputs), digest_of(inputs));
}

TEST_F(Folded, twins_show_in_the_digest) { expect_different({sent(state(1, 0.5))}, {sent(state(1, 0.6))}); }

TEST_F(Folded, names_of_vehicles_show_in_the_digest) {
  expect_different({connection_of("Acme", "x1")}, {connection_of("Other", "y1")});
}

TEST_F(Folded, counters_of_a_vehicle_show_in_the_digest) {
  const auto first = sent(state(1, 0.5));
  expect_different({first}, {first, cleared});                        // messages
  expect_different({first, sent(state(2, 0.5, virtual_epoch + 1s))},  // missed
                   {first, sent(state(3, 0.5, virtual_epoch + 1s))});
  expect_different({first, cleared}, {first, first});                       // outdated: the same again
  EXPECT_NE(digest_of({first, cleared}), digest_of({first, first}, true));  // refused: it is retained
  EXPECT_NE(digest_of({first, first}), digest_of({first, first}, true));
}

TEST_F(Folded, priorities_show_in_the_digest) {
  const Inputs inputs{connection_of("CoSiVA", "AIV1")};
  options.zone->text += "[priorities]\n\"CoSiVA/AIV1\" = 5\n";
  const Digest five = digest_of(inputs);
  options.zone->text.replace(options.zone->text.rfind('5'), 1, "6");
  EXPECT_NE(digest_of(inputs), five);
}

TEST_F(Folded, missions_and_closed_sections_show_in_the_digest) {
  const auto vehicle = connection_of("CoSiVA", "AIV1");
  const auto rtm = zone::Rtm::initialise(oval());
  const auto go = [&](std::size_t waypoint) {
    return std::pair<std::string, std::string>{
        "", R"({"command":"go","vehicle":"CoSiVA/AIV1","to":")" + rtm->zone().waypoints[waypoint].id + "\"}"};
  };
  expect_different({vehicle, go(2)}, {vehicle, go(3)});
  expect_different({{"", R"({"command":"close","section":"east"})"}},
                   {{"", R"({"command":"close","section":"west"})"}});
}

TEST_F(Folded, commands_show_in_the_digest) {
  expect_different({{"", R"({"id":"c1","command":"stop","vehicle":"CoSiVA/AIV1"})"}},
                   {{"", R"({"id":"c2","command":"stop","vehicle":"CoSiVA/AIV1"})"}});
}

TEST_F(Folded, virtual_aivs_show_in_the_digest) {
  const auto add = [](const char* s) {
    return std::pair<std::string, std::string>{
        "", std::string(R"({"command":"add","virtualObject":{"kind":"aiv","section":"south","s":)") + s + "}}"};
  };
  expect_different({add("0.5")}, {add("0.6")});
}

TEST_F(Folded, what_a_virtual_aiv_perceives_shows_in_the_digest) {
  const std::pair<std::string, std::string> v1{
      "", R"({"command":"add","virtualObject":{"kind":"aiv","id":"V1","section":"south","s":0.5}})"};
  const std::pair<std::string, std::string> p1{
      "", R"({"command":"add","virtualObject":{"kind":"person","id":"P1","x":1.5,"y":0.5}})"};
  const auto ack = [](bool braking) {
    return std::pair<std::string, std::string>{
        "cosiva/v1/virtual_obstacles_ack/CoSiVA.virtual/V1",
        wire::to_json(wire::VirtualObstaclesAck{0, virtual_epoch, braking, braking ? "P1" : "", {}})};
  };
  expect_different({v1, p1, ack(true)}, {v1, p1, ack(false)});
}

TEST_F(Folded, edits_show_in_the_digest) {
  const auto command = [](const char* json) { return std::pair<std::string, std::string>{"", json}; };
  const auto add = command(R"({"command":"edit","edit":{"addTags":[{"number":5,"section":"south","s":1.0}]}})");
  const auto remove = command(R"({"command":"edit","edit":{"removeTags":[5]}})");
  const auto undo = command(R"({"command":"undo"})");
  expect_different({add, remove}, {add, undo});
}

TEST_F(Folded, owners_of_vehicles_show_in_the_digest) {
  options.area = "a";
  const auto owner = [](const std::string& area) {
    return std::pair<std::string, std::string>{"cosiva/v1/owner/CoSiVA/AIV1",
                                               wire::to_json(wire::Owner{area, 1, virtual_epoch, {}, {}})};
  };
  expect_different({owner("b")}, {owner("c")});
}

TEST_F(Folded, detections_of_the_camera_show_in_the_digest) {
  const auto detection = [](double x_m) {
    wire::GvsDetections detections{
        1, virtual_epoch, 0.5, {{"CoSiVA/AIV9", 9, virtual_epoch, {x_m, 0.0, 0.0}, 0.01}}, {}};
    return std::pair<std::string, std::string>{std::string(wire::gvs_detections_topic), wire::to_json(detections)};
  };
  expect_different({detection(0.5)}, {detection(0.6)});
}

TEST_F(Folded, refused_messages_and_traces_show_in_the_digest) {
  expect_different({}, {{"uagv/v3/Acme/x1/state", "{}"}});
  expect_different({}, {{"", R"({"command":"close","section":"nowhere"})"}});
}

TEST(EarlierCommands, wait_for_a_zone_that_they_need_and_the_others_only_for_5_seconds) {
  const std::string slow = R"({"command":"slow","vehicle":"*"})";
  const char* add = R"({"command":"add","virtualObject":{"id":"P1","kind":"person","x":0.5,"y":0.2}})";
  ServerCore server{ServerOptions{}};
  wire::Effects effects;
  const auto tick = [&](SimDuration after) {
    server.handle({virtual_epoch + after, wire::InputKind::tick, "", ""}, effects);
  };
  tick(0s);
  tick(5s);
  EXPECT_FALSE(server.takes_earlier_command(slow));
  tick(6s);
  EXPECT_TRUE(server.takes_earlier_command(slow));
  EXPECT_TRUE(server.takes_earlier_command(R"({"command":"remove","id":"P1"})"));
  for (const char* needs : {R"({"command":"move","virtualObject":{"id":"P1","x":0.4,"y":0.6}})",
                            R"({"command":"close","section":"east"})", R"({"command":"circulate","vehicle":"*"})",
                            R"({"command":"undo"})", R"({"command":"plant","plant":{"removeObstacle":"box"}})", add})
    EXPECT_FALSE(server.takes_earlier_command(needs)) << needs;
  const zone::ZoneConfiguration zone = oval();
  server.handle({virtual_epoch + 3600s, wire::InputKind::message, std::string(wire::zone_topic_prefix) + zone.format,
                 zone::to_payload(zone)},
                effects);
  EXPECT_TRUE(server.takes_earlier_command(add));
}

}  // namespace
}  // namespace cosiva::virtual_side
