#include "cosiva/virtual/server/augmented/virtual_obstacle_publisher.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/augmented/third_party_pause.h"
#include "cosiva/virtual/server/augmented/virtual_fleet.h"
#include "cosiva/virtual/server/testing/orders_fixture.h"
#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

/// One vehicle that is stopped at (0.5, 0) with heading +x, on a straight of 2 m.
class VirtualObstaclesFixture : public testing::Test {
 protected:
  VirtualObstaclesFixture() {
    aiv.blocked = true;
    fixture.run_for(1s);
    fixture.published.clear();
  }
  void add_person(double x, double y, const std::string& id = "P1") {
    fixture.send_command(R"({"command":"add","virtualObject":{"kind":"person","id":")" + id + R"(","x":)" +
                         std::to_string(x) + ",\"y\":" + std::to_string(y) + "}}");
  }
  void remove(const std::string& id) { fixture.send_command(R"({"command":"remove","id":")" + id + "\"}"); }
  [[nodiscard]] std::vector<wire::VirtualObstacles> aheads(const std::string& name = "CoSiVA/AIV1") const {
    std::vector<wire::VirtualObstacles> all;
    for (const wire::Publish& message : fixture.published_on("cosiva/v1/virtual_obstacles/" + name))
      all.push_back(*wire::virtual_obstacles_from_json(message.payload));
    return all;
  }
  void response(std::uint32_t header_id, const std::string& brakes_for = "") {
    wire::VirtualObstaclesAck perceived{header_id, fixture.now, !brakes_for.empty(), brakes_for, std::nullopt};
    if (perceived.braking) perceived.distance_m = 0.3;
    fixture.feed(wire::InputKind::message, "cosiva/v1/virtual_obstacles_ack/CoSiVA/AIV1", wire::to_json(perceived));
  }
  [[nodiscard]] JsonValue effect(const std::string& name) const {
    return *fixture.bijection().find("effects")->find(name);
  }
  [[nodiscard]] std::vector<std::string> requested_of(const FixtureVehicle& vehicle) const {
    std::vector<std::string> types;
    for (const wire::InstantActions& message : vehicle.actions)
      for (const wire::Action& action : message.actions)
        if (types.empty() || types.back() != action.action_type) types.push_back(action.action_type);
    return types;
  }

  ServerFixture fixture;
  FixtureVehicle& aiv{fixture.add("AIV1", {0, 0.5})};
};

TEST_F(VirtualObstaclesFixture, sends_a_body_in_the_same_call_in_which_it_appeared) {
  add_person(1.2, 0.0);
  const auto commanded = aheads();
  ASSERT_THAT(commanded, SizeIs(1));
  EXPECT_EQ(commanded[0].map_id, "oval");
  EXPECT_EQ(commanded[0].timestamp, fixture.now);
  ASSERT_THAT(commanded[0].bodies, SizeIs(1));
  EXPECT_EQ(commanded[0].bodies[0].id, "P1");
  EXPECT_EQ(commanded[0].bodies[0].kind, "person");
  EXPECT_EQ(commanded[0].bodies[0].radius_m, 0.06);
  EXPECT_EQ(fixture.published_on("cosiva/v1/virtual_obstacles/CoSiVA/AIV1")[0].qos, 0);
  EXPECT_FALSE(fixture.published_on("cosiva/v1/virtual_obstacles/CoSiVA/AIV1")[0].retained);
}

TEST_F(VirtualObstaclesFixture, repeats_a_body_every_100_ms_and_sends_five_empty_messages_after_it) {
  add_person(1.2, 0.0);
  fixture.run_for(1s);
  EXPECT_THAT(aheads(), SizeIs(11)) << "at once and ten times more";
  fixture.published.clear();
  remove("P1");
  ASSERT_THAT(aheads(), SizeIs(1)) << "at once";
  fixture.run_for(2s);
  const auto commanded = aheads();
  EXPECT_THAT(commanded, SizeIs(5));
  for (const wire::VirtualObstacles& ahead : commanded) EXPECT_THAT(ahead.bodies, IsEmpty());
}

TEST_F(VirtualObstaclesFixture, sends_at_once_when_a_body_jumps_and_includes_its_motion) {
  add_person(1.2, 0.0);
  fixture.run_for(50ms);
  fixture.published.clear();
  fixture.send_command(R"({"command":"move","virtualObject":{"id":"P1","path":[[1.4,0.0],[1.4,1.0]],"speed":0.5}})");
  const auto commanded = aheads();
  ASSERT_THAT(commanded, SizeIs(1));
  EXPECT_NEAR(commanded[0].bodies[0].vy_mps, 0.5, 1e-9);
  EXPECT_NEAR(commanded[0].bodies[0].x_m, 1.4, 1e-9);
}

TEST_F(VirtualObstaclesFixture, counts_its_headers_up_by_one) {
  add_person(1.2, 0.0);
  fixture.run_for(500ms);
  const auto commanded = aheads();
  for (std::size_t i = 1; i < commanded.size(); ++i) EXPECT_EQ(commanded[i].header_id, commanded[i - 1].header_id + 1);
}

TEST_F(VirtualObstaclesFixture, does_not_send_bodies_that_are_far_or_wholly_behind) {
  add_person(0.3, 0.0, "behind");    // its front 0.06 m behind the tail at 0.4
  add_person(0.5, 1.4, "left");      // left of the vehicle
  add_person(2.45, -0.45, "ahead");  // 2.0 m from the body origin, by its edge
  add_person(1.0, 2.0, "far");       // 2.06 m less its radius is beyond… 2.0 m
  const auto commanded = aheads();
  ASSERT_FALSE(commanded.empty());
  std::vector<std::string> ids;
  for (const wire::Body& body : commanded.back().bodies) ids.push_back(body.id);
  EXPECT_THAT(ids, ElementsAre("left", "ahead")) << "nearest first";
}

TEST_F(VirtualObstaclesFixture, sends_a_person_who_comes_within_range) {
  fixture.send_command(
      R"({"command":"add","virtualObject":{"kind":"person","path":[[-0.4,0.8],[-0.4,0.0],[2.4,0.0]],"speed":1.0}})");
  EXPECT_THAT(aheads(), IsEmpty()) << "the person is behind the vehicle";
  fixture.run_for(3s);
  ASSERT_FALSE(aheads().empty());
  EXPECT_EQ(aheads().front().bodies[0].id, "P1");
}

TEST_F(VirtualObstaclesFixture, sends_nothing_while_there_is_no_virtual_object) {
  fixture.run_for(5s);
  EXPECT_THAT(aheads(), IsEmpty());
}

TEST_F(VirtualObstaclesFixture, sends_nothing_to_a_vehicle_that_is_offline) {
  fixture.kill(aiv);
  add_person(1.2, 0.0);
  fixture.run_for(1s);
  EXPECT_THAT(aheads(), IsEmpty());
  aiv.alive = true;
  fixture.connection(aiv, wire::ConnectionState::online);
  fixture.run_for(1500ms);
  EXPECT_THAT(aheads(), Not(IsEmpty())) << "and at once when the vehicle is online again and knows its position";
}

TEST_F(VirtualObstaclesFixture, measures_from_the_command_to_the_decision) {
  add_person(1.0, 0.0);
  const std::uint32_t id = aheads().back().header_id;
  fixture.now += 12ms;
  response(id, "P1");
  EXPECT_EQ(*effect("perceived_ms").number("count"), 1.0);
  EXPECT_NEAR(*effect("perceived_ms").number("max"), 12.0, 1.0) << "times on the wire are whole milliseconds";
  EXPECT_EQ(*effect("brakes_ms").number("count"), 1.0);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("brakingFor"), "P1");
  const JsonValue snapshot = fixture.snapshot();
  const JsonValue& person = snapshot.find("virtualObjects")->array()->front();
  EXPECT_EQ(person.find("perceivedBy")->array()->front().text()[0], "CoSiVA/AIV1");
}

TEST_F(VirtualObstaclesFixture, counts_each_change_once_and_braking_once_per_body) {
  add_person(1.0, 0.0);
  const std::uint32_t id = aheads().back().header_id;
  response(id);
  response(id, "P1");
  response(id, "P1");
  EXPECT_EQ(*effect("perceived_ms").number("count"), 1.0);
  EXPECT_EQ(*effect("brakes_ms").number("count"), 1.0);
  remove("P1");
  response(aheads().back().header_id);
  EXPECT_EQ(*effect("perceived_ms").number("count"), 2.0) << "a removal is a change, too";
  EXPECT_EQ(*effect("brakes_ms").number("count"), 1.0);
  EXPECT_TRUE(fixture.aiv("CoSiVA/AIV1").find("brakingFor")->is_null());
}

TEST_F(VirtualObstaclesFixture, accepts_the_acknowledgement_of_the_next_message_when_the_first_was_lost) {
  add_person(1.0, 0.0);
  const std::uint32_t id = aheads().back().header_id;
  fixture.run_for(100ms);
  response(id + 1, "P1");
  EXPECT_EQ(*effect("brakes_ms").number("count"), 1.0);
  EXPECT_NEAR(*effect("brakes_ms").number("max"), 100.0, 1.0);
}

TEST_F(VirtualObstaclesFixture, measures_the_age_of_the_information_if_a_vehicle_brakes_only_when_a_body_comes_nearer) {
  add_person(1.9, 0.0);
  response(aheads().back().header_id);
  fixture.run_for(2s);
  fixture.now += 30ms;
  const wire::VirtualObstacles news = aheads().back();
  for (int i = 0; i < 3; ++i) response(news.header_id, "P1");  // the vehicle continues to brake
  EXPECT_EQ(*effect("brakes_ms").number("count"), 1.0);
  EXPECT_NEAR(*effect("brakes_ms").number("max"), to_seconds(fixture.now - news.timestamp) * 1e3, 1.0);
  EXPECT_GE(*effect("brakes_ms").number("max"), 29.0);
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("brakingFor"), "P1");
  // A message whose sending time is no longer stored is not evaluated.
  response(news.header_id);
  fixture.run_for(3s);
  response(news.header_id, "P1");
  EXPECT_EQ(*effect("brakes_ms").number("count"), 1.0);
}

TEST_F(VirtualObstaclesFixture, ignores_acknowledgements_of_messages_it_never_sent) {
  add_person(1.0, 0.0);
  response(aheads().back().header_id + 1, "P1");
  response(4'000'000'000U, "P1");
  EXPECT_EQ(*effect("perceived_ms").number("count"), 0.0);
  EXPECT_TRUE(fixture.aiv("CoSiVA/AIV1").find("brakingFor")->is_null());
}

TEST_F(VirtualObstaclesFixture, sends_physical_vehicles_to_a_virtual_aiv_and_the_virtual_aiv_to_others) {
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"south","s":1.4}})");
  fixture.run_for(200ms);
  const auto commanded = aheads();
  ASSERT_FALSE(commanded.empty());
  EXPECT_EQ(commanded.front().bodies[0].id, "CoSiVA.virtual/V1");
  EXPECT_EQ(commanded.front().bodies[0].kind, "aiv");
  EXPECT_NEAR(commanded.front().bodies[0].length_m, 0.08, 1e-12) << "0.20 m long, 0.12 m wide";
  EXPECT_NEAR(commanded.front().bodies[0].radius_m, 0.06, 1e-12);
  EXPECT_THAT(fixture.published_on("cosiva/v1/virtual_obstacles/CoSiVA.virtual/V1"), IsEmpty())
      << "the server passes the message internally";
  const JsonValue traces = *JsonValue::parse(fixture.server->traces_json(1, 2000));
  bool traced = false;
  for (const JsonValue& trace : *traces.find("traces")->array())
    traced = traced || (trace.text("kind") == "ahead" && trace.text("to") == "CoSiVA.virtual/V1");
  EXPECT_FALSE(traced) << "AIV1 is wholly behind it";
}

TEST_F(VirtualObstaclesFixture, stops_a_virtual_aiv_before_a_person_and_a_physical_vehicle) {
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","section":"west","s":1.0}})");
  fixture.run_for(20s);
  const JsonValue v1 = fixture.aiv("CoSiVA.virtual/V1");
  EXPECT_EQ(*v1.number("speed"), 0.0) << "AIV1 is stopped on its path";
  EXPECT_LT(*v1.number("x"), 0.3);
  add_person(1.5, 1.0, "P1");  // on the north side, before a second one
  fixture.send_command(R"({"command":"add","virtualObject":{"kind":"aiv","id":"V2","section":"east","s":1.0}})");
  fixture.run_for(10s);
  EXPECT_EQ(*fixture.aiv("CoSiVA.virtual/V2").number("speed"), 0.0);
  EXPECT_GT(*fixture.aiv("CoSiVA.virtual/V2").number("x"), 1.5);
  EXPECT_EQ(fixture.aiv("CoSiVA.virtual/V2").text("brakingFor"), "P1");
  remove("P1");
  fixture.run_for(5s);
  EXPECT_LT(*fixture.aiv("CoSiVA.virtual/V2").number("x"), 1.5);
}

/// A third-party vehicle that never acknowledges.
class DeafVehicle : public VirtualObstaclesFixture {
 protected:
  DeafVehicle() { aiv.blocked = false; }
};

TEST_F(DeafVehicle, is_paused_before_a_body_on_its_path_and_released_when_the_body_has_left) {
  fixture.run_for(1s);
  ASSERT_GT(aiv.speed_mps, 0.0);
  const double x = aiv.pose().x_m;
  add_person(x + 0.75, 0.0);
  fixture.run_for(2s);
  EXPECT_EQ(aiv.speed_mps, 0.0);
  EXPECT_TRUE(aiv.paused);
  EXPECT_LT(aiv.pose().x_m + 0.1, x + 0.75 - 0.06) << "the vehicle is stopped before the person";
  EXPECT_TRUE(fixture.logged("paused for P1"));
  EXPECT_EQ(fixture.aiv("CoSiVA/AIV1").text("brakingFor"), "P1");
  remove("P1");
  fixture.run_for(2s);
  EXPECT_FALSE(aiv.paused);
  EXPECT_GT(aiv.speed_mps, 0.0);
}

TEST_F(DeafVehicle, is_not_paused_for_a_body_off_its_path) {
  fixture.run_for(1s);
  add_person(aiv.pose().x_m + 0.5, 0.2);
  fixture.run_for(3s);
  EXPECT_THAT(requested_of(aiv), Not(Contains("startPause")));
}

TEST_F(DeafVehicle, that_an_operator_paused_is_not_released_by_the_server) {
  fixture.run_for(1s);
  fixture.command("stop", "CoSiVA/AIV1");
  fixture.run_for(1s);
  add_person(aiv.pose().x_m + 0.5, 0.0);
  fixture.run_for(2s);
  remove("P1");
  fixture.run_for(3s);
  EXPECT_TRUE(aiv.paused);
  EXPECT_THAT(requested_of(aiv), Not(Contains("stopPause")));
}

TEST_F(DeafVehicle, that_an_operator_stops_is_not_released_by_a_server_that_restarts_before_the_stop_is_confirmed) {
  FixtureVehicle& other = fixture.add("AIV2", {2, 0.5});
  fixture.run_for(1s);
  add_person(aiv.pose().x_m + 0.6, 0.0);
  fixture.run_for(2s);
  aiv.deaf_to = {"startPause", "stopPause"};
  aiv.paused = false;
  aiv.state_due = true;
  fixture.command("stop", "CoSiVA/AIV1");
  fixture.run_for(20ms);
  other.alive = false;  // the server waits for its report before it enforces intentions
  fixture.restart_server(true);
  const auto restarted = requested_of(aiv).size();
  fixture.run_for(900ms);
  remove("P1");
  fixture.run_for(100ms);
  const auto requested = requested_of(aiv);
  EXPECT_THAT(std::vector(requested.begin() + static_cast<std::ptrdiff_t>(restarted), requested.end()),
              Not(Contains("stopPause")));
}

TEST_F(DeafVehicle, that_is_released_gets_no_repetition_of_that_after_a_stop) {
  fixture.run_for(1s);
  add_person(aiv.pose().x_m + 0.6, 0.0);
  fixture.run_for(2s);
  ASSERT_TRUE(aiv.paused);
  aiv.deaf_to = {"stopPause"};
  remove("P1");
  fixture.run_for(20ms);
  ASSERT_EQ(requested_of(aiv).back(), "stopPause");
  fixture.command("stop", "CoSiVA/AIV1");
  fixture.run_for(2s);
  EXPECT_EQ(requested_of(aiv).back(), "startPause");
}

TEST_F(DeafVehicle, that_an_operator_pauses_during_a_pause_by_the_server_stays_paused) {
  fixture.run_for(1s);
  add_person(aiv.pose().x_m + 0.6, 0.0);
  fixture.run_for(2s);
  ASSERT_TRUE(aiv.paused);
  fixture.command("stop", "CoSiVA/AIV1");
  fixture.run_for(1s);
  remove("P1");
  fixture.run_for(3s);
  EXPECT_TRUE(aiv.paused);
}

TEST_F(DeafVehicle, that_acknowledges_late_is_released_and_trusted) {
  fixture.run_for(1s);
  add_person(aiv.pose().x_m + 0.6, 0.0);
  fixture.run_for(1s);
  ASSERT_TRUE(aiv.paused);
  response(aheads().back().header_id, "P1");
  fixture.run_for(1s);
  EXPECT_FALSE(aiv.paused);
}

TEST_F(DeafVehicle, that_reports_its_boards_runs_the_cosiva_program_and_perceives_by_itself) {
  wire::BoardsReport report{1, fixture.now, {{wire::Board::PILS, "ok", 0, 0, 0, 0, 0, 0}}, {}, {}};
  fixture.feed(wire::InputKind::message, "cosiva/v1/boards/CoSiVA/AIV1", wire::to_json(report));
  fixture.run_for(1s);
  add_person(aiv.pose().x_m + 0.6, 0.0);
  fixture.run_for(2s);
  EXPECT_FALSE(aiv.paused);
}

TEST_F(DeafVehicle, that_was_paused_is_released_after_a_restart_of_the_server) {
  fixture.run_for(1s);
  add_person(aiv.pose().x_m + 0.6, 0.0);
  fixture.run_for(3s);
  ASSERT_TRUE(aiv.paused);
  fixture.restart_server(true);
  fixture.run_for(4s);
  EXPECT_TRUE(aiv.paused) << "the person is restored from the state file, and still there";
  remove("P1");
  fixture.run_for(2s);
  EXPECT_FALSE(aiv.paused);
}

TEST(Body, distance_refers_to_the_nearest_point_of_its_surface) {
  const wire::Body body = body_of("V1", {1.0, 2.0, 0.5 * pi}, 0.3, {0.20, 0.12});
  EXPECT_NEAR(body.vy_mps, 0.3, 1e-12);
  EXPECT_NEAR(distance_to(body, {1.0, 2.5}), 0.40, 1e-12) << "its nose is 0.10 m before its centre";
  EXPECT_NEAR(distance_to(body, {1.3, 2.0}), 0.24, 1e-12);
  EXPECT_NEAR(distance_to(body, {1.0, 2.0}), -0.06, 1e-12);
}

/// Third-party vehicle 0 at (0.5, 0) with heading +x. Its path is checked every 4 cm, 0.14 m to either side: half of
/// its width, 2 cm, and the radius of a person.
class PausedVehicle : public testing::Test {
 protected:
  PausedVehicle() {
    pauses.resize(1);
    pauses.set_map(&*orders.map);
  }
  [[nodiscard]] static wire::Body body_at(double x_m, double y_m = 0.0, const std::string& id = "P1") {
    return {id, "person", x_m, y_m, 0.0, 0.0, 0.06, 0.0, 0.0};
  }
  void evaluate(const wire::Body& body, bool is_aiv = false) {
    const ThirdPartyPause::Body one{&body, is_aiv};
    pauses.evaluate(vehicle, {0.5, 0.0, 0.0}, {&one, 1});
  }
  /// Whether the vehicle is paused for a body there, if it is not paused before.
  [[nodiscard]] bool pauses_for(const wire::Body& body, bool is_aiv = false) {
    pauses.let_go(vehicle);
    evaluate(body, is_aiv);
    return orders.proxy(vehicle).settings.paused_for_body();
  }

  OrdersFixture orders;
  VehicleIndex vehicle{orders.add_at("A1", {0, 0.5}, "ACME")};
  ThirdPartyPause pauses{orders.server.registry, orders.traffic, orders.server.publisher, orders.actions,
                         orders.server.simulator};
};

TEST_F(PausedVehicle, is_paused_for_a_body_within_eighty_centimetres_of_its_front) {
  // Points of the path up to 0.1 m + 0.8 m: the last is at 0.5 m + 22 · 0.04 m.
  EXPECT_TRUE(pauses_for(body_at(1.38 + 0.139)));
  EXPECT_FALSE(pauses_for(body_at(1.38 + 0.141)));
  EXPECT_TRUE(pauses_for(body_at(0.5 - 0.139)));
  EXPECT_FALSE(pauses_for(body_at(0.5 - 0.141))) << "only the tail is near it";
  EXPECT_TRUE(pauses_for(body_at(0.9, 0.139)));
  EXPECT_FALSE(pauses_for(body_at(0.9, 0.141)));
}

TEST_F(PausedVehicle, is_released_when_the_body_is_more_than_a_metre_away) {
  evaluate(body_at(1.4));
  // The last point is at 0.5 m + 27 · 0.04 m now.
  evaluate(body_at(1.58 + 0.139));
  EXPECT_TRUE(orders.proxy(vehicle).settings.paused_for_body());
  evaluate(body_at(1.58 + 0.141));
  EXPECT_FALSE(orders.proxy(vehicle).settings.paused_for_body());
}

TEST_F(PausedVehicle, is_checked_straight_on_where_it_is_off_the_path) {
  orders.traffic.set_position(vehicle, std::nullopt);
  const wire::Body body = body_at(0.5, 0.7);
  const ThirdPartyPause::Body one{&body, false};
  pauses.evaluate(vehicle, {0.5, 0.0, 0.0}, {&one, 1});
  EXPECT_FALSE(orders.proxy(vehicle).settings.paused_for_body());
  pauses.evaluate(vehicle, {0.5, 0.0, 0.5 * pi}, {&one, 1});
  EXPECT_TRUE(orders.proxy(vehicle).settings.paused_for_body());
}

TEST_F(PausedVehicle, is_paused_for_a_vehicle_only_within_its_base) {
  EXPECT_TRUE(pauses_for(body_at(1.4), true)) << "it has no base";
  WaypointIndex end = 0;
  while (orders.map->waypoint(end).position.s_m < 0.51) ++end;
  const double end_s_m = orders.map->waypoint(end).position.s_m;
  ASSERT_LT(end_s_m, 1.0);
  orders.traffic.set_base_end(vehicle, end);
  orders.traffic.update();
  EXPECT_FALSE(pauses_for(body_at(1.4), true));
  EXPECT_TRUE(pauses_for(body_at(1.4), false));
  EXPECT_TRUE(pauses_for(body_at(end_s_m), true)) << "at the end of its base";
}

TEST_F(PausedVehicle, gets_one_action_at_the_beginning_and_one_at_the_end) {
  evaluate(body_at(1.0));
  EXPECT_EQ(pauses.changes(), 1U);
  EXPECT_EQ(pauses.paused_for(vehicle), "P1");
  ASSERT_THAT(orders.actions_to(vehicle, "startPause"), SizeIs(1));
  EXPECT_THAT(orders.logs(), Contains("i ACME/A1: does not perceive virtual objects; paused for P1"));
  ASSERT_NE(orders.actions.find(1), nullptr);
  EXPECT_EQ(orders.actions.find(1)->until, orders.now + 5s);
  evaluate(body_at(0.9, 0.0, "P2"));
  EXPECT_EQ(pauses.paused_for(vehicle), "P2");
  EXPECT_EQ(pauses.changes(), 1U);
  EXPECT_THAT(orders.actions_to(vehicle, "startPause"), SizeIs(1));
  pauses.let_go(vehicle);
  EXPECT_EQ(pauses.paused_for(vehicle), "");
  EXPECT_EQ(pauses.changes(), 2U);
  EXPECT_THAT(orders.actions_to(vehicle, "stopPause"), SizeIs(1));
  EXPECT_EQ(orders.actions.find(1), nullptr) << "not repeated any more";
  pauses.let_go(vehicle);
  EXPECT_EQ(pauses.changes(), 2U);
  EXPECT_THAT(orders.actions_to(vehicle, "stopPause"), SizeIs(1));
}

TEST_F(PausedVehicle, is_not_paused_again_where_it_reports_that_it_is_paused) {
  orders.report_field(vehicle, &wire::State::paused, true);
  evaluate(body_at(1.0));
  EXPECT_FALSE(orders.proxy(vehicle).settings.paused_for_body());
  EXPECT_EQ(pauses.paused_for(vehicle), "");
  EXPECT_EQ(pauses.changes(), 0U);
}

TEST_F(PausedVehicle, is_not_paused_while_an_operators_stop_is_awaited_whose_end_the_pause_would_be) {
  orders.proxy(vehicle).settings.await_stop(true);
  evaluate(body_at(1.0));
  EXPECT_FALSE(orders.proxy(vehicle).settings.paused_for_body());
  pauses.let_go(vehicle);
  EXPECT_EQ(pauses.changes(), 0U) << "no stopPause";
  orders.proxy(vehicle).settings.await_stop(false);
  evaluate(body_at(1.0));
  EXPECT_TRUE(orders.proxy(vehicle).settings.paused_for_body());
}

/// The publisher without a server around it; physical vehicle 0 at (0.5, 0) with heading +x.
class BodyPublisher : public testing::Test {
 protected:
  BodyPublisher() {
    pauses.resize(2);
    pauses.set_map(&*orders.map);
    publisher.resize(1);
  }
  void add_person(double x_m, double y_m, const std::string& id = "P1") {
    VirtualObject added;
    added.id = id;
    added.radius_m = 0.06;
    added.walk = Walk({Point2{x_m, y_m}}, 0.0, Repeat::once);
    added.started = orders.now;
    orders.server.simulator.augmented().add(std::move(added));
  }
  void remove(const std::string& id) { EXPECT_TRUE(orders.server.simulator.augmented().remove(id)); }
  [[nodiscard]] std::vector<wire::VirtualObstacles> sent() const {
    std::vector<wire::VirtualObstacles> all;
    for (const wire::Effect& effect : orders.effects)
      if (const auto* message = std::get_if<wire::Publish>(&effect);
          message != nullptr && message->topic == "cosiva/v1/virtual_obstacles/CoSiVA/AIV1")
        all.push_back(*wire::virtual_obstacles_from_json(message->payload));
    return all;
  }
  /// Number of messages that an update after this time sends.
  std::size_t sent_after(SimDuration duration) {
    const std::size_t before = sent().size();
    orders.pass(duration);
    publisher.update();
    return sent().size() - before;
  }
  /// Whether a person there is sent to the vehicle.
  [[nodiscard]] bool sends(double x_m, double y_m = 0.0) {
    add_person(x_m, y_m);
    publisher.update();
    const bool found = !sent().empty() && !sent().back().bodies.empty();
    remove("P1");
    publisher.update();
    return found;
  }
  [[nodiscard]] bool acknowledge(std::uint32_t header_id, const std::string& brakes_for = "") {
    return publisher.on_virtual_obstacles_ack(
        vehicle, {header_id, orders.now, !brakes_for.empty(), brakes_for, std::nullopt}, orders.now);
  }
  [[nodiscard]] double effects(const std::string& name) const {
    JsonWriter json;
    orders.server.simulator.monitor().write(json);
    return *JsonValue::parse(json.text())->find("effects")->find(name)->number("count");
  }

  OrdersFixture orders;
  VehicleIndex vehicle{orders.add_at("AIV1", {0, 0.5})};
  VirtualFleet fleet{orders.server.registry, orders.server.publisher, orders.server.options.virtual_rules, false};
  ThirdPartyPause pauses{orders.server.registry, orders.traffic, orders.server.publisher, orders.actions,
                         orders.server.simulator};
  VirtualObstaclePublisher publisher{
      orders.server.registry, orders.server.publisher, orders.server.traces, orders.server.simulator, fleet, pauses};
};

TEST_F(BodyPublisher, sends_bodies_whose_surface_is_within_two_metres) {
  EXPECT_TRUE(sends(0.5 + 2.059));
  EXPECT_FALSE(sends(0.5 + 2.061));
  EXPECT_TRUE(sends(0.5, -2.059));
  EXPECT_FALSE(sends(0.5, -2.061));
}

TEST_F(BodyPublisher, sends_bodies_that_are_not_wholly_behind_the_tail) {
  EXPECT_TRUE(sends(0.5 - 0.1 - 0.059));
  EXPECT_FALSE(sends(0.5 - 0.1 - 0.061));
  EXPECT_TRUE(sends(0.5 - 0.1 - 0.059, 0.5)) << "to the left of the tail";
  EXPECT_FALSE(sends(0.5 - 0.1 - 0.061, 0.5));
}

TEST_F(BodyPublisher, sends_each_field_of_the_nearest_bodies) {
  add_person(1.5, 0.25, "far");
  add_person(1.0, 0.25, "near");
  publisher.update();
  ASSERT_THAT(sent(), SizeIs(1));
  const wire::VirtualObstacles message = sent().front();
  EXPECT_EQ(message.header_id, 0U);
  EXPECT_EQ(message.timestamp, orders.now);
  EXPECT_EQ(message.map_id, "oval");
  const wire::Body near{"near", "person", 1.0, 0.25, 0.0, 0.0, 0.06, 0.0, 0.0};
  const wire::Body far{"far", "person", 1.5, 0.25, 0.0, 0.0, 0.06, 0.0, 0.0};
  EXPECT_THAT(message.bodies, ElementsAre(near, far));
}

TEST_F(BodyPublisher, sends_at_most_the_32_nearest_bodies) {
  for (int i = 39; i >= 0; --i) add_person(0.7 + 0.03 * i, 0.0, "P" + std::to_string(i));
  publisher.update();
  ASSERT_THAT(sent(), SizeIs(1));
  ASSERT_THAT(sent().front().bodies, SizeIs(32));
  EXPECT_EQ(sent().front().bodies.front().id, "P0");
  EXPECT_EQ(sent().front().bodies.back().id, "P31");
}

TEST_F(BodyPublisher, repeats_a_message_after_exactly_100_ms) {
  add_person(1.0, 0.0);
  EXPECT_EQ(sent_after(0ms), 1U);
  EXPECT_EQ(sent_after(99ms), 0U);
  EXPECT_EQ(sent_after(1ms), 1U);
  remove("P1");
  EXPECT_EQ(sent_after(1ms), 1U) << "at once";
  for (int i = 0; i < 4; ++i) EXPECT_EQ(sent_after(100ms), 1U);
  EXPECT_EQ(sent_after(100ms), 0U) << "five empty messages were sent";
}

TEST_F(BodyPublisher, accepts_acknowledgements_of_the_last_256_messages) {
  EXPECT_FALSE(acknowledge(0)) << "no message was sent";
  add_person(1.0, 0.0);
  for (int i = 0; i < 257; ++i) {
    orders.pass(100ms);
    publisher.update();
  }
  ASSERT_THAT(sent(), SizeIs(257));
  EXPECT_FALSE(acknowledge(257));
  EXPECT_TRUE(acknowledge(256));
  EXPECT_TRUE(acknowledge(1));
  EXPECT_FALSE(acknowledge(0));
}

TEST_F(BodyPublisher, measures_a_change_by_the_acknowledgement_of_its_message_or_of_the_next_two) {
  add_person(1.0, 0.0);
  for (int i = 0; i < 4; ++i) ASSERT_EQ(sent_after(100ms), 1U);
  EXPECT_TRUE(acknowledge(3));
  EXPECT_EQ(effects("perceived_ms"), 0.0);
  EXPECT_TRUE(acknowledge(2, "P1"));
  EXPECT_EQ(effects("perceived_ms"), 1.0);
  EXPECT_EQ(effects("brakes_ms"), 1.0);
  EXPECT_EQ(publisher.perceives(vehicle), "P1");
  EXPECT_TRUE(acknowledge(2));
  EXPECT_EQ(effects("perceived_ms"), 1.0) << "once";
  EXPECT_EQ(publisher.perceives(vehicle), "");
}

TEST_F(BodyPublisher, continues_its_numbers_in_a_vehicle_s_new_session) {
  add_person(1.0, 0.0);
  publisher.update();
  ASSERT_TRUE(acknowledge(0, "P1"));
  publisher.new_session(vehicle);
  EXPECT_EQ(publisher.perceives(vehicle), "");
  EXPECT_EQ(sent_after(1ms), 1U) << "the vehicle has perceived nothing yet";
  EXPECT_EQ(sent().back().header_id, 1U);
}

TEST_F(BodyPublisher, folds_each_vehicle_s_messages_into_the_digest) {
  add_person(1.0, 0.0);
  publisher.update();
  ASSERT_TRUE(acknowledge(0, "P1"));
  Digest expected;
  expected.add(std::uint64_t{1});
  expected.add(std::uint64_t{1});
  expected.add(std::string_view{"P1"});
  Digest digest;
  publisher.fold(digest);
  EXPECT_EQ(digest, expected);
}

TEST(Body, of_a_vehicle_states_its_shape_and_motion) {
  const wire::Body body = body_of("V1", {1.0, 2.0, 0.5}, 0.3, {0.20, 0.12});
  EXPECT_EQ(body.id, "V1");
  EXPECT_EQ(body.kind, "aiv");
  EXPECT_EQ(body.x_m, 1.0);
  EXPECT_EQ(body.y_m, 2.0);
  EXPECT_EQ(body.heading_rad, 0.5);
  EXPECT_DOUBLE_EQ(body.length_m, 0.08);
  EXPECT_DOUBLE_EQ(body.radius_m, 0.06);
  EXPECT_NEAR(body.vx_mps, 0.3 * 0.8775825618903728, 1e-12);  // cos 0.5
  EXPECT_NEAR(body.vy_mps, 0.3 * 0.479425538604203, 1e-12);   // sin 0.5
  EXPECT_EQ(body_of("V2", {}, 0.0, {0.1, 0.12}).length_m, 0.0) << "wider than long";
}

TEST(Body, distance_is_measured_across_a_turned_body) {
  // The body's centre line reaches 0.04 m from (1, 2) in the direction of 0.5 rad.
  const wire::Body body = body_of("V1", {1.0, 2.0, 0.5}, 0.0, {0.20, 0.12});
  const Pose2 centre{1.0, 2.0, 0.5};
  EXPECT_NEAR(distance_to(body, centre * Point2{0.34, 0.0}), 0.24, 1e-12);
  EXPECT_NEAR(distance_to(body, centre * Point2{-0.34, 0.0}), 0.24, 1e-12);
  EXPECT_NEAR(distance_to(body, centre * Point2{0.03, 0.2}), 0.14, 1e-12);
  EXPECT_NEAR(distance_to(body, centre * Point2{0.34, 0.4}), 0.44, 1e-12) << "0.3 m and 0.4 m from its end";
}

}  // namespace
}  // namespace cosiva::virtual_side
