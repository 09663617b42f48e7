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

TEST(AwaitedVehicles, skip_what_is_no_name) {
  ServerContext context;
  AwaitedVehicles awaited{context};
  awaited.restore(*JsonValue::parse(R"({"a":1})"));
  awaited.restore(*JsonValue::parse(R"([7,null,"CoSiVA/AIV1",[]])"));
  JsonWriter json;
  awaited.write(json.begin_object());
  EXPECT_EQ(json.end_object().take(), R"({"vehicles":["CoSiVA/AIV1"]})");
}

}  // namespace
}  // namespace cosiva::virtual_side
