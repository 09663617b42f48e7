// Virtual objects: requested, rejected, displayed, and driving among other vehicles.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/virtual/server/augmented/virtual_object_commands.h"
#include "cosiva/virtual/server/testing/orders_fixture.h"
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
    digest.add(std::string_view{fixture.persisted});
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

/// The reader of the commands around objects and vehicles that the test adds.
struct ObjectWorld {
  explicit ObjectWorld(const zone::ZoneConfiguration& configuration = oval()) : orders{configuration} {}

  [[nodiscard]] Simulator& simulator() { return orders.server.simulator; }
  void add_object(const std::string& id, Point2 at, double radius_m = 0.06, double speed_mps = 0.0,
                  Repeat repeat = Repeat::once, VirtualObjectKind kind = VirtualObjectKind::person) {
    VirtualObject added;
    added.id = id;
    added.kind = kind;
    added.radius_m = radius_m;
    added.walk = Walk({at}, speed_mps, repeat);
    simulator().augmented().add(std::move(added));
  }
  void host(const std::string& serial, zone::TrackPosition position) {
    const VehicleIndex vehicle = orders.add(serial, "CoSiVA.virtual");
    fleet.add(vehicle, orders.now, false, simulator().rtm(), position);
  }

  OrdersFixture orders;
  VirtualFleet fleet{orders.server.registry, orders.server.publisher, orders.server.options.virtual_rules, false};
  RestoredAivs restored;
  VirtualObjectCommands commands{orders.server.registry, orders.server.simulator, fleet, restored,
                                 orders.server.publisher};
};

class ObjectCommands : public testing::Test {
 protected:
  [[nodiscard]] static VirtualObjectFields fields_of(const std::string& kind) {
    VirtualObjectFields fields;
    fields.kind = kind;
    return fields;
  }
  [[nodiscard]] static VirtualObjectFields at_point(const std::string& kind, double x_m, double y_m) {
    VirtualObjectFields fields = fields_of(kind);
    fields.x_m = x_m;
    fields.y_m = y_m;
    return fields;
  }
  [[nodiscard]] static VirtualObjectFields on_section(const std::string& kind, const std::string& section) {
    VirtualObjectFields fields = fields_of(kind);
    fields.section = section;
    return fields;
  }
  [[nodiscard]] static VirtualObjectFields on_path(std::size_t points) {
    VirtualObjectFields fields = fields_of("person");
    fields.path.emplace(points, Point2{0.5, 0.25});
    return fields;
  }
  [[nodiscard]] Result<VirtualObjectCommand> add(const VirtualObjectFields& fields) const {
    return world.commands.read(AddCommand{fields});
  }
  /// The error of a command that has to be refused.
  [[nodiscard]] static Error error_of(const Result<VirtualObjectCommand>& read) {
    return read ? Error{"accepted", "", ""} : read.error();
  }
  [[nodiscard]] Error refusal(const VirtualObjectFields& fields) const { return error_of(add(fields)); }

  ObjectWorld world;
};

TEST_F(ObjectCommands, accept_points_up_to_half_a_metre_outside_the_drawing) {
  const zone::Bounds on = world.simulator().drawing().bounds;
  const auto accepts = [&](double x_m, double y_m) { return world.commands.read_point(x_m, y_m, "x, y").has_value(); };
  EXPECT_TRUE(accepts(on.low.x_m - 0.5, on.low.y_m - 0.5));
  EXPECT_TRUE(accepts(on.high.x_m + 0.5, on.high.y_m + 0.5));
  EXPECT_FALSE(accepts(on.low.x_m - 0.501, 0.5));
  EXPECT_FALSE(accepts(on.high.x_m + 0.501, 0.5));
  EXPECT_FALSE(accepts(0.5, on.low.y_m - 0.501));
  EXPECT_FALSE(accepts(0.5, on.high.y_m + 0.501));
  const Error error = world.commands.read_point(50.0, -1.25, "path[3]").error();
  EXPECT_EQ(error.code, "virtual_object.position");
  EXPECT_EQ(error.location, "path[3]");
  EXPECT_THAT(error.message, HasSubstr("(50.00 m, -1.25 m) is outside the zone, which reaches from ("));
}

TEST_F(ObjectCommands, refuse_a_point_with_a_coordinate_that_is_missing_or_no_number) {
  constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
  const std::vector<std::pair<OptionalNumber, OptionalNumber>> wrong{
      {std::nullopt, 0.5}, {0.5, std::nullopt}, {no_number, 0.5}, {0.5, no_number}};
  for (const auto& [x_m, y_m] : wrong) {
    EXPECT_EQ(world.commands.read_point(x_m, y_m, "x, y").error(),
              (Error{"virtual_object.position", "give a position as two numbers, in metres on the map", "x, y"}));
  }
}

TEST_F(ObjectCommands, read_a_person_who_stays_at_a_point) {
  const auto read = add(at_point("person", 0.5, 0.25));
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->act, VirtualObjectCommand::Act::add);
  EXPECT_EQ(read->id, "P1");
  EXPECT_FALSE(read->is_aiv);
  EXPECT_EQ(read->kind, VirtualObjectKind::person);
  EXPECT_EQ(read->radius_m, 0.06);
  ASSERT_THAT(read->walk.path(), SizeIs(1));
  EXPECT_EQ(read->walk.path()[0].x_m, 0.5);
  EXPECT_EQ(read->walk.path()[0].y_m, 0.25);
  EXPECT_EQ(read->walk.speed_mps(), 0.0);
  EXPECT_EQ(add(at_point("obstacle", 0.5, 0.25))->kind, VirtualObjectKind::obstacle);
}

TEST_F(ObjectCommands, accept_radii_from_two_centimetres_to_a_metre) {
  VirtualObjectFields fields = at_point("obstacle", 0.5, 0.25);
  for (const double radius_m : {0.02, 1.0}) {
    fields.radius_m = radius_m;
    EXPECT_EQ(add(fields)->radius_m, radius_m);
  }
  for (const double radius_m : {0.0199, 1.0001, std::numeric_limits<double>::quiet_NaN()}) {
    fields.radius_m = radius_m;
    EXPECT_EQ(refusal(fields), (Error{"virtual_object.number", "give a number from 0.02 m to 1.00 m", "radius"}));
  }
}

TEST_F(ObjectCommands, take_half_of_a_vehicle_s_width_as_the_radius_within_the_limits) {
  const auto radius_for = [](const std::string& width) {
    zone::ZoneConfiguration configuration = oval();
    configuration.text.replace(configuration.text.find("width_m = 0.12"), 14, "width_m = " + width);
    const ObjectWorld other{configuration};
    return other.commands.read(AddCommand{at_point("person", 0.5, 0.25)})->radius_m;
  };
  EXPECT_EQ(radius_for("0.16"), 0.08);
  EXPECT_EQ(radius_for("0.03"), 0.02);
}

TEST_F(ObjectCommands, read_a_path_with_the_slow_speed_and_no_repetition_unless_stated) {
  VirtualObjectFields fields = on_path(2);
  auto read = add(fields);
  ASSERT_TRUE(read.has_value());
  EXPECT_THAT(read->walk.path(), SizeIs(2));
  EXPECT_EQ(read->walk.speed_mps(), world.simulator().zone()->profiles.slow.speed_mps);
  EXPECT_EQ(read->walk.repeat(), Repeat::once);
  fields.repeat = "loop";
  for (const double speed_mps : {0.0, 3.0}) {
    fields.speed_mps = speed_mps;
    read = add(fields);
    ASSERT_TRUE(read.has_value());
    EXPECT_EQ(read->walk.speed_mps(), speed_mps);
    EXPECT_EQ(read->walk.repeat(), Repeat::loop);
  }
  for (const double speed_mps : {-0.001, 3.001}) {
    fields.speed_mps = speed_mps;
    EXPECT_EQ(refusal(fields), (Error{"virtual_object.number", "give a number from 0.00 m to 3.00 m/s", "speed"}));
  }
  fields.speed_mps = 1.0;
  fields.repeat = "twice";
  EXPECT_EQ(refusal(fields), (Error{"virtual_object.repeat", "use once, back and forth, or loop", "repeat"}));
}

TEST_F(ObjectCommands, accept_paths_of_one_to_64_points) {
  EXPECT_TRUE(add(on_path(1)).has_value());
  EXPECT_TRUE(add(on_path(64)).has_value());
  for (const std::size_t points : {std::size_t{0}, std::size_t{65}}) {
    EXPECT_EQ(refusal(on_path(points)),
              (Error{"virtual_object.path", "give a path as 1 to 64 points, [[x,y],[x,y],…]", "path"}));
  }
  VirtualObjectFields fields = on_path(3);
  (*fields.path)[1] = std::nullopt;
  EXPECT_EQ(refusal(fields), (Error{"virtual_object.path", "give each point as [x,y]", "path[1]"}));
  (*fields.path)[1] = Point2{0.5, 99.0};
  EXPECT_EQ(refusal(fields).code, "virtual_object.position");
  EXPECT_EQ(refusal(fields).location, "path[1]");
}

TEST_F(ObjectCommands, need_either_a_point_or_a_path) {
  VirtualObjectFields person_at = fields_of("person");
  const Error incomplete{"virtual_object.position", "give a position (x, y) or a path to walk (path)", ""};
  EXPECT_EQ(refusal(person_at), incomplete);
  person_at.x_m = 0.5;
  EXPECT_EQ(refusal(person_at), incomplete);
  EXPECT_EQ(refusal(fields_of("obstacle")), (Error{"virtual_object.position", "give a position (x, y)", ""}));
  const Error both{"virtual_object.position", "give either a position (x, y) or a path, not both", "path"};
  VirtualObjectFields with_x = on_path(2);
  with_x.x_m = 0.5;
  EXPECT_EQ(refusal(with_x), both);
  VirtualObjectFields with_y = on_path(2);
  with_y.y_m = 0.5;
  EXPECT_EQ(refusal(with_y), both);
  VirtualObjectFields obstacle = on_path(2);
  obstacle.kind = "obstacle";
  EXPECT_EQ(refusal(obstacle).code, "virtual_object.path");
}

TEST_F(ObjectCommands, read_positions_on_sections) {
  VirtualObjectFields fields = on_section("obstacle", "east");
  EXPECT_NEAR(add(fields)->walk.path()[0].x_m, 2.0, 1e-9) << "its start";
  fields.s_m = 0.5;
  const Point2 there = position(world.simulator().circuit()->pose_at({1, 0.5}));
  EXPECT_EQ(add(fields)->walk.path()[0].x_m, there.x_m);
  EXPECT_EQ(add(fields)->walk.path()[0].y_m, there.y_m);
  EXPECT_EQ(add(fields)->walk.speed_mps(), 0.0);
  fields = on_section("aiv", "south");
  fields.s_m = 2.0;
  EXPECT_EQ(add(fields)->position, (zone::TrackPosition{0, 2.0}));
  for (const double s_m : {-0.001, 2.001}) {
    fields.s_m = s_m;
    EXPECT_EQ(refusal(fields),
              (Error{"virtual_object.number", "give a number from 0.00 m to 2.00 m along the section", "s"}));
  }
  const Error unknown{"virtual_object.section", "this zone has no such section; it has south, east, north, west",
                      "section"};
  EXPECT_EQ(refusal(on_section("aiv", "attic")), unknown);
  fields = on_section("aiv", "south");
  fields.section_is_text = false;
  EXPECT_EQ(refusal(fields), unknown);
}

TEST_F(ObjectCommands, accept_ids_of_up_to_32_characters_except_those_of_detected_obstacles) {
  world.add_object("box", {0.5, 0.25});
  world.host("V1", {2, 1.0});
  const auto error_for = [&](const std::string& id) {
    VirtualObjectFields fields = at_point("person", 0.5, 0.25);
    fields.id = id;
    return refusal(fields);
  };
  for (const std::string& id : {std::string("S"), std::string("S:"), std::string("SA"), std::string("S1a"),
                                std::string("T1"), std::string(32, 'a')})
    EXPECT_EQ(error_for(id).code, "accepted") << id;
  EXPECT_EQ(error_for("").code, "virtual_object.id");
  EXPECT_EQ(error_for(std::string(33, 'a')).code, "virtual_object.id");
  EXPECT_EQ(error_for(std::string(90, 'a')).message,
            "'" + std::string(80, 'a') + "' is not a valid id; use 1 to 32 of A-Z a-z 0-9 _ . : - or leave it out");
  for (const std::string id : {"S0", "S9", "S10"}) {
    EXPECT_EQ(error_for(id),
              (Error{"virtual_object.id", "S1, S2 … are the ids of obstacles that vehicles detect; choose another id",
                     "id"}));
  }
  for (const std::string id : {"box", "V1"}) EXPECT_EQ(error_for(id).code, "virtual_object.taken");
}

TEST_F(ObjectCommands, choose_the_first_id_that_neither_an_object_nor_a_vehicle_has) {
  world.add_object("P1", {0.5, 0.25});
  world.host("P2", {2, 1.0});
  EXPECT_EQ(world.commands.next_id("person"), "P3");
  EXPECT_EQ(world.commands.next_id("obstacle"), "O1");
  EXPECT_EQ(world.commands.next_id("aiv"), "V1");
}

TEST_F(ObjectCommands, count_persons_and_vehicles_together) {
  for (std::size_t i = 0; i + 2 < Augmented::virtual_objects_max; ++i)
    world.add_object("o" + std::to_string(i), {0.5, 0.25});
  world.host("V1", {2, 1.0});
  EXPECT_TRUE(add(at_point("person", 0.5, 0.25)).has_value()) << "the 64th";
  world.add_object("P1", {0.5, 0.25});
  EXPECT_EQ(refusal(at_point("person", 0.5, 0.25)),
            (Error{"virtual_object.many",
                   "there are 64 virtual objects already; remove one that is no longer needed, then try again", ""}));
}

TEST_F(ObjectCommands, add_only_known_vehicles_where_the_server_knows_as_many_as_it_accepts) {
  Registry& registry = world.orders.server.registry;
  const auto add_vehicle = [&](const std::string& serial) {
    const auto added = registry.add({"ACME", serial}, world.orders.now);
    ASSERT_TRUE(added.has_value());
    registry[*added].twin_link.on_present();
  };
  while (registry.size() + 2 < registry.vehicles_max()) add_vehicle("A" + std::to_string(registry.size()));
  ASSERT_TRUE(registry.add({"CoSiVA.virtual", "V1"}, world.orders.now).has_value());
  VirtualObjectFields fields = on_section("aiv", "south");
  fields.id = "V2";
  EXPECT_TRUE(add(fields).has_value()) << "the 2 000th";
  add_vehicle("last");
  EXPECT_EQ(refusal(fields).code, "virtual_object.many");
  EXPECT_THAT(refusal(fields).message, HasSubstr("knows 2000 vehicles already"));
  fields.id = "V1";
  EXPECT_TRUE(add(fields).has_value()) << "the name was used before";
}

TEST_F(ObjectCommands, accept_vehicles_within_thirty_centimetres_of_a_section) {
  const auto read = add(at_point("aiv", 1.0, -0.299));
  ASSERT_TRUE(read.has_value());
  EXPECT_TRUE(read->is_aiv);
  EXPECT_EQ(read->id, "V1");
  EXPECT_EQ(read->position.section, 0U);
  EXPECT_NEAR(read->position.s_m, 1.0, 1e-9);
  EXPECT_EQ(
      refusal(at_point("aiv", 1.0, -0.35)),
      (Error{"virtual_object.off",
             "(1.00 m, -0.35 m) is 0.35 m from the circuit; a virtual AIV must be added within 0.30 m of a section",
             ""}));
  EXPECT_TRUE(add(at_point("aiv", 1.0, -0.3)).has_value()) << "exactly";
  EXPECT_EQ(refusal(at_point("aiv", 1.0, -0.301)).code, "virtual_object.off");
  VirtualObjectFields only_y = fields_of("aiv");
  only_y.y_m = 0.0;
  EXPECT_EQ(refusal(only_y).location, "x, y");
}

TEST_F(ObjectCommands, keep_vehicles_a_length_and_ten_centimetres_apart) {
  (void)world.orders.add_at("AIV1", {0, 1.0});
  world.host("V1", {2, 1.0});
  EXPECT_FALSE(world.commands.has_room({0, 1.29}));
  EXPECT_TRUE(world.commands.has_room({0, 1.31}));
  EXPECT_FALSE(world.commands.has_room({0, 0.71}));
  EXPECT_TRUE(world.commands.has_room({0, 0.69}));
  EXPECT_EQ(world.commands.check_position({0, 1.29}).error(),
            (Error{"virtual_object.room", "CoSiVA/AIV1 is only 0.29 m away; leave 0.30 m between two vehicles", ""}));
  EXPECT_THAT(world.commands.check_position({2, 1.2}).error().message, HasSubstr("CoSiVA.virtual/V1 is only 0.20 m"));
  EXPECT_TRUE(world.commands.check_position({2, 1.31}).has_value());
}

TEST(ParallelTracks, need_only_the_room_of_the_bodies) {
  ObjectWorld world{fork()};
  // The straight begins at x = 1 m. The bypass runs 0.29 m to the right of the straight; the diagonal of a vehicle is
  // 0.23 m long.
  const auto south_s_m = [](double x_m) { return x_m - 1.0; };
  (void)world.orders.add_at("AIV1", world.orders.at("south", south_s_m(2.2071)));
  EXPECT_TRUE(world.commands.has_room(world.orders.at("bypass3", 0.5)));
  ObjectWorld near_fork{fork()};
  (void)near_fork.orders.add_at("AIV1", near_fork.orders.at("south", south_s_m(1.3536)));
  // At the end of bypass1 the tracks are 0.15 m apart.
  EXPECT_FALSE(near_fork.commands.has_room(near_fork.orders.at("bypass2", 0.0)));
}

TEST_F(ObjectCommands, find_the_position_with_the_most_room) {
  (void)world.orders.add_at("AIV1", {0, 1.0});
  // The far points of both arcs are 0.5 m beyond their centres, at an angle of atan2(0.5, 1) = 26.57°: on the western
  // arc at s = 0.554 m, on the eastern one at 1.017 m. Positions are 5 cm apart.
  ASSERT_TRUE(world.commands.roomiest().has_value());
  EXPECT_EQ(world.commands.roomiest()->section, 3U);
  EXPECT_NEAR(world.commands.roomiest()->s_m, 0.55, 1e-9);
  EXPECT_EQ(add(fields_of("aiv"))->position, *world.commands.roomiest());
  // 1.66 m − 0.30 m from there
  world.add_object("box", {-2.1, 0.9}, 0.3);
  EXPECT_EQ(world.commands.roomiest()->section, 1U);
  EXPECT_NEAR(world.commands.roomiest()->s_m, 1.0, 1e-9);
  (void)world.simulator().detected().see("CoSiVA/AIV1", world.orders.now, {4.1, 0.9}, 0.3);
  EXPECT_EQ(world.commands.roomiest()->section, 3U);
  EXPECT_NEAR(world.commands.roomiest()->s_m, 0.25, 1e-9);
}

TEST_F(ObjectCommands, move_an_object_with_its_last_speed_and_repetition) {
  world.add_object("P1", {0.5, 0.25}, 0.06, 0.7, Repeat::back_and_forth);
  world.add_object("P2", {0.5, 0.25});
  VirtualObjectFields fields = on_path(2);
  fields.id = "P1";
  auto read = world.commands.read(MoveCommand{fields});
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->act, VirtualObjectCommand::Act::move);
  EXPECT_EQ(read->id, "P1");
  EXPECT_EQ(read->walk.speed_mps(), 0.7);
  EXPECT_EQ(read->walk.repeat(), Repeat::back_and_forth);
  fields.id = "P2";
  read = world.commands.read(MoveCommand{fields});
  ASSERT_TRUE(read.has_value());
  EXPECT_EQ(read->walk.speed_mps(), world.simulator().zone()->profiles.slow.speed_mps) << "it did not walk";
}

TEST_F(ObjectCommands, move_no_vehicle_nor_an_obstacle_along_a_path) {
  world.host("V1", {2, 1.0});
  world.add_object("box", {0.5, 0.25}, 0.06, 0.0, Repeat::once, VirtualObjectKind::obstacle);
  const auto error_for = [&](VirtualObjectFields fields, const std::string& id) {
    fields.id = id;
    return error_of(world.commands.read(MoveCommand{std::move(fields)}));
  };
  EXPECT_EQ(error_for(at_point("", 0.5, 0.25), "V1").code, "virtual_object.aiv");
  EXPECT_EQ(error_for(on_path(2), "box").code, "virtual_object.path");
  EXPECT_EQ(error_for(at_point("", 0.5, 0.25), "box").code, "accepted");
  EXPECT_EQ(error_for(at_point("", 0.5, 0.25), "P9"),
            (Error{"virtual_object.unknown", "no virtual object is called 'P9'; there are box, V1", "id"}));
  EXPECT_EQ(error_of(world.commands.read(MoveCommand{at_point("", 0.5, 0.25)})),
            (Error{"virtual_object.id", "give the id of the virtual object to move", "id"}));
}

TEST_F(ObjectCommands, remove_objects_vehicles_or_all) {
  const auto read_remove = [&](const std::string& id) { return world.commands.read(RemoveCommand{id}); };
  EXPECT_EQ(
      error_of(read_remove("P1")),
      (Error{"virtual_object.unknown", "no virtual object is called 'P1'; there is none yet; add one first", "id"}));
  world.add_object("P1", {0.5, 0.25});
  world.host("V1", {2, 1.0});
  for (const std::string id : {"*", "P1"}) {
    ASSERT_TRUE(read_remove(id).has_value());
    EXPECT_EQ(read_remove(id)->act, VirtualObjectCommand::Act::remove);
    EXPECT_EQ(read_remove(id)->id, id);
    EXPECT_FALSE(read_remove(id)->is_aiv);
  }
  for (const std::string id : {"V1", "CoSiVA.virtual/V1"}) {
    ASSERT_TRUE(read_remove(id).has_value());
    EXPECT_TRUE(read_remove(id)->is_aiv);
  }
}

TEST_F(ObjectCommands, list_known_objects_up_to_200_bytes) {
  for (const char initial : {'a', 'b', 'c'}) world.add_object(std::string(99, initial), {0.5, 0.25});
  EXPECT_EQ(error_of(world.commands.read(RemoveCommand{"x"})).message,
            "no virtual object is called 'x'; there are " + std::string(99, 'a') + ", " + std::string(99, 'b'));
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
