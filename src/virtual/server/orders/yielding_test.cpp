#include "cosiva/virtual/server/orders/yielding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/orders_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Contains;
using testing::IsEmpty;
using testing::SizeIs;

/// On the south side of the oval: a vehicle at 0.8 m that has an order and is stopped, and another one 0.8 m in front.
class Yields : public testing::Test {
 protected:
  Yields()
      : vehicle{orders.add_at("AIV1", orders.at("south", 0.8))}, other{orders.add_at("AIV2", orders.at("south", 1.6))} {
    EXPECT_TRUE(orders.extend(vehicle));
    orders.acknowledge(vehicle);
  }
  [[nodiscard]] std::vector<Wait> waits(WaitReason why) const { return {{other, vehicle, why}}; }
  [[nodiscard]] std::optional<double> cost_m(Means means, WaitReason why = WaitReason::turn) const {
    return orders.yielding.can_yield(vehicle, means, waits(why));
  }
  bool yield(Means means) { return orders.yielding.yield(vehicle, means, waits(WaitReason::turn)); }
  bool continues() { return orders.yielding.continue_yielding(vehicle); }
  std::vector<wire::Action> back_ups() { return orders.actions_to(vehicle, "backUp"); }
  void end_order() {
    orders.report_field(vehicle, &wire::State::node_states, {});
    orders.sessions[vehicle].drop();
  }
  OrdersFixture orders;
  VehicleIndex vehicle;
  VehicleIndex other;
};

TEST_F(Yields, by_waiting_where_the_others_wait_for_what_it_holds) {
  EXPECT_EQ(cost_m(Means::wait), 0.0);
  EXPECT_EQ(cost_m(Means::wait, WaitReason{}), std::nullopt) << "its body would still be in front of the other one";
  orders.proxy(vehicle).membership.on_retired();
  EXPECT_EQ(cost_m(Means::wait), std::nullopt);
}

TEST_F(Yields, until_the_others_have_left_or_twelve_seconds_are_over) {
  EXPECT_FALSE(orders.yielding.yields(vehicle));
  EXPECT_FALSE(continues());
  ASSERT_TRUE(yield(Means::wait));
  EXPECT_TRUE(orders.yielding.yields(vehicle));
  EXPECT_EQ(cost_m(Means::wait), std::nullopt) << "it yields already";
  EXPECT_TRUE(continues());
  EXPECT_EQ(orders.sessions[vehicle].stage(), OrderSession::Stage::cancelling) << "it releases what it holds in front";
  orders.pass(11999ms);
  EXPECT_TRUE(continues());
  orders.pass(1ms);
  EXPECT_FALSE(continues());
  EXPECT_FALSE(orders.yielding.yields(vehicle));
}

TEST_F(Yields, until_the_other_vehicle_has_moved_half_a_metre) {
  ASSERT_TRUE(yield(Means::wait));
  const zone::TrackPosition start = orders.at("south", 1.6);
  orders.report_at(other, orders.map->circuit().advance(start, 0.48));
  orders.pass(1s);
  EXPECT_TRUE(continues());
  orders.report_at(other, orders.map->circuit().advance(start, 0.56));
  orders.pass(1s);
  EXPECT_FALSE(continues());
}

TEST_F(Yields, until_the_other_vehicle_is_removed) {
  ASSERT_TRUE(yield(Means::wait));
  orders.proxy(other).membership.on_retired();
  EXPECT_FALSE(continues());
}

TEST_F(Yields, without_cancelling_an_order_that_has_nothing_to_release) {
  end_order();
  EXPECT_EQ(cost_m(Means::wait), 0.0) << "the other one waits for its turn";
  EXPECT_EQ(cost_m(Means::wait, WaitReason::off_path), std::nullopt);
  ASSERT_TRUE(yield(Means::wait));
  EXPECT_TRUE(continues());
  EXPECT_THAT(orders.actions_to(vehicle, "cancelOrder"), IsEmpty());
}

TEST_F(Yields, by_moving_up_once) {
  EXPECT_FALSE(orders.yielding.moves_up(vehicle));
  ASSERT_TRUE(yield(Means::move_up));
  EXPECT_TRUE(orders.yielding.moves_up(vehicle));
  EXPECT_FALSE(orders.yielding.yields(vehicle));
  orders.yielding.end_moving_up(vehicle);
  EXPECT_FALSE(orders.yielding.moves_up(vehicle));
}

TEST_F(Yields, by_backing_up_one_step_where_that_is_enough) {
  EXPECT_NEAR(cost_m(Means::back_up).value_or(0.0), 0.025 + 0.02, 1e-9) << "one step, and the margin";
  EXPECT_EQ(cost_m(Means::back_up, WaitReason{}), std::nullopt) << "it would still obstruct the other one";
  orders.report_field(vehicle, &wire::State::driving, true);
  EXPECT_EQ(cost_m(Means::back_up), std::nullopt) << "it is not stopped";
}

TEST_F(Yields, by_backing_up_only_where_the_path_behind_is_free) {
  // Bodies are 0.20 m long. The vehicle needs 0.045 m, 0.04 m beyond, and a clearance of 0.03 m.
  const VehicleIndex behind = orders.add_at("AIV3", orders.at("south", 0.8 - 0.33));
  EXPECT_TRUE(cost_m(Means::back_up).has_value());
  orders.report_at(behind, orders.at("south", 0.8 - 0.30));
  orders.pass(1s);
  EXPECT_EQ(cost_m(Means::back_up), std::nullopt);
}

TEST_F(Yields, by_backing_up_only_where_its_factsheet_lists_that) {
  wire::Factsheet factsheet;
  orders.proxy(vehicle).factsheet.on_factsheet(factsheet);
  EXPECT_EQ(cost_m(Means::back_up), std::nullopt);
  factsheet.actions = {{"backUp", "", true, false, false, {}}};
  orders.proxy(vehicle).factsheet.on_factsheet(factsheet);
  EXPECT_TRUE(cost_m(Means::back_up).has_value());
}

TEST(YieldsAsThirdPartyVehicle, never_by_backing_up) {
  OrdersFixture orders;
  const VehicleIndex foreign = orders.add_at("agv-1", orders.at("south", 0.8), "Acme");
  const VehicleIndex other = orders.add_at("AIV1", orders.at("south", 1.6));
  EXPECT_EQ(orders.yielding.can_yield(foreign, Means::back_up, std::vector<Wait>{{other, foreign, WaitReason::turn}}),
            std::nullopt);
}

TEST_F(Yields, by_backing_up_after_its_order_has_ended) {
  ASSERT_TRUE(yield(Means::back_up));
  EXPECT_TRUE(continues());
  EXPECT_EQ(orders.sessions[vehicle].stage(), OrderSession::Stage::cancelling);
  EXPECT_TRUE(continues());
  EXPECT_THAT(back_ups(), IsEmpty()) << "its order has not ended yet";
  end_order();
  EXPECT_TRUE(continues());
  ASSERT_THAT(back_ups(), SizeIs(1));
  EXPECT_NEAR(*back_ups()[0].number("distance"), 0.045, 1e-9);
  orders.report_action(vehicle, back_ups()[0], wire::ActionStatus::running);
  orders.proxy(other).membership.on_retired();
  EXPECT_TRUE(continues()) << "it still backs up";
  orders.report_action(vehicle, back_ups()[0], wire::ActionStatus::finished);
  EXPECT_TRUE(continues());
  EXPECT_FALSE(continues()) << "the other one has left meanwhile";
  EXPECT_THAT(back_ups(), SizeIs(1));
}

TEST_F(Yields, for_twelve_seconds_after_it_has_backed_up) {
  ASSERT_TRUE(yield(Means::back_up));
  end_order();
  EXPECT_TRUE(continues());
  orders.pass(3s);
  orders.report_action(vehicle, back_ups()[0], wire::ActionStatus::finished);
  EXPECT_TRUE(continues());
  orders.pass(11999ms);
  EXPECT_TRUE(continues());
  orders.pass(1ms);
  EXPECT_FALSE(continues());
}

TEST_F(Yields, no_longer_than_22_seconds_where_its_order_does_not_end) {
  ASSERT_TRUE(yield(Means::back_up));
  orders.pass(21999ms);
  EXPECT_TRUE(continues());
  orders.pass(1ms);
  EXPECT_FALSE(continues());
}

TEST_F(Yields, and_logs_that_it_could_not_back_up) {
  ASSERT_TRUE(yield(Means::back_up));
  end_order();
  EXPECT_TRUE(continues());
  orders.report_action(vehicle, back_ups()[0], wire::ActionStatus::failed, "blocked");
  EXPECT_TRUE(continues());
  EXPECT_THAT(orders.logs(), Contains("w CoSiVA/AIV1: did not back up: blocked"));
}

TEST_F(Yields, and_stops_backing_up_when_a_body_comes_near) {
  ASSERT_TRUE(yield(Means::back_up));
  end_order();
  EXPECT_TRUE(continues());
  orders.add_at("AIV3", orders.at("south", 0.8 - 0.203));
  EXPECT_TRUE(continues());
  ASSERT_THAT(back_ups(), SizeIs(2));
  EXPECT_EQ(back_ups()[1].number("distance"), 0.0);
  EXPECT_TRUE(continues());
  EXPECT_THAT(back_ups(), SizeIs(2)) << "commanded once";
}

}  // namespace
}  // namespace cosiva::virtual_side
