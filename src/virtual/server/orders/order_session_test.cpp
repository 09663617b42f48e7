#include "cosiva/virtual/server/orders/order_session.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>

#include "cosiva/virtual/server/testing/server_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::IsEmpty;
using testing::SizeIs;

TEST(OrderManager, sends_a_vehicle_its_own_protocol_version) {
  ServerFixture fixture;
  FixtureVehicle& unknown_sender = fixture.add("agv-7", {0, 0.5}, "Acme");
  unknown_sender.version = "2.0.0";
  fixture.run_for(2s);
  ASSERT_FALSE(unknown_sender.orders.empty());
  EXPECT_EQ(unknown_sender.orders.front().header.version, "2.0.0");
  EXPECT_EQ(unknown_sender.orders.front().header.manufacturer, "Acme");
  EXPECT_GT(unknown_sender.driven_m, 0.1);
}

TEST(OrderManager, waits_two_seconds_after_a_refusal_and_then_sends_a_new_order) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  aiv.refuse_next_order = true;
  fixture.run_for(2s);
  ASSERT_THAT(aiv.orders, SizeIs(1));
  EXPECT_TRUE(fixture.logged("refused order"));
  fixture.run_for(3s);
  ASSERT_GE(aiv.orders.size(), 2U);
  EXPECT_NE(aiv.orders[1].order_id, aiv.orders[0].order_id);
  EXPECT_GT(aiv.driven_m, 0.1);
}

TEST(OrderManager, cancels_an_active_order_with_a_refused_update_before_sending_a_new_one) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  const std::string first = aiv.book->ids().order_id;
  aiv.refuse_next_order = true;
  fixture.run_for(10s);
  EXPECT_NE(aiv.book->ids().order_id, first);
  EXPECT_THAT(aiv.refusals, IsEmpty());
  const bool cancelled =
      std::ranges::any_of(aiv.actions, [](const auto& m) { return m.actions[0].action_type == "cancelOrder"; });
  EXPECT_TRUE(cancelled);
  EXPECT_GT(aiv.speed_mps, 0.0);
}

TEST(OrderManager, sends_a_new_order_to_a_vehicle_that_restarted_without_its_order) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  fixture.run_for(5s);
  fixture.kill(aiv);
  fixture.run_for(5s);
  aiv.alive = true;
  aiv.book.emplace(*fixture.zone);
  fixture.connection(aiv, wire::ConnectionState::online);
  const double driven_m = aiv.driven_m;
  fixture.run_for(10s);
  EXPECT_THAT(aiv.refusals, IsEmpty());
  EXPECT_GT(aiv.driven_m, driven_m + 2.0);
}

TEST(OrderManager, does_not_modify_an_order_over_unknown_nodes) {
  ServerFixture fixture;
  FixtureVehicle& aiv = fixture.add("AIV1", {0, 0.5});
  wire::State state = aiv.state(fixture.now);
  state.order_id = "theirs";
  state.node_states = {{"somewhere", 2, true, std::nullopt}};
  aiv.alive = false;
  for (int i = 0; i < 30; ++i) {
    state.header.header_id++;
    state.header.timestamp = fixture.now;
    fixture.send(aiv, "state", vda::encode(state));
    fixture.run_for(100ms);
  }
  EXPECT_THAT(fixture.published_on(aiv.topic("order")), IsEmpty());
  EXPECT_TRUE(fixture.logged("left alone"));
}

}  // namespace
}  // namespace cosiva::virtual_side
