// Virtual objects: requested, rejected, displayed, and driving among other vehicles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::AnyOf;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

std::string person(const std::string& rest) {
  return R"({"command":"add","virtualObject":{"kind":"person",)" + rest + "}}";
}
std::string virtual_aiv(const std::string& rest) {
  return R"({"command":"add","virtualObject":{"kind":"aiv")" + rest + "}}";
}

std::vector<std::string> ids(const JsonValue& list) {
  std::vector<std::string> found;
  for (const JsonValue& one : *list.array()) found.push_back(*one.text("id"));
  return found;
}
JsonValue virtual_object(const ServerFixture& fixture, const std::string& id) {
  const JsonValue all = fixture.snapshot();
  for (const JsonValue& one : *all.find("virtualObjects")->array())
    if (one.text("id") == id) return one;
  return {};
}
std::vector<std::string> virtual_objects(const ServerFixture& fixture) {
  return ids(*fixture.snapshot().find("virtualObjects"));
}
std::vector<std::string> aivs(const ServerFixture& fixture) { return ids(*fixture.snapshot().find("aivs")); }

TEST(VirtualObjects, stay_at_their_position_with_names_of_their_kind) {
  ServerFixture fixture;
  EXPECT_EQ(fixture.server->next_virtual_object_id("person"), "P1");
  fixture.send_command(person(R"("x":0.5,"y":0.1)"));
  fixture.send_command(
      R"({"command":"add","virtualObject":{"kind":"obstacle","id":"box","x":1.5,"y":0.2,"radius":0.3}})");
  EXPECT_THAT(virtual_objects(fixture), ElementsAre("P1", "box"));
  EXPECT_EQ(fixture.server->next_virtual_object_id("person"), "P2");
  EXPECT_EQ(fixture.server->next_virtual_object_id("obstacle"), "O1");
  EXPECT_EQ(fixture.server->next_virtual_object_id("aiv"), "V1");
  const JsonValue p = virtual_object(fixture, "P1");
  EXPECT_EQ(*p.number("x"), 0.5);
  EXPECT_EQ(*p.number("radius"), 0.06) << "half of the zone's vehicle width";
  EXPECT_EQ(*p.number("handle"), 32768.0);
  EXPECT_EQ(p.find("path"), nullptr);
  EXPECT_EQ(*virtual_object(fixture, "box").number("radius"), 0.3);
  EXPECT_EQ(virtual_object(fixture, "box").text("kind"), "obstacle");
}

TEST(VirtualObjects, walk_their_path_are_moved_and_removed) {
  ServerFixture fixture;
  fixture.send_command(person(R"("path":[[0,0.1],[1,0.1]],"speed":0.5,"repeat":"back and forth")"));
  fixture.run_for(3s);
  EXPECT_NEAR(*virtual_object(fixture, "P1").number("x"), 0.5, 1e-9);
  EXPECT_EQ(virtual_object(fixture, "P1").text("repeat"), "back and forth");
  EXPECT_THAT(*virtual_object(fixture, "P1").find("path")->array(), SizeIs(2));
  fixture.send_command(R"({"command":"move","virtualObject":{"id":"P1","x":1.5,"y":0.1}})");
  EXPECT_EQ(*virtual_object(fixture, "P1").number("x"), 1.5);
  EXPECT_EQ(*virtual_object(fixture, "P1").number("speed"), 0.0);
  fixture.send_command(R"({"command":"move","virtualObject":{"id":"P1","path":[[1.5,0.1],[0,0.1]]}})");
  fixture.run_for(1s);
  EXPECT_LT(*virtual_object(fixture, "P1").number("x"), 1.5) << "at the zone's slow speed, since the command gave none";
  fixture.send_command(R"({"command":"remove","id":"P1"})");
  EXPECT_THAT(virtual_objects(fixture), IsEmpty());
}

TEST(VirtualObjects, that_are_invalid_are_rejected_with_a_message_and_change_nothing) {
  ServerFixture fixture;
  fixture.send_command(person(R"("id":"P1","x":0.5,"y":0.1)"));
  const std::vector<std::pair<std::string, std::string>> wrong{
      {person(R"("x":50,"y":0)"), "outside the zone"},
      {person(R"("path":[[0,0],[0,99]])"), "path[1]"},
      {person(R"("path":[])"), "1 to 64 points"},
      {person(R"("path":[[0]])"), "[x,y]"},
      {person(R"("path":[[0,0],[1,0]],"x":1,"y":1)"), "not both"},
      {person(R"("x":"0","y":0)"), "two numbers"},
      {person(R"("x":0)"), "give a position"},
      {person(R"("x":0,"y":0,"radius":0.01)"), "0.02 m to 1.00 m"},
      {person(R"("x":0,"y":0,"radius":1.5)"), "0.02 m to 1.00 m"},
      {person(R"("path":[[0,0],[1,0]],"speed":3.5)"), "3.00 m/s"},
      {person(R"("path":[[0,0],[1,0]],"speed":-1)"), "0.00 m"},
      {person(R"("path":[[0,0],[1,0]],"repeat":"twice")"), "back and forth"},
      {person(R"("id":"P1","x":0,"y":0)"), "is in use"},
      {person(R"("id":"S1","x":0,"y":0)"), "choose another id"},
      {person(R"("id":"a b","x":0,"y":0)"), "not a valid id"},
      {person(R"("id":7,"x":0,"y":0)"), "not a valid id"},
      {R"({"command":"add","virtualObject":{"kind":"obstacle","path":[[0,0],[1,0]]}})", "does not move"},
      {R"({"command":"add","virtualObject":{"kind":"dragon","x":0,"y":0}})", "no kind 'dragon'"},
      {R"({"command":"add"})", "state what"},
      {R"({"command":"move","virtualObject":{"id":"P9","x":0,"y":0}})", "there are P1"},
      {R"({"command":"move","virtualObject":{"x":0,"y":0}})", "give the id"},
      {R"({"command":"move","virtualObject":{"id":"P1"}})", "give a position"},
      {R"({"command":"remove","id":"P9"})", "there are P1"},
      {R"({"command":"remove"})", "give the id"}};
  for (const auto& [json, phrase] : wrong) {
    EXPECT_THAT(fixture.refusal(json), HasSubstr(phrase)) << json;
    fixture.logs.clear();
    fixture.send_command(json);
    EXPECT_TRUE(fixture.logged("refused")) << json;
  }
  EXPECT_THAT(virtual_objects(fixture), ElementsAre("P1"));
  EXPECT_EQ(*fixture.bijection().find("commands")->number("issued"), 0.0) << "these are not commands to vehicles";
}

TEST(VirtualObjects, need_a_zone) {
  ServerCore server{ServerOptions{}};
  const auto checked = server.check_command(DecodedCommand{person(R"("x":0,"y":0)")});
  ASSERT_FALSE(checked.has_value());
  EXPECT_THAT(checked.error().message, HasSubstr("no zone yet"));
}

TEST(VirtualObjects, are_limited_to_64_and_can_be_removed_together) {
  ServerFixture fixture;
  for (int i = 0; i < 64; ++i) fixture.send_command(person(R"("x":0.5,"y":0.1)"));
  EXPECT_THAT(fixture.refusal(person(R"("x":0.5,"y":0.1)")), HasSubstr("remove one"));
  EXPECT_THAT(fixture.refusal(virtual_aiv("")), HasSubstr("remove one"));
  fixture.send_command(R"({"command":"remove","id":"*"})");
  EXPECT_THAT(virtual_objects(fixture), IsEmpty());
}

TEST(VirtualAivs, circulate_like_other_vehicles_and_are_counted_separately) {
  ServerFixture fixture;
  FixtureVehicle& real = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(1s);
  fixture.send_command(virtual_aiv(R"(,"section":"north","s":1.0)"));
  fixture.run_for(4s);
  const JsonValue first = fixture.aiv("CoSiVA.virtual/V1");
  EXPECT_EQ(first.flag("augmented"), true);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").flag("augmented"), false);
  EXPECT_EQ(first.text("connection"), "ONLINE");
  EXPECT_FALSE(first.text("orderId")->empty());
  fixture.run_for(6s);
  const JsonValue then = fixture.aiv("CoSiVA.virtual/V1");
  EXPECT_NE(*then.number("x"), *first.number("x"));
  EXPECT_GT(*then.number("speed"), 0.1);
  EXPECT_GT(real.driven_m, 2.0);
  const JsonValue metrics = fixture.bijection();
  EXPECT_EQ(*metrics.number("physical"), 1.0);
  EXPECT_EQ(*metrics.number("virtual"), 1.0);
  EXPECT_EQ(*metrics.number("matched"), 1.0);
  EXPECT_EQ(*metrics.number("augmented"), 1.0);
  EXPECT_EQ(*metrics.find("events")->find("by_kind")->number("arrival"), 1.0);
  EXPECT_FALSE(fixture.published_on("uagv/v2/CoSiVA.virtual/V1/order").empty()) << "every fleet tool receives it";
}

TEST(VirtualAivs, obey_commands_which_the_bijection_does_not_count) {
  ServerFixture fixture;
  fixture.send_command(virtual_aiv(R"(,"section":"south","s":1.0)"));
  fixture.run_for(4s);
  fixture.command("stop", "CoSiVA.virtual/V1", "c1");
  fixture.run_for(2s);
  EXPECT_EQ(fixture.command_entry("c1").text("state"), "materialised");
  EXPECT_EQ(fixture.aiv("CoSiVA.virtual/V1").text("status"), "stopped");
  EXPECT_EQ(*fixture.bijection().find("commands")->number("issued"), 0.0);
}

TEST(VirtualAivs, that_are_removed_leave_the_table_and_the_path_and_may_be_added_again) {
  ServerFixture fixture;
  FixtureVehicle& real = fixture.add("AIV1", {0, 0.2});
  fixture.run_for(1s);
  fixture.command("stop", "CoSiVA/AIV1");
  fixture.run_for(1s);
  fixture.send_command(virtual_aiv(R"(,"section":"east","s":0.4)"));
  fixture.run_for(200ms);
  fixture.command("stop", "CoSiVA.virtual/V1");
  fixture.run_for(1s);
  fixture.command("restart", "CoSiVA/AIV1");
  fixture.run_for(10s);
  EXPECT_LT(real.pose().x_m, 2.2) << "it stays behind";
  EXPECT_FALSE(real.paused) << "its base ends before the virtual one";
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("waitsFor"), "CoSiVA.virtual/V1");
  fixture.command("restart", "CoSiVA.virtual/V1");
  fixture.run_for(600ms);
  fixture.command("stop", "CoSiVA.virtual/V1", "c9");
  ASSERT_EQ(fixture.command_entry("c9").text("state"), "accepted") << "the vehicle is still coasting";
  fixture.send_command(R"({"command":"remove","id":"V1"})");
  EXPECT_THAT(aivs(fixture), ElementsAre("CoSiVA/AIV1"));
  EXPECT_EQ(fixture.command_entry("c9").text("state"), "failed");
  const auto goodbyes = fixture.published_on("uagv/v2/CoSiVA.virtual/V1/connection");
  EXPECT_THAT(goodbyes.back().payload, HasSubstr("OFFLINE"));
  EXPECT_TRUE(goodbyes.back().retained);
  const double before_m = real.driven_m;
  fixture.run_for(3s);
  EXPECT_GT(real.driven_m, before_m + 0.5);
  EXPECT_THAT(fixture.refusal(R"({"command":"stop","vehicle":"CoSiVA.virtual/V1"})"), HasSubstr("no vehicle"));
  fixture.send_command(virtual_aiv(R"(,"id":"V1","section":"north","s":0.5)"));
  fixture.run_for(500ms);
  EXPECT_THAT(aivs(fixture), ElementsAre("CoSiVA/AIV1", "CoSiVA.virtual/V1"));
  EXPECT_EQ(fixture.aiv("CoSiVA.virtual/V1").text("section"), "north");
}

TEST(VirtualAivs, start_where_most_room_is_if_no_position_is_given) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 1.0}).blocked = true;  // on the centre of the south side
  fixture.run_for(1s);
  fixture.send_command(virtual_aiv(""));
  fixture.run_for(200ms);
  // In a straight line the ends of the oval are 1.62 m away, the other side 1.0 m.
  EXPECT_THAT(*fixture.aiv("CoSiVA.virtual/V1").text("section"), AnyOf("east", "west"));
}

TEST(VirtualAivs, are_rejected_where_no_vehicle_may_be) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 1.0}).blocked = true;
  fixture.run_for(1s);
  EXPECT_THAT(fixture.refusal(virtual_aiv(R"(,"x":1.0,"y":0.45)")), HasSubstr("from the circuit"));
  EXPECT_THAT(fixture.refusal(virtual_aiv(R"(,"x":1.2,"y":0.0)")), HasSubstr("CoSiVA/AIV1 is only 0.20 m"));
  EXPECT_THAT(fixture.refusal(virtual_aiv(R"(,"x":1.0)")), HasSubstr("two numbers"));
  EXPECT_THAT(fixture.refusal(virtual_aiv(R"(,"section":"attic")")), HasSubstr("it has south, east, north, west"));
  EXPECT_THAT(fixture.refusal(virtual_aiv(R"(,"section":"south","s":2.5)")), HasSubstr("2.00 m"));
  EXPECT_EQ(fixture.refusal(virtual_aiv(R"(,"x":1.5,"y":0.2)")), "");
  fixture.send_command(virtual_aiv(R"(,"x":1.5,"y":0.2)"));
  EXPECT_THAT(fixture.refusal(virtual_aiv(R"(,"id":"V1")")), HasSubstr("is in use"));
  EXPECT_THAT(fixture.refusal(virtual_aiv(R"(,"x":1.6,"y":0.0)")), HasSubstr("CoSiVA.virtual/V1"));
  EXPECT_THAT(fixture.refusal(R"({"command":"move","virtualObject":{"id":"V1","x":1,"y":0}})"),
              HasSubstr("cannot be moved"));
  ServerFixture clover{zone_file("lacet4.toml")};
  const zone::Crossing& crossing = clover.zone->crossings.front();
  EXPECT_THAT(clover.refusal(virtual_aiv(",\"x\":" + std::to_string(crossing.centre.x_m) +
                                         ",\"y\":" + std::to_string(crossing.centre.y_m))),
              AnyOf(HasSubstr("in crossing"), HasSubstr("between crossings")));
}

TEST(VirtualAivs, continue_from_their_position_when_the_circuit_changes) {
  ServerFixture fixture;
  fixture.send_command(virtual_aiv(R"(,"section":"west","s":1.0)"));
  fixture.send_command(virtual_aiv(R"(,"section":"south","s":1.0)"));
  fixture.run_for(3s);
  std::string shorter = oval().text;
  for (int i = 0; i < 2; ++i) shorter.replace(shorter.find("length_m = 2.0"), 14, "length_m = 1.0");
  fixture.feed(wire::InputKind::message, "cosiva/v1/zone/toml", shorter);
  ASSERT_EQ(fixture.server->zone_revision(), 2U);
  fixture.run_for(10s);
  EXPECT_THAT(aivs(fixture), ElementsAre("CoSiVA.virtual/V1", "CoSiVA.virtual/V2"));
  EXPECT_GT(*fixture.aiv("CoSiVA.virtual/V1").number("speed"), 0.05);
  const JsonValue off_route = fixture.aiv("CoSiVA.virtual/V2");
  EXPECT_THAT(off_route.text("offRoute").value_or(""), HasSubstr("from the nearest section"))
      << "its section ended there";
  EXPECT_EQ(*off_route.number("speed"), 0.0);
  EXPECT_EQ(*off_route.number("y"), 0.0);
}

TEST(VirtualAivs, make_the_same_run_from_the_same_inputs) {
  const auto run = [] {
    ServerFixture fixture{zone_file("lacet4.toml")};
    fixture.add("AIV1", {0, 0.1});
    fixture.run_for(1s);
    fixture.send_command(virtual_aiv(""));
    fixture.send_command(person(R"("path":[[0,0],[0.5,0.5],[-0.5,0.2]],"speed":0.3,"repeat":"loop")"));
    fixture.run_for(10s);
    fixture.send_command(R"({"command":"edit","edit":{"addTags":[{"number":77,"x":0,"y":0.1}]}})");
    fixture.run_for(5s);
    Digest digest;
    fixture.server->fold(digest);
    for (const wire::Publish& message : fixture.published) digest.add(std::string_view{message.payload});
    digest.add(std::string_view{fixture.memory});
    return digest.hex();
  };
  EXPECT_EQ(run(), run());
}

TEST(VirtualAivs, communicate_over_the_server_s_own_interface) {
  ServerOptions options;
  options.interface_name = "plant7";
  ServerFixture fixture{oval(), options};
  fixture.send_command(virtual_aiv(R"(,"section":"south","s":1.0)"));
  fixture.run_for(3s);
  EXPECT_FALSE(fixture.published_on("plant7/v2/CoSiVA.virtual/V1/state").empty());
  EXPECT_GT(*fixture.aiv("CoSiVA.virtual/V1").number("speed"), 0.0);
}

TEST(VirtualAivs, disconnect_with_the_server) {
  ServerFixture fixture;
  fixture.send_command(virtual_aiv(R"(,"section":"south","s":1.0)"));
  wire::Effects effects;
  fixture.server->farewell(fixture.now, effects);
  std::vector<std::string> topics;
  for (const wire::Effect& effect : effects)
    if (const auto* message = std::get_if<wire::Publish>(&effect)) topics.push_back(message->topic);
  EXPECT_THAT(topics, ElementsAre("uagv/v2/CoSiVA.virtual/V1/connection", wire::server_connection_topic));
}

TEST(VirtualAivs, of_an_earlier_server_run_are_not_shown_and_are_reported_offline) {
  ServerFixture fixture;
  wire::Connection ghost{{3, fixture.now, "2.1.0", "CoSiVA.virtual", "V7"}, wire::ConnectionState::online};
  fixture.feed(wire::InputKind::message, "uagv/v2/CoSiVA.virtual/V7/connection", vda::encode(ghost), true);
  fixture.run_for(3s);
  EXPECT_THAT(aivs(fixture), IsEmpty());
  const auto publications = fixture.published_on("uagv/v2/CoSiVA.virtual/V7/connection");
  ASSERT_THAT(publications, SizeIs(1));
  EXPECT_THAT(publications[0].payload, HasSubstr("OFFLINE"));
  EXPECT_TRUE(publications[0].retained);
}

TEST(VirtualAivs, added_between_a_vehicle_and_its_crossing_drive_on_before_it) {
  ServerFixture fixture{zone_file("lacet4.toml")};
  FixtureVehicle& real = fixture.add("AIV1", {7, 1.5});
  // Until the base of the real vehicle leads through the crossings of the next straight.
  for (int i = 0; i < 2000 && real.book->distance_to_base_end_m() < 1.0; ++i) fixture.run_for(20ms);
  real.blocked = true;  // the real vehicle perceives the virtual one before it
  fixture.run_for(100ms);
  const zone::TrackPosition ahead = fixture.zone->circuit.advance(real.track_position(), 0.45);
  fixture.send_command(virtual_aiv(",\"section\":\"" + fixture.zone->circuit.part(ahead.section).name +
                                   "\",\"s\":" + std::to_string(ahead.s_m)));
  if (!fixture.logged("command refused")) {
    fixture.run_for(8s);
    EXPECT_GT(
        distance(Pose2{*fixture.aiv("CoSiVA.virtual/V1").number("x"), *fixture.aiv("CoSiVA.virtual/V1").number("y"), 0},
                 real.pose()),
        0.8);
  }
}

TEST(Commands, to_several_vehicles_have_an_entry_each) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  fixture.add("AIV2", {2, 0.5});
  fixture.add("AIV3", {2, 1.5});
  fixture.run_for(2s);
  fixture.send_command(R"({"command":"stop","id":"c1","vehicles":["CoSiVA/AIV1","CoSiVA/AIV3","CoSiVA/AIV1"]})");
  fixture.run_for(1s);
  EXPECT_EQ(fixture.command_entry("c1.AIV1").text("state"), "materialised");
  EXPECT_EQ(fixture.command_entry("c1.AIV3").text("state"), "materialised");
  EXPECT_TRUE(fixture.command_entry("c1.AIV2").is_null());
  EXPECT_EQ(*fixture.bijection().find("commands")->number("issued"), 2.0);
  EXPECT_THAT(fixture.refusal(R"({"command":"stop","vehicles":["CoSiVA/AIV1","CoSiVA/AIV9"]})"),
              HasSubstr("'CoSiVA/AIV9'"));
  EXPECT_THAT(fixture.refusal(R"({"command":"stop","vehicles":[]})"), HasSubstr("at least one"));
  EXPECT_THAT(fixture.refusal(R"({"command":"stop","vehicles":[7]})"), HasSubstr("no vehicle ''"));
}

TEST(WorldCommands, are_forwarded_to_the_emulated_plant_that_supports_them) {
  ServerFixture fixture;
  fixture.add("AIV1", {0, 0.5});
  fixture.send_command(R"({"command":"plant","plant":{"addObstacle":{"id":"box1","x":0.5,"y":0.2}}})");
  fixture.send_command(R"({"command":"plant","plant":{"removeObstacle":"box1"}})");
  const auto plant = fixture.published_on(wire::plant_command_topic);
  ASSERT_THAT(plant, SizeIs(2));
  EXPECT_EQ(plant[0].payload, R"({"addObstacle":{"id":"box1","x":0.5,"y":0.2,"radius":0.06}})");
  EXPECT_EQ(plant[1].payload, R"({"removeObstacle":"box1"})");
  fixture.send_command(R"({"command":"radio","vehicle":"CoSiVA/AIV1","loss":0.3})");
  const auto radio = fixture.published_on(wire::plant_radio_topic);
  ASSERT_THAT(radio, SizeIs(1));
  EXPECT_EQ(wire::radio_from_json(radio[0].payload)->loss, 0.3);
}

TEST(WorldCommands, that_are_invalid_are_rejected) {
  ServerFixture fixture;
  EXPECT_THAT(fixture.refusal(R"({"command":"plant"})"), HasSubstr("state what"));
  EXPECT_THAT(fixture.refusal(R"({"command":"plant","plant":{}})"), HasSubstr("state what"));
  EXPECT_THAT(fixture.refusal(R"({"command":"plant","plant":{"addObstacle":{"x":0,"y":0}}})"), HasSubstr("name"));
  EXPECT_THAT(fixture.refusal(R"({"command":"plant","plant":{"addObstacle":{"id":"a","x":90,"y":0}}})"),
              HasSubstr("outside the zone"));
  EXPECT_THAT(fixture.refusal(R"({"command":"plant","plant":{"addObstacle":{"id":"a","x":0,"y":0,"radius":9}}})"),
              HasSubstr("0.02 m to 1 m"));
  EXPECT_THAT(fixture.refusal(R"({"command":"plant","plant":{"removeObstacle":7}})"), HasSubstr("name"));
  EXPECT_THAT(fixture.refusal(R"({"command":"radio","vehicle":"CoSiVA/AIV9","loss":0.3})"), HasSubstr("no vehicle"));
  EXPECT_THAT(fixture.refusal(R"({"command":"radio","vehicle":"*","loss":3})"), HasSubstr("from 0 to 1"));
  EXPECT_THAT(fixture.refusal(R"({"command":"radio","vehicle":"*"})"), HasSubstr("from 0 to 1"));
}

}  // namespace
}  // namespace cosiva::virtual_side
