#include "cosiva/virtual/server/context/awaited_vehicles.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::IsEmpty;
using testing::Not;
using testing::SizeIs;

/// Two vehicles that circulate, and a server that is killed and started on its persisted state.
class Awaited : public testing::Test {
 protected:
  Awaited() { server.run_for(5s); }
  void restart() {
    server.restart_server(true);
    server.published.clear();
  }
  [[nodiscard]] std::vector<wire::Publish> orders() const { return server.published_on("uagv/v2/CoSiVA/AIV1/order"); }

  ServerFixture server;
  FixtureVehicle& driving = server.add("AIV1", {0, 0.3});
  FixtureVehicle& other = server.add("AIV2", {2, 0.3});
};

TEST_F(Awaited, are_all_vehicles_that_reported_before_the_restart) {
  ASSERT_THAT(server.published_on("uagv/v2/CoSiVA/AIV1/order"), Not(IsEmpty()));
  other.alive = false;
  restart();
  server.run_for(5s);
  EXPECT_THAT(orders(), IsEmpty()) << "the base of AIV2 is not known";
  other.alive = true;
  server.run_for(2s);
  EXPECT_THAT(orders(), Not(IsEmpty()));
  EXPECT_FALSE(server.logged("have not reported"));
}

TEST_F(Awaited, count_with_the_base_that_they_reported_before_the_zone_was_known) {
  server.forget_zone();
  restart();
  server.run_for(1500ms);
  ASSERT_EQ(server.server->zone(), nullptr);
  other.alive = false;
  server.feed(wire::InputKind::message, "cosiva/v1/zone/toml", oval().text, true);
  server.run_for(100ms);
  EXPECT_TRUE(server.logged("CoSiVA/AIV2: took over order"));
}

TEST_F(Awaited, are_given_up_after_ten_seconds) {
  other.alive = false;
  restart();
  server.run_for(9s);
  EXPECT_THAT(orders(), IsEmpty());
  server.run_for(4s);
  EXPECT_THAT(orders(), Not(IsEmpty()));
  EXPECT_TRUE(server.logged("these vehicles have not reported since the restart: CoSiVA/AIV2"));
}

TEST_F(Awaited, are_awaited_still_after_another_restart) {
  other.alive = false;
  restart();
  server.run_for(3s);
  server.send_command(R"({"command":"slow","vehicle":"CoSiVA/AIV1"})");  // the state is persisted again
  restart();
  server.run_for(5s);
  EXPECT_THAT(orders(), IsEmpty());
}

TEST_F(Awaited, are_not_those_that_have_signed_off) {
  server.command("slow", "CoSiVA/AIV1");
  EXPECT_THAT(server.persisted, testing::HasSubstr(R"("vehicles":["CoSiVA/AIV1","CoSiVA/AIV2"])"));
  server.connection(other, wire::ConnectionState::offline);
  other.alive = false;
  server.command("medium", "CoSiVA/AIV1");
  EXPECT_THAT(server.persisted, testing::HasSubstr(R"("vehicles":["CoSiVA/AIV1"])"));
  restart();
  server.run_for(4s);
  EXPECT_THAT(orders(), Not(IsEmpty()));
}

/// AIV1 is out of reach in a crossing of the clover when the server is killed; AIV2 comes to the same crossing from
/// another side.
class AwaitedInCrossing : public testing::Test {
 protected:
  AwaitedInCrossing() {
    for (int i = 0; i < 100 && held_by("CoSiVA/AIV1").empty(); ++i) server.run_for(100ms);
    crossings = held_by("CoSiVA/AIV1");
    absent.alive = false;
    server.run_for(100ms);
  }
  [[nodiscard]] std::vector<std::string> held_by(const std::string& vehicle) const {
    std::vector<std::string> names;
    const JsonValue snapshot = server.snapshot();
    for (const JsonValue& crossing : *snapshot.find("crossings")->array())
      if (crossing.text("heldBy") == vehicle) names.push_back(*crossing.text("name"));
    return names;
  }
  [[nodiscard]] std::string waits_for() const { return server.aiv("CoSiVA/AIV2").text("waitsFor").value_or(""); }
  void retire() { server.send_command(R"({"command":"retire","vehicle":"CoSiVA/AIV1"})"); }
  void expect_crossings_stay_held(SimDuration duration) {
    for (const SimTime end = server.now + duration; server.now < end; server.run_for(1s))
      ASSERT_EQ(held_by("CoSiVA/AIV1"), crossings) << to_milliseconds_by_seconds(end - server.now) << " ms before end";
  }
  void expect_other_passes() {
    for (int i = 0; i < 300 && held_by("CoSiVA/AIV2").empty(); ++i) server.run_for(100ms);
    EXPECT_THAT(held_by("CoSiVA/AIV2"), Not(IsEmpty()));
    EXPECT_EQ(server.touches(), 0);
  }

  ServerFixture server{zone_file("lacet4.toml")};
  FixtureVehicle& absent = server.add("AIV1", {0, 0.2});
  FixtureVehicle& other = server.add("AIV2", {2, 0.0});
  std::vector<std::string> crossings;
};

TEST_F(AwaitedInCrossing, holds_it_until_it_reports_however_long_that_takes) {
  ASSERT_THAT(crossings, Not(IsEmpty()));
  server.restart_server(true);
  server.run_for(2s);
  expect_crossings_stay_held(40s);
  EXPECT_THAT(waits_for(), testing::HasSubstr("CoSiVA/AIV1"));
  EXPECT_TRUE(server.logged("CoSiVA/AIV1 (holds " + crossings.front()));
  absent.alive = true;
  server.run_for(3s);
  EXPECT_TRUE(server.logged("CoSiVA/AIV1: took over order"));
  expect_other_passes();
}

TEST_F(AwaitedInCrossing, holds_it_although_its_position_is_known_before_its_order_is) {
  server.restart_server(true);
  server.run_for(2s);
  server.send(absent, "visualization", vda::encode(absent.visualization(server.now)));
  expect_crossings_stay_held(20s);
}

TEST_F(AwaitedInCrossing, holds_it_over_another_restart_and_before_the_zone_is_known_again) {
  server.restart_server(true);
  server.forget_zone();
  server.command("slow", "CoSiVA/AIV2");
  server.restart_server(true);
  server.run_for(1s);
  server.command("medium", "CoSiVA/AIV2");  // persisted, without a zone
  server.restart_server(true);
  server.feed(wire::InputKind::message, "cosiva/v1/zone/toml", zone_file("lacet4.toml").text, true);
  server.run_for(2s);
  expect_crossings_stay_held(15s);
}

TEST_F(AwaitedInCrossing, holds_it_although_the_broker_has_lost_its_connection) {
  server.vehicles.erase(server.vehicles.begin());
  server.restart_server(true);
  server.run_for(2s);
  expect_crossings_stay_held(15s);
}

TEST_F(AwaitedInCrossing, gives_it_back_when_an_operator_retires_it) {
  server.restart_server(true);
  server.run_for(12s);
  retire();
  expect_other_passes();
  EXPECT_TRUE(server.logged("CoSiVA/AIV1: has left the zone; an operator has retired it"));
}

TEST_F(AwaitedInCrossing, gives_it_back_when_it_signs_off) {
  server.restart_server(true);
  server.run_for(12s);
  server.connection(absent, wire::ConnectionState::offline);
  expect_other_passes();
}

TEST_F(AwaitedInCrossing, holds_nothing_in_another_zone) {
  ASSERT_THAT(server.persisted, testing::HasSubstr(R"("held":{"zone":"lacet4","crossings":{"X)"));
  std::string elsewhere = server.persisted;
  elsewhere.replace(elsewhere.find(R"("zone":"lacet4","crossings")"), 15, R"("zone":"lacet5")");
  server.persisted = elsewhere;
  server.restart_server(true);
  server.run_for(12s);
  EXPECT_THAT(held_by("CoSiVA/AIV1"), IsEmpty());
}

TEST(AwaitedVehicles, skip_what_is_no_name) {
  ServerContext context;
  Traffic traffic;
  const Missions missions{context.registry, context.publisher};
  AwaitedVehicles awaited{context, traffic, missions};
  awaited.restore(*JsonValue::parse(R"({"a":1})"), nullptr);
  const JsonValue held = *JsonValue::parse(R"({"zone":7,"crossings":{"X1":7,"X2":"CoSiVA/AIV9","X3":null}})");
  awaited.restore(*JsonValue::parse(R"([7,null,"CoSiVA/AIV1",[]])"), &held);
  EXPECT_THAT(awaited.holders(), IsEmpty());
  JsonWriter json;
  awaited.write(json.begin_object());
  EXPECT_EQ(json.end_object().take(), R"({"vehicles":["CoSiVA/AIV1"]})");
}

}  // namespace
}  // namespace cosiva::virtual_side
