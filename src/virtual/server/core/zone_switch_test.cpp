// Switching from one zone to another while vehicles drive.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::string switch_to(const zone::ZoneConfiguration& configuration) {
  JsonWriter json;
  json.begin_object().field("command", "switch");
  zone::write_json(json.key("zone"), configuration);
  json.end_object();
  return json.take();
}
JsonValue zone_of(const ServerFixture& fixture) { return *fixture.snapshot().find("zone"); }
zone::ZoneConfiguration moved_oval(const std::string& name, const std::string& y) {
  zone::ZoneConfiguration configuration = oval();
  configuration.origin = name;
  configuration.text.replace(configuration.text.find("\"oval\""), 6, "\"" + name + "\"");
  configuration.text.replace(configuration.text.find("y = 0.0"), 7, "y = " + y);
  return configuration;
}

TEST(Switch, snaps_vehicles_to_the_new_path_where_they_are_and_loses_no_twin) {
  ServerFixture fixture;
  FixtureVehicle& one = fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& two = fixture.add("AIV2", {2, 0.5});
  fixture.run_for(3s);
  std::size_t fewest = 2;
  int touches = 0;
  fixture.each_step = [&] {
    fewest = std::min(fewest, fixture.snapshot().find("aivs")->array()->size());
    touches += fixture.touches();
  };
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
  fixture.run_for(8s);
  EXPECT_EQ(fewest, 2U);
  EXPECT_EQ(touches, 0);
  for (const FixtureVehicle* aiv : {&one, &two}) {
    EXPECT_EQ(aiv->map_id, "yard");
    EXPECT_FALSE(aiv->off_path.has_value());
    EXPECT_THAT(aiv->refusals, IsEmpty());
    EXPECT_EQ(aiv->orders.back().nodes.front().position->map_id, "yard");
    EXPECT_GT(aiv->speed_mps, 0.0);
  }
  const JsonValue zone = zone_of(fixture);
  const JsonValue* switched = zone.find("switched");
  EXPECT_EQ(switched->text("from"), "oval");
  EXPECT_EQ(*switched->number("snapped"), 2.0);
  EXPECT_THAT(*switched->find("offRoute")->array(), IsEmpty());
  EXPECT_LT(*switched->number("first_moving_ms"), 1000.0);
  EXPECT_TRUE(zone.find("refused")->is_null());
  EXPECT_EQ(*fixture.bijection().number("matched_ratio"), 1.0);
  const auto published = fixture.published_on("cosiva/v1/zone/toml");
  ASSERT_FALSE(published.empty());
  EXPECT_TRUE(published.back().retained);
  EXPECT_EQ(published.back().payload, moved_oval("yard", "0.1").text);
}

TEST(Switch, reports_vehicles_too_far_from_every_new_section_as_off_route) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(1s);
  fixture.send_command(switch_to(moved_oval("far", "-3.0")));
  const std::size_t orders = aiv.orders.size();
  fixture.run_for(5s);
  EXPECT_EQ(aiv.orders.size(), orders);
  EXPECT_THAT(fixture.aiv("CoSiVA/AIV1").text("offRoute").value_or(""), HasSubstr("from the nearest section of 'far'"));
  const JsonValue zone = zone_of(fixture);
  ASSERT_THAT(*zone.find("switched")->find("offRoute")->array(), SizeIs(1));
  EXPECT_TRUE(zone.find("switched")->find("first_moving_ms")->is_null());
  EXPECT_TRUE(fixture.logged("off-route: it is"));
  aiv.put({1.0, -2.9, 0.4});
  fixture.run_for(5s);
  EXPECT_TRUE(fixture.aiv("CoSiVA/AIV1").find("offRoute")->is_null());
  EXPECT_GT(aiv.driven_m, 0.2) << "it was moved close to a section";
}

TEST(Switch, lets_a_vehicle_join_the_path_elsewhere_where_another_obstructs_the_nearest_position) {
  ServerFixture fixture;
  FixtureVehicle& one = fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& two = fixture.add("AIV2", {2, 0.5});
  fixture.run_for(1s);
  two.paused = true;
  fixture.run_for(1s);
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  // The new path is at y = 0.1; while turning onto it, the first vehicle would hit the second one, which is next to the
  // path on the other side.
  one.put({1.0, 0.0, 0.0});
  two.put({1.0, 0.255, 0.0});
  int touches = 0;
  fixture.each_step = [&] { touches += fixture.touches(); };
  fixture.run_for(12s);
  EXPECT_EQ(touches, 0);
  const auto commanded = std::ranges::find_if(one.actions, [](const wire::InstantActions& message) {
    return message.actions.front().action_type == "joinLine";
  });
  ASSERT_NE(commanded, one.actions.end());
  EXPECT_NEAR(commanded->actions.front().number("y").value_or(0.0), 0.1, 1e-6);
  EXPECT_GT(std::fabs(commanded->actions.front().number("x").value_or(1.0) - 1.0), 0.04);
  EXPECT_FALSE(one.off_path.has_value());
  EXPECT_GT(one.driven_m, 0.5);
}

TEST(Switch, to_a_zone_that_cannot_be_built_leaves_the_old_one_in_force_and_reports_the_reason) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(2s);
  zone::ZoneConfiguration broken = oval();
  broken.origin = "broken.zone";
  broken.text.resize(broken.text.size() / 2);
  EXPECT_NE(fixture.refusal(switch_to(broken)), "");
  fixture.send_command(switch_to(broken));
  EXPECT_EQ(zone_of(fixture).text("name"), "oval");
  EXPECT_EQ(zone_of(fixture).find("refused")->text("origin"), "broken.zone");
  EXPECT_NE(zone_of(fixture).find("refused")->text("why").value_or(""), "");
  const double driven_m = aiv.driven_m;
  fixture.run_for(5s);
  EXPECT_GT(aiv.driven_m, driven_m + 1.0);
  EXPECT_THAT(fixture.refusal(switch_to(oval())), HasSubstr("in force already"));
  EXPECT_NE(fixture.refusal(R"({"command":"switch"})"), "");
  fixture.send_command(switch_to(moved_oval("good", "0.05")));
  EXPECT_TRUE(zone_of(fixture).find("refused")->is_null());
}

TEST(Switch, twice_in_one_tick_ends_on_the_second) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(2s);
  fixture.send_command(switch_to(moved_oval("first", "0.05")));
  fixture.send_command(switch_to(moved_oval("second", "0.1")));
  fixture.run_for(6s);
  EXPECT_EQ(zone_of(fixture).text("name"), "second");
  EXPECT_EQ(aiv.map_id, "second");
  EXPECT_EQ(aiv.orders.back().nodes.front().position->map_id, "second");
  EXPECT_GT(aiv.speed_mps, 0.0);
}

TEST(Switch, in_a_crossing_and_back_again_causes_no_contact) {
  ServerFixture fixture{zone_file("lacet4.toml")};
  int number = 0;
  for (const zone::TrackPosition position : fixture.zone->start_positions(6))
    fixture.add("AIV" + std::to_string(++number), position);
  int touches = 0;
  fixture.each_step = [&] { touches += fixture.touches(); };
  zone::ZoneConfiguration other = zone_file("lacet4.toml");
  const std::size_t name = other.text.find("name = ");
  other.text.replace(name, other.text.find('\n', name) - name, "name = \"other\"");
  for (int i = 0; i < 6; ++i) {
    fixture.run_for(7s);
    fixture.send_command(switch_to(i % 2 == 0 ? other : zone_file("lacet4.toml")));
  }
  std::vector<double> driven;
  for (const auto& aiv : fixture.vehicles) driven.push_back(aiv->driven_m);
  fixture.run_for(60s);
  EXPECT_EQ(touches, 0);
  for (std::size_t i = 0; i < fixture.vehicles.size(); ++i) {
    EXPECT_GT(fixture.vehicles[i]->driven_m, driven[i] + 3.0) << i;
    EXPECT_THAT(fixture.vehicles[i]->refusals, IsEmpty());
  }
}

TEST(Switch, waits_a_limited_time_for_a_vehicle_that_still_moves_on_the_old_map) {
  ServerFixture fixture;
  FixtureVehicle& good = fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& deaf = fixture.add("AIV2", {2, 0.5});
  deaf.takes_zones = false;
  deaf.deaf_to = {"cancelOrder"};
  fixture.run_for(2s);
  deaf.cruise_mps = 0.01;  // creeps for minutes
  fixture.send_command(switch_to(moved_oval("yard", "0.05")));
  fixture.run_for(500ms);
  const std::size_t orders = good.orders.size();
  fixture.run_for(5s);
  EXPECT_EQ(good.orders.size(), orders) << "one vehicle still moves";
  fixture.run_for(8s);
  EXPECT_GT(good.orders.size(), orders);
  EXPECT_THAT(fixture.aiv("CoSiVA/AIV2").text("offRoute").value_or(""), HasSubstr("is on map 'oval'"));
}

TEST(Switch, loses_no_pending_command) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(2s);
  fixture.command("slow", "CoSiVA/AIV1", "c9");
  fixture.send_command(switch_to(moved_oval("yard", "0.05")));
  fixture.run_for(4s);
  EXPECT_EQ(fixture.command_entry("c9").text("state"), "materialised");
}

TEST(Switch, deploys_the_map_to_a_third_party_vehicle_as_the_standard_specifies) {
  ServerOptions options;
  options.map_download_link = "http://example.test/zone";
  ServerFixture fixture{oval(), options};
  FixtureVehicle& agv = fixture.add("agv-7", {0, 0.5}, "Acme");
  agv.maps = {{"oval", "1", "", true}};
  wire::Factsheet factsheet;
  factsheet.header = agv.header(fixture.now, 0);
  for (const char* action : {"downloadMap", "enableMap", "initPosition", "cancelOrder"})
    factsheet.actions.push_back({action, "", true, false, false, {}});
  fixture.send(agv, "factsheet", vda::encode(factsheet));
  fixture.run_for(2s);
  agv.downloads.push_back(zone::Rtm::initialise(moved_oval("yard", "0.02"))->shared_zone());
  fixture.send_command(switch_to(moved_oval("yard", "0.02")));
  fixture.run_for(15s);
  std::vector<std::string> requested;
  for (const wire::InstantActions& message : agv.actions) requested.push_back(message.actions.front().action_type);
  EXPECT_THAT(requested, testing::IsSupersetOf({"cancelOrder", "downloadMap", "enableMap", "initPosition"}));
  EXPECT_EQ(agv.map_id, "yard");
}

TEST(Switch, sends_no_orders_to_a_third_party_vehicle_on_another_map) {
  ServerFixture fixture;
  FixtureVehicle& agv = fixture.add("agv-7", {0, 0.5}, "Acme");
  agv.map_id = "floor 1";
  fixture.run_for(5s);
  EXPECT_THAT(agv.orders, IsEmpty());
  EXPECT_THAT(fixture.aiv("Acme/agv-7").text("offRoute").value_or(""), HasSubstr("is on map 'floor 1'"));
  EXPECT_EQ(fixture.aiv("Acme/agv-7").text("map"), "floor 1");
}

TEST(Switch, clears_the_undo_list_and_ignores_its_own_echo) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"edit","edit":{"addTags":[{"number":5,"section":"south","s":1.0}]}})");
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
  EXPECT_EQ(*fixture.snapshot().find("zoneEdits")->number("undo"), 0.0);
  EXPECT_EQ(fixture.snapshot().find("zoneEdits")->flag("unsaved"), false);
}

TEST(Switch, persists_over_a_restart_of_the_server_with_the_first_zone) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(1s);
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  fixture.send_command(R"({"command":"edit","edit":{"addTags":[{"number":5,"section":"south","s":1.0}]}})");
  fixture.run_for(5s);
  fixture.restart_server(true);
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
  EXPECT_EQ(*fixture.snapshot().find("zoneEdits")->number("undo"), 1.0);
  fixture.run_for(5s);
  EXPECT_EQ(aiv.map_id, "yard");
  EXPECT_GT(aiv.speed_mps, 0.0);
  EXPECT_THAT(aiv.refusals, IsEmpty());
}

TEST(RetainedZones, of_two_formats_do_not_replace_the_one_in_force_in_either_order) {
  for (const bool in_force_first : {true, false}) {
    ServerFixture fixture;
    fixture.run_for(1s);
    fixture.feed(wire::InputKind::link, "", "down");
    fixture.feed(wire::InputKind::link, "", "up");
    const auto retained = [&](const zone::ZoneConfiguration& zone) {
      fixture.feed(wire::InputKind::message, "cosiva/v1/zone/" + zone.format, zone::to_payload(zone), true);
    };
    if (in_force_first) retained(oval());
    retained(moved_oval("stale", "0.2"));
    if (!in_force_first) retained(oval());
    fixture.run_for(1s);
    EXPECT_EQ(zone_of(fixture).text("name"), "oval");
    EXPECT_TRUE(fixture.logged("retains another zone"));
  }
}

TEST(RetainedZones, of_which_none_is_in_force_are_replaced_by_the_last_one) {
  ServerFixture fixture;
  fixture.run_for(1s);
  fixture.feed(wire::InputKind::link, "", "down");
  fixture.feed(wire::InputKind::link, "", "up");
  for (const char* name : {"a", "b"})
    fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", moved_oval(name, "0.1").text, true);
  fixture.run_for(1s);
  EXPECT_EQ(zone_of(fixture).text("name"), "b");
}

TEST(Switch, takes_a_virtual_vehicle_along) {
  ServerFixture fixture;
  fixture.send_command(R"({"command":"add","virtualObject":{"id":"V1","kind":"aiv","section":"south","s":0.5}})");
  fixture.run_for(4s);
  ASSERT_GT(*fixture.aiv("CoSiVA.virtual/V1").number("speed"), 0.0);
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  fixture.run_for(10s);
  const JsonValue aiv = fixture.aiv("CoSiVA.virtual/V1");
  EXPECT_EQ(aiv.text("map"), "yard");
  EXPECT_TRUE(aiv.find("offRoute")->is_null());
  EXPECT_GT(*aiv.number("speed"), 0.0);
}

/// The calls of Rtm::initialise while `act` runs.
std::uint64_t builds_during(const std::function<void()>& act) {
  const std::uint64_t before = zone::Rtm::initialised_count();
  act();
  return zone::Rtm::initialised_count() - before;
}

TEST(RtmBuilds, happen_once_at_start_up) {
  ServerOptions options;
  options.zone = oval();
  std::unique_ptr<ServerCore> server;
  wire::Effects effects;
  const auto start = [&] {
    server = std::make_unique<ServerCore>(options);
    server->handle({virtual_epoch, wire::InputKind::link, "", "up"}, effects);
  };
  EXPECT_EQ(builds_during(start), 1U);
  options.rtm = std::make_shared<const zone::Rtm>(*zone::Rtm::initialise(oval()));
  EXPECT_EQ(builds_during(start), 0U) << "the program has built it to check its command line";
  EXPECT_EQ(server->zone(), options.rtm->shared_zone());
}

TEST(RtmBuilds, happen_once_in_a_switch_also_where_it_is_checked_first_and_virtual_aivs_drive) {
  ServerFixture fixture;
  EXPECT_EQ(builds_during([&] {
              for (const char* section : {"south", "north"})
                fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":")" +
                                     std::string(section) + R"(","s":0.5}})");
              fixture.run_for(1s);
            }),
            0U);
  ASSERT_THAT(*fixture.snapshot().find("aivs")->array(), SizeIs(2));
  const std::string command = switch_to(moved_oval("yard", "0.1"));
  EXPECT_EQ(builds_during([&] {
              EXPECT_EQ(fixture.refusal(command), "");
              fixture.send_command(command);
              fixture.run_for(1s);
            }),
            1U);
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
}

TEST(RtmBuilds, do_not_happen_in_a_switch_whose_sender_has_built_the_zone) {
  ServerFixture fixture;
  const auto send_built = [&](const zone::ZoneConfiguration& configuration) {
    const std::string command = switch_to(configuration);
    const auto decoded = std::make_shared<const DecodedCommand>(command, DecodedCommand::Zone::built);
    EXPECT_EQ(builds_during([&] {
                fixture.feed(wire::InputKind::command, "test", command, false, decoded);
                fixture.run_for(1s);
              }),
              0U);
  };
  send_built(moved_oval("yard", "0.1"));
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
  send_built({"toml", "bad.toml", "name = 7"});
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
  EXPECT_EQ(zone_of(fixture).find("refused")->text("origin"), "bad.toml");
}

TEST(RtmBuilds, happen_once_for_a_zone_from_the_broker_also_where_it_cannot_be_used) {
  ServerFixture fixture;
  EXPECT_EQ(builds_during([&] {
              fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", moved_oval("yard", "0.1").text, true);
              fixture.run_for(1s);
            }),
            1U);
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
  const std::string command = switch_to({"toml", "bad.toml", "name = 7"});
  EXPECT_EQ(builds_during([&] {
              fixture.send_command(command);
              EXPECT_NE(fixture.refusal(command), "");
            }),
            1U);
}

TEST(RtmBuilds, happen_once_in_an_edit_also_where_it_is_checked_first) {
  ServerFixture fixture;
  const std::string command = R"({"command":"edit","edit":{"addTags":[{"number":77,"section":"south","s":0.3}]}})";
  EXPECT_EQ(builds_during([&] {
              EXPECT_EQ(fixture.refusal(command), "");
              fixture.send_command(command);
              fixture.run_for(1s);
            }),
            1U);
}

// --- the zone in force, the broker and the state file ----------------------------------------------------------------

const std::string tag_edit = R"({"command":"edit","edit":{"addTags":[{"number":5,"section":"south","s":1.0}]}})";

/// What the server would restore if it were killed now.
std::string& written_state(ServerFixture& fixture) { return fixture.persisted; }
void relink(ServerFixture& fixture) {
  fixture.feed(wire::InputKind::link, "", "down");
  fixture.feed(wire::InputKind::link, "", "up");
}
void receive_zone(ServerFixture& fixture, const zone::ZoneConfiguration& zone, bool retained = false) {
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/" + zone.format, zone::to_payload(zone), retained);
}
void tick_after(ServerFixture& fixture, SimDuration duration) {
  fixture.now += duration;
  fixture.feed(wire::InputKind::tick, "", "");
}
/// The contents of the traces of received zones.
std::vector<std::string> received_zones(const ServerCore& server) {
  std::vector<std::string> found;
  const JsonValue traces = *JsonValue::parse(server.traces_json(0, 100'000));
  for (const JsonValue& trace : *traces.find("traces")->array())
    if (trace.text("from") == "physical side" && trace.text("kind") == "zone") found.push_back(*trace.text("content"));
  return found;
}
std::string bytes_of(const zone::ZoneConfiguration& zone) {
  return "toml, " + std::to_string(zone.text.size()) + " bytes";
}

TEST(RetainedZones, wait_for_others_until_three_hundred_milliseconds_after_the_link_came_up) {
  ServerFixture fixture;
  fixture.now += 299ms;
  receive_zone(fixture, moved_oval("yard", "0.1"), true);
  tick_after(fixture, 0ms);
  EXPECT_EQ(zone_of(fixture).text("name"), "oval");
  tick_after(fixture, 1ms);
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
}

TEST(RetainedZones, are_taken_at_once_from_three_hundred_milliseconds_on) {
  ServerFixture fixture;
  fixture.now += 300ms;
  receive_zone(fixture, moved_oval("yard", "0.1"), true);
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
}

TEST(RetainedZones, of_an_earlier_connection_are_dropped) {
  ServerFixture fixture;
  fixture.now += 100ms;
  receive_zone(fixture, moved_oval("yard", "0.1"), true);
  relink(fixture);
  tick_after(fixture, 400ms);
  EXPECT_EQ(zone_of(fixture).text("name"), "oval");
}

TEST(RetainedZones, confirm_the_zone_in_force_for_one_connection_only) {
  ServerFixture fixture;
  fixture.now += 100ms;
  receive_zone(fixture, oval(), true);
  relink(fixture);
  receive_zone(fixture, moved_oval("yard", "0.1"), true);
  tick_after(fixture, 300ms);
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
}

TEST(RetainedZones, that_are_the_edited_zone_or_its_original_confirm_the_edited_zone) {
  for (const bool original : {false, true}) {
    ServerFixture fixture;
    fixture.send_command(tag_edit);
    const zone::ZoneConfiguration edited = *fixture.server->zone_configuration();
    relink(fixture);
    receive_zone(fixture, original ? oval() : edited, true);
    receive_zone(fixture, moved_oval("stale", "0.2"), true);
    tick_after(fixture, 300ms);
    EXPECT_EQ(fixture.server->zone_configuration()->text, edited.text) << original;
    EXPECT_TRUE(fixture.logged("the broker retains another zone besides the one in force, on cosiva/v1/zone/toml"));
  }
}

TEST(RetainedZones, do_not_replace_the_zone_that_an_operator_chose_while_the_broker_was_dead) {
  ServerFixture fixture;
  const zone::ZoneConfiguration yard = moved_oval("yard", "0.1");
  fixture.feed(wire::InputKind::link, "", "down");
  fixture.send_command(switch_to(yard));
  // A broker sends what it retained before the zone that it receives from the server.
  const auto handle = [&](wire::InputKind kind, const std::string& source, std::string payload, bool retained = false) {
    wire::Effects effects;
    fixture.server->handle({fixture.now, kind, source, std::move(payload), retained}, effects);
  };
  handle(wire::InputKind::link, "", "up");
  handle(wire::InputKind::message, "cosiva/v1/zone/toml", oval().text, true);
  handle(wire::InputKind::message, "cosiva/v1/zone/toml", yard.text);
  tick_after(fixture, 300ms);
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
  EXPECT_FALSE(fixture.logged("retains another zone")) << "the server's zone has replaced it";
}

TEST(RetainedZones, that_wait_are_dropped_when_an_operator_switches_to_another_one) {
  ServerFixture fixture;
  fixture.now += 100ms;
  receive_zone(fixture, moved_oval("stale", "0.2"), true);
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  tick_after(fixture, 300ms);
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
}

TEST(ZoneSession, publishes_its_edits_again_when_it_receives_the_original) {
  ServerFixture fixture;
  receive_zone(fixture, oval());
  EXPECT_THAT(fixture.published_on("cosiva/v1/zone/toml"), SizeIs(1)) << "nothing was edited";
  fixture.send_command(tag_edit);
  const std::string edited = fixture.server->zone_configuration()->text;
  ASSERT_THAT(fixture.published_on("cosiva/v1/zone/toml"), SizeIs(2));
  receive_zone(fixture, oval());
  const auto published = fixture.published_on("cosiva/v1/zone/toml");
  ASSERT_THAT(published, SizeIs(3));
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_EQ(published[i].payload, edited);
    EXPECT_TRUE(published[i].retained);
    EXPECT_EQ(published[i].qos, 1);
  }
}

TEST(ZoneSession, traces_the_zones_that_it_receives_but_not_its_own) {
  ServerFixture fixture;
  EXPECT_THAT(received_zones(*fixture.server), IsEmpty()) << "it was given one and received its own echo";
  const zone::ZoneConfiguration yard = moved_oval("yard", "0.1");
  receive_zone(fixture, yard);
  EXPECT_THAT(received_zones(*fixture.server), ElementsAre(bytes_of(yard)));
  fixture.send_command(tag_edit);
  EXPECT_THAT(received_zones(*fixture.server), SizeIs(1));
}

TEST(ZoneSession, expects_no_echo_over_a_lost_link) {
  ServerOptions options;
  options.zone = oval();
  ServerCore server{options};
  wire::Effects effects;
  for (const char* state : {"up", "down", "up"})
    server.handle({virtual_epoch, wire::InputKind::link, "", state}, effects);
  for (int i = 0; i < 2; ++i)
    server.handle({virtual_epoch, wire::InputKind::message, "cosiva/v1/zone/toml", oval().text}, effects);
  EXPECT_THAT(received_zones(server), ElementsAre(bytes_of(oval()))) << "the first one is the echo of the second link";
}

TEST(ZoneSession, publishes_the_zone_that_an_operator_edited_or_chose_when_the_link_comes_up_and_not_the_broker_s) {
  ServerCore server{ServerOptions{}};
  wire::Effects effects;
  const auto feed = [&](wire::InputKind kind, const std::string& source, const std::string& payload) {
    effects.clear();
    server.handle({virtual_epoch, kind, source, payload}, effects);
  };
  const auto published_with_the_link = [&] {
    feed(wire::InputKind::link, "", "down");
    feed(wire::InputKind::link, "", "up");
    std::vector<std::string> payloads;
    for (const wire::Effect& effect : effects)
      if (const auto* message = std::get_if<wire::Publish>(&effect); message != nullptr)
        if (message->topic == "cosiva/v1/zone/toml") payloads.push_back(message->payload);
    return payloads;
  };
  feed(wire::InputKind::message, "cosiva/v1/zone/toml", oval().text);
  EXPECT_THAT(published_with_the_link(), IsEmpty());
  feed(wire::InputKind::command, "test", tag_edit);
  EXPECT_THAT(published_with_the_link(), ElementsAre(server.zone_configuration()->text));
  const zone::ZoneConfiguration yard = moved_oval("yard", "0.1");
  feed(wire::InputKind::command, "test", switch_to(yard));
  EXPECT_THAT(published_with_the_link(), ElementsAre(yard.text));
}

TEST(ZoneSession, publishes_nothing_while_the_link_is_down) {
  ServerFixture fixture;
  fixture.feed(wire::InputKind::link, "", "down");
  fixture.send_command(tag_edit);
  EXPECT_THAT(fixture.published_on("cosiva/v1/zone/toml"), SizeIs(1)) << "from the start";
  fixture.feed(wire::InputKind::link, "", "up");
  const auto published = fixture.published_on("cosiva/v1/zone/toml");
  ASSERT_THAT(published, SizeIs(2));
  EXPECT_EQ(published[1].payload, fixture.server->zone_configuration()->text);
}

TEST(ZoneSession, refuses_an_unusable_zone_of_the_broker_and_retains_its_edits) {
  ServerFixture fixture;
  fixture.send_command(tag_edit);
  fixture.now += 250ms;
  receive_zone(fixture, {"toml", "x", "name = 7", ""});
  const JsonValue zone = zone_of(fixture);
  EXPECT_EQ(zone.text("name"), "oval");
  EXPECT_EQ(zone.number("revision"), 2.0);
  EXPECT_EQ(zone.find("refused")->text("origin"), "cosiva/v1/zone/toml");
  EXPECT_EQ(zone.find("refused")->number("at"), to_milliseconds_scaled(fixture.now));
  EXPECT_TRUE(zone.find("switched")->is_null());
  EXPECT_EQ(JsonValue::parse(fixture.server->summary_json())->number("messages_refused"), 1.0);
  EXPECT_EQ(fixture.snapshot().find("zoneEdits")->number("undo"), 1.0);
  EXPECT_TRUE(fixture.logged("; the previous zone stays in force"));
  fixture.send_command(R"({"command":"undo"})");
  EXPECT_TRUE(zone_of(fixture).find("refused")->is_null());
}

TEST(ZoneSession, ends_its_edits_with_a_zone_of_the_broker) {
  ServerFixture fixture;
  fixture.send_command(tag_edit);
  EXPECT_EQ(fixture.snapshot().find("zoneEdits")->flag("unsaved"), true);
  receive_zone(fixture, moved_oval("yard", "0.1"));
  const JsonValue edits = *fixture.snapshot().find("zoneEdits");
  EXPECT_EQ(edits.number("undo"), 0.0);
  EXPECT_EQ(edits.number("redo"), 0.0);
  EXPECT_EQ(edits.flag("unsaved"), false);
  EXPECT_EQ(zone_of(fixture).find("switched")->text("from"), "oval");
  EXPECT_EQ(zone_of(fixture).find("switched")->number("at"), to_milliseconds_scaled(fixture.now));
}

TEST(ZoneSession, applies_edited_priorities_to_present_and_to_later_vehicles_and_is_the_same_zone) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  fixture.run_for(1s);
  fixture.send_command(R"({"command":"edit","edit":{"priorities":{"CoSiVA/AIV1":5,"CoSiVA/AIV2":7}}})");
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").number("priority"), 5.0);
  EXPECT_TRUE(zone_of(fixture).find("switched")->is_null()) << "its geometry is the same";
  fixture.add("AIV2", {2, 0.5});
  fixture.run_for(100ms);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV2").number("priority"), 7.0);
}

TEST(ZoneSession, lists_closed_sections_and_they_persist_at_once) {
  ServerFixture fixture;
  const auto closed = [&] {
    std::vector<std::string> names;
    const JsonValue zone = zone_of(fixture);
    for (const JsonValue& name : *zone.find("closed")->array()) names.push_back(*name.text());
    return names;
  };
  EXPECT_THAT(closed(), IsEmpty());
  fixture.send_command(R"({"command":"close","section":"east"})");
  EXPECT_THAT(closed(), ElementsAre("east"));
  EXPECT_THAT(written_state(fixture), HasSubstr(R"("traffic":{"zone":"oval","closed":["east"],"missions":[]})"));
  fixture.send_command(R"({"command":"open","section":"east"})");
  EXPECT_THAT(closed(), IsEmpty());
  EXPECT_THAT(written_state(fixture), testing::Not(HasSubstr("traffic")));
}

TEST(ZoneSession, shows_that_there_is_no_zone_yet) {
  const JsonValue zone = *JsonValue::parse(ServerCore{ServerOptions{}}.snapshot_json())->find("zone");
  EXPECT_TRUE(zone.find("name")->is_null());
  EXPECT_EQ(zone.number("revision"), 0.0);
  EXPECT_THAT(*zone.find("closed")->array(), IsEmpty());
  EXPECT_TRUE(zone.find("refused")->is_null());
  EXPECT_TRUE(zone.find("switched")->is_null());
}

TEST(Switch, shows_vehicles_as_stopped_until_they_report) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  FixtureVehicle& lost = fixture.add("AIV2", {2, 0.5});
  fixture.run_for(2s);
  lost.position_known = false;
  lost.state_due = true;
  fixture.run_for(200ms);
  ASSERT_GT(*fixture.aiv("CoSiVA/AIV1").number("speed"), 0.0);
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").number("speed"), 0.0);
  EXPECT_TRUE(fixture.aiv("CoSiVA/AIV2").find("section")->is_null());
}

TEST(Switch, persists_at_once_until_the_broker_brings_another_zone) {
  ServerFixture fixture;
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  const JsonValue state = *JsonValue::parse(written_state(fixture));
  EXPECT_EQ(state.find("given")->text("text"), oval().text);
  EXPECT_EQ(state.find("zone")->find("base")->text("text"), moved_oval("yard", "0.1").text);
  EXPECT_EQ(state.find("zone")->find("made")->text("text"), moved_oval("yard", "0.1").text);
  receive_zone(fixture, moved_oval("third", "0.2"));
  const JsonValue after = *JsonValue::parse(written_state(fixture));
  EXPECT_EQ(after.find("given"), nullptr);
  EXPECT_EQ(after.find("zone"), nullptr);
}

TEST(Switch, without_an_edit_is_restored_without_an_edit) {
  ServerFixture fixture;
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  fixture.restart_server(true);
  EXPECT_EQ(zone_of(fixture).text("name"), "yard");
  EXPECT_TRUE(zone_of(fixture).find("switched")->is_null()) << "no vehicle was there";
  EXPECT_EQ(fixture.snapshot().find("zoneEdits")->number("undo"), 0.0);
  EXPECT_EQ(fixture.snapshot().find("zoneEdits")->flag("unsaved"), false);
  fixture.send_command(tag_edit);
  const JsonValue state = *JsonValue::parse(written_state(fixture));
  ASSERT_NE(state.find("given"), nullptr) << "for the next restart";
  EXPECT_EQ(state.find("given")->text("text"), oval().text);
}

TEST(Switch, is_not_restored_where_the_options_give_a_third_zone) {
  ServerFixture fixture;
  fixture.send_command(switch_to(moved_oval("yard", "0.1")));
  ServerFixture other{moved_oval("third", "0.3")};
  written_state(other) = written_state(fixture);
  other.restart_server(true);
  EXPECT_EQ(zone_of(other).text("name"), "third");
  EXPECT_TRUE(other.logged("the zone is not the one that the persisted edits were made on; they are skipped"));
}

TEST(ZoneSession, publishes_restored_edits_when_it_receives_their_original) {
  ServerFixture fixture;
  fixture.send_command(tag_edit);
  const std::string edited = fixture.server->zone_configuration()->text;
  for (const bool original : {true, false}) {
    ServerCore server{ServerOptions{}};
    wire::Effects effects;
    server.handle({fixture.now, wire::InputKind::restore, "", written_state(fixture)}, effects);
    server.handle({fixture.now, wire::InputKind::link, "", "up"}, effects);
    effects.clear();
    server.handle({fixture.now, wire::InputKind::message, "cosiva/v1/zone/toml", original ? oval().text : edited, true},
                  effects);
    const auto published = std::ranges::count_if(effects, [&](const wire::Effect& effect) {
      const auto* message = std::get_if<wire::Publish>(&effect);
      return message != nullptr && message->payload == edited && message->retained;
    });
    EXPECT_EQ(published, original ? 1 : 0);
    EXPECT_EQ(server.zone_configuration()->text, edited);
  }
}

}  // namespace
}  // namespace cosiva::virtual_side
