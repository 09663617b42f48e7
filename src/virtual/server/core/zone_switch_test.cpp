// Switching from one zone to another while vehicles drive.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <memory>

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

}  // namespace
}  // namespace cosiva::virtual_side
