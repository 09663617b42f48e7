#include "cosiva/virtual/server/orders/wait_analysis.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/orders_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::ElementsAre;
using testing::IsEmpty;

/// One vehicle on the south side of the oval that has acknowledged its order and is stopped.
class Stopped : public testing::Test {
 protected:
  Stopped() : vehicle{orders.add_at("AIV1", orders.at("south", 0.5))} {
    EXPECT_TRUE(orders.extend(vehicle));
    orders.acknowledge(vehicle);
  }
  /// Whether the vehicle needs a new order after 12 s in this condition.
  bool needs_new_order() {
    EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
    orders.pass(12s);
    return orders.analysis.is_stopped_without_reason(vehicle);
  }
  OrdersFixture orders;
  VehicleIndex vehicle;
};

TEST_F(Stopped, without_a_reason_for_twelve_seconds_is_reported_once) {
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
  orders.pass(11999ms);
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
  orders.pass(1ms);
  EXPECT_TRUE(orders.analysis.is_stopped_without_reason(vehicle));
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
}

TEST_F(Stopped, begins_to_count_again_after_it_has_driven) {
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
  orders.pass(10s);
  orders.report_field(vehicle, &wire::State::driving, true);
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
  orders.report_field(vehicle, &wire::State::driving, false);
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
  orders.pass(10s);
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
  orders.pass(2s);
  EXPECT_TRUE(orders.analysis.is_stopped_without_reason(vehicle));
}

TEST_F(Stopped, begins_to_count_again_after_the_vehicle_was_removed) {
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
  orders.pass(12s);
  orders.analysis.forget(vehicle);
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(vehicle));
}

TEST_F(Stopped, before_an_obstacle_has_a_reason) {
  orders.report_field(vehicle, &wire::State::field_violation, true);
  EXPECT_FALSE(needs_new_order());
}
TEST_F(Stopped, by_a_command_has_a_reason) {
  orders.report_field(vehicle, &wire::State::paused, true);
  EXPECT_FALSE(needs_new_order());
}
TEST_F(Stopped, by_the_server_before_a_virtual_body_has_a_reason) {
  orders.proxy(vehicle).settings.on_body_in_path();
  EXPECT_FALSE(needs_new_order());
}
TEST_F(Stopped, with_an_error_has_a_reason) {
  orders.report_field(vehicle, &wire::State::errors, {{"motorError", wire::ErrorLevel::fatal, "", {}}});
  EXPECT_FALSE(needs_new_order());
}
TEST_F(Stopped, by_an_emergency_stop_has_a_reason) {
  orders.report_field(vehicle, &wire::State::e_stop, wire::EStop::manual);
  EXPECT_FALSE(needs_new_order());
}

TEST_F(Stopped, near_the_end_of_its_base_has_a_reason) {
  const zone::TrackPosition end = orders.map->waypoint(orders.sessions[vehicle].base_end()).position;
  orders.report_at(vehicle, orders.map->circuit().advance(end, -0.09));
  EXPECT_FALSE(needs_new_order());
  orders.report_at(vehicle, orders.map->circuit().advance(end, -0.11));
  EXPECT_TRUE(needs_new_order());
}

TEST(StoppedThirdPartyVehicle, may_have_other_reasons) {
  OrdersFixture orders;
  const VehicleIndex foreign = orders.add_at("agv-1", orders.at("south", 0.5), "Acme");
  ASSERT_TRUE(orders.extend(foreign));
  orders.acknowledge(foreign);
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(foreign));
  orders.pass(12s);
  EXPECT_FALSE(orders.analysis.is_stopped_without_reason(foreign));
}

/// A vehicle at 0.5 m of the south side of the oval, stopped with an order by its obstacle sensor, and other vehicles
/// around it. Bodies are 0.20 m long and 0.12 m wide.
class Detected : public testing::Test {
 protected:
  Detected() : vehicle{orders.add_at("AIV1", orders.at("south", 0.5))} {
    EXPECT_TRUE(orders.extend(vehicle));
    orders.acknowledge(vehicle);
    orders.report_field(vehicle, &wire::State::field_violation, true);
  }
  std::vector<Wait> waits() {
    WaitGraph graph;
    graph.begin(orders.server.registry.size());
    orders.analysis.add_waits(graph);
    (void)graph.find_knots();
    return {graph.waits().begin(), graph.waits().end()};
  }
  [[nodiscard]] Wait sensed(VehicleIndex other) const { return {vehicle, other, WaitReason::sensors}; }
  OrdersFixture orders;
  VehicleIndex vehicle;
};

TEST_F(Detected, leader_is_what_the_sensor_detects) {
  const VehicleIndex leader = orders.add_at("AIV2", orders.at("south", 0.85));
  EXPECT_THAT(waits(), ElementsAre(sensed(leader)));
  orders.report_field(vehicle, &wire::State::field_violation, false);
  EXPECT_THAT(waits(), IsEmpty());
  orders.proxy(vehicle).settings.on_body_in_path();
  EXPECT_THAT(waits(), ElementsAre(sensed(leader)));
  orders.report_field(vehicle, &wire::State::driving, true);
  EXPECT_THAT(waits(), IsEmpty()) << "it is not stopped";
}

TEST_F(Detected, vehicle_further_away_than_the_stopping_distance_is_not) {
  orders.add_at("AIV2", orders.at("south", 1.01));
  EXPECT_THAT(waits(), IsEmpty());
}

TEST_F(Detected, vehicle_is_the_nearest_one_in_the_path) {
  orders.add_at("AIV2", orders.at("south", 0.86));
  const VehicleIndex nearer = orders.add_at("AIV3", orders.at("south", 0.78));
  orders.add_at("AIV4", orders.at("south", 0.90));
  EXPECT_THAT(waits(), ElementsAre(sensed(nearer)));
}

TEST_F(Detected, vehicle_may_be_next_to_the_path_by_seven_centimetres) {
  const VehicleIndex close = orders.add_off_path("AIV2", orders.at("south", 0.80), 0.12 + 0.065);
  EXPECT_THAT(waits(), ElementsAre(sensed(close)));
}

TEST_F(Detected, vehicle_further_next_to_the_path_is_not) {
  orders.add_off_path("AIV2", orders.at("south", 0.80), 0.12 + 0.075);
  EXPECT_THAT(waits(), IsEmpty());
}

TEST_F(Detected, vehicle_at_the_side_or_behind_counts_only_where_it_prevents_turning) {
  const VehicleIndex side = orders.add_off_path("AIV2", orders.at("south", 0.48), 0.12 + 0.05);
  EXPECT_THAT(waits(), ElementsAre(sensed(side)));
  orders.proxy(side).membership.on_retired();
  EXPECT_THAT(waits(), IsEmpty());
  orders.add_off_path("AIV3", orders.at("south", 0.48), -0.12 - 0.065);
  EXPECT_THAT(waits(), IsEmpty()) << "it has the clearance to turn";
  const VehicleIndex leader = orders.add_at("AIV4", orders.at("south", 0.85));
  orders.proxy(side).membership.on_accepted();
  EXPECT_THAT(waits(), ElementsAre(sensed(leader))) << "a body on the path is preferred";
}

TEST_F(Detected, vehicle_without_an_order_waits_for_what_the_last_tick_recorded) {
  const VehicleIndex other = orders.add_at("AIV2", orders.at("south", 0.9));
  orders.sessions[vehicle].drop();
  EXPECT_THAT(waits(), IsEmpty());
  orders.waits.wait_for(vehicle, Traffic::Response{false, 2, other, WaitReason::turn});
  EXPECT_THAT(waits(), IsEmpty()) << "it is only informed early";
  orders.waits.record(vehicle, true, orders.now);
  EXPECT_THAT(waits(), ElementsAre(Wait{vehicle, other, WaitReason::turn, 2}));
  orders.waits.begin(vehicle);
  orders.waits.wait_for(vehicle, other, WaitReason::off_path);
  EXPECT_THAT(waits(), ElementsAre(Wait{vehicle, other, WaitReason::off_path}));
  orders.waits.begin(vehicle);
  EXPECT_THAT(waits(), IsEmpty());
}

/// The clover has crossings; its first one is X1.
class Sentences : public testing::Test {
 protected:
  Sentences() {
    orders.add_at("AIV1", orders.at("east", 0.3));
    orders.add_at("AIV2", orders.at("west", 0.3));
  }
  [[nodiscard]] std::string sentence(WaitReason why, CrossingIndex crossing = no_crossing) const {
    return orders.analysis.sentence({0, 1, why, crossing});
  }
  OrdersFixture orders{zone_file("lacet4.toml")};
};

TEST_F(Sentences, state_which_vehicle_waits_for_which_and_why) {
  const std::string first = orders.map->zone().crossings[0].name;
  EXPECT_EQ(sentence(WaitReason{}), "CoSiVA/AIV1 waits for CoSiVA/AIV2 ahead of it");
  EXPECT_EQ(sentence(WaitReason{}, 0), "CoSiVA/AIV1 waits for room beyond " + first + ", where CoSiVA/AIV2 is");
  EXPECT_EQ(sentence(WaitReason::crossing, 0), "CoSiVA/AIV1 waits for " + first + ", which CoSiVA/AIV2 holds");
  EXPECT_EQ(sentence(WaitReason::turn, 0), "CoSiVA/AIV1 waits for its turn at " + first + " after CoSiVA/AIV2");
  EXPECT_EQ(sentence(WaitReason::off_path), "CoSiVA/AIV1 waits for CoSiVA/AIV2, which is too close to its path");
  EXPECT_EQ(sentence(WaitReason::sensors), "CoSiVA/AIV1 detects CoSiVA/AIV2 in its path");
}

TEST_F(Sentences, list_a_crossing_and_a_vehicle) {
  const std::string last = orders.map->zone().crossings.back().name;
  const auto count = static_cast<CrossingIndex>(orders.map->crossing_count());
  EXPECT_EQ(orders.analysis.waits_for(0), "");
  EXPECT_EQ(orders.analysis.waits_for(2), "") << "there is no such vehicle";
  orders.waits.wait_for(0, Traffic::Response{false, count - 1, no_vehicle, WaitReason::crossing});
  EXPECT_EQ(orders.analysis.waits_for(0), last);
  orders.waits.wait_for(0, Traffic::Response{false, count - 1, 1, WaitReason::crossing});
  EXPECT_EQ(orders.analysis.waits_for(0), last + ", CoSiVA/AIV2");
  orders.waits.wait_for(0, Traffic::Response{false, count, 1, WaitReason::crossing});
  EXPECT_EQ(orders.analysis.waits_for(0), "CoSiVA/AIV2") << "a crossing of the zone before";
  orders.context.map = nullptr;
  EXPECT_EQ(orders.analysis.waits_for(0), "");
}

TEST(BlockerAtGoal, is_the_vehicle_within_a_body_and_the_gap_of_the_goal) {
  OrdersFixture orders{fork()};
  orders.add_at("AIV1", orders.at("entry", 0.3));
  EXPECT_EQ(orders.analysis.blocker_at_goal(0), "");
  orders.missions.give(0, {Mission::Kind::go, "gate"});
  ASSERT_TRUE(orders.missions.plan(0, std::vector{orders.at("entry", 0.3)}).has_value());
  const zone::TrackPosition goal = orders.map->waypoint(orders.missions.goal(0)).position;
  const VehicleIndex near = orders.add_at("AIV2", orders.map->circuit().advance(goal, -0.299));
  EXPECT_EQ(orders.analysis.blocker_at_goal(0), "") << "it does not wait for a vehicle";
  orders.waits.wait_for(0, near, WaitReason::off_path);
  EXPECT_EQ(orders.analysis.blocker_at_goal(0), "CoSiVA/AIV2");
  const VehicleIndex far = orders.add_at("AIV3", orders.map->circuit().advance(goal, -0.301));
  orders.waits.wait_for(0, far, WaitReason::off_path);
  EXPECT_EQ(orders.analysis.blocker_at_goal(0), "");
}

TEST_F(Detected, leader_may_be_47_centimetres_in_front) {
  // Steps of 0.03 m up to 0.21 m, a body of 0.20 m, and a tolerance of 0.07 m.
  const VehicleIndex leader = orders.add_at("AIV2", orders.at("south", 0.5 + 0.47));
  EXPECT_THAT(waits(), ElementsAre(sensed(leader)));
  orders.report_at(leader, orders.at("south", 0.5 + 0.49));
  orders.pass(1s);
  EXPECT_THAT(waits(), IsEmpty());
}

TEST(DetectedWhileJoining, is_the_nearest_vehicle_where_the_path_is_joined) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_off_path("AIV1", orders.at("south", 1.0), 0.25);
  ASSERT_TRUE(orders.joins.join_elsewhere(vehicle, false, 0.45));
  orders.add_at("AIV2", orders.at("south", 1.22));
  const VehicleIndex nearest = orders.add_at("AIV3", orders.at("south", 1.0));
  orders.report_field(vehicle, &wire::State::field_violation, true);
  WaitGraph graph;
  graph.begin(orders.server.registry.size());
  orders.analysis.add_waits(graph);
  (void)graph.find_knots();
  EXPECT_THAT(std::vector<Wait>(graph.waits().begin(), graph.waits().end()),
              ElementsAre(Wait{vehicle, nearest, WaitReason::sensors}));
}

TEST(BlockerAtGoal, does_not_exist_without_a_goal_or_a_zone) {
  OrdersFixture orders{fork()};
  orders.add_at("AIV1", orders.at("entry", 0.3));
  const VehicleIndex other = orders.add_at("AIV2", orders.at("north", 1.5));
  orders.waits.wait_for(0, other, WaitReason::off_path);
  EXPECT_EQ(orders.analysis.blocker_at_goal(0), "") << "it circulates";
  orders.missions.give(0, {Mission::Kind::go, "gate"});
  ASSERT_TRUE(orders.missions.plan(0, std::vector{orders.at("entry", 0.3)}).has_value());
  EXPECT_EQ(orders.analysis.blocker_at_goal(0), "CoSiVA/AIV2");
  orders.context.map = nullptr;
  EXPECT_EQ(orders.analysis.blocker_at_goal(0), "");
}

}  // namespace
}  // namespace cosiva::virtual_side
