#include "cosiva/virtual/server/orders/line_join.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

#include "cosiva/virtual/server/testing/orders_fixture.h"

namespace cosiva::virtual_side {
namespace {

using namespace fixture;
using testing::Contains;
using testing::IsEmpty;
using testing::SizeIs;

/// A vehicle 0.2 m to the left of the south side of the oval, at 1.0 m, and another vehicle on the path there: the
/// nearest position is not free. Bodies are 0.20 m long and 0.12 m wide.
class Joins : public testing::Test {
 protected:
  Joins()
      : vehicle{orders.add_off_path("AIV1", orders.at("south", 1.0), 0.2)},
        other{orders.add_at("AIV2", orders.at("south", 1.0))} {
    orders.waits.wait_for(vehicle, other, WaitReason::off_path);
    orders.waits.record(vehicle, true, orders.now);
  }
  std::vector<wire::Action> commanded() { return orders.actions_to(vehicle, "joinLine"); }
  void try_after(SimDuration duration) {
    orders.pass(duration);
    orders.joins.try_other_positions(vehicle);
  }
  OrdersFixture orders;
  VehicleIndex vehicle;
  VehicleIndex other;
};

TEST_F(Joins, the_path_where_no_body_obstructs_it) {
  EXPECT_EQ(orders.joins.obstructs_line_entry(vehicle, orders.at("south", 1.0)), other);
  EXPECT_EQ(orders.joins.obstructs_line_entry(vehicle, orders.at("south", 1.45)), no_vehicle);
  orders.proxy(other).membership.on_retired();
  EXPECT_EQ(orders.joins.obstructs_line_entry(vehicle, orders.at("south", 1.0)), no_vehicle);
}

TEST_F(Joins, no_path_that_the_base_of_another_vehicle_leads_over) {
  orders.waits.end(vehicle);
  orders.report_at(other, orders.at("south", 0.1));
  orders.pass(1s);
  EXPECT_EQ(orders.joins.obstructs_line_entry(vehicle, orders.at("south", 1.0)), no_vehicle);
  ASSERT_TRUE(orders.extend(other));
  EXPECT_EQ(orders.joins.obstructs_line_entry(vehicle, orders.at("south", 1.0)), other);
}

TEST_F(Joins, another_position_after_a_second_from_which_it_can_continue) {
  try_after(999ms);
  EXPECT_THAT(commanded(), IsEmpty());
  EXPECT_FALSE(orders.joins.is_pending(vehicle));
  try_after(1ms);
  ASSERT_THAT(commanded(), SizeIs(1));
  EXPECT_TRUE(orders.joins.is_pending(vehicle));
  // In front of the other vehicle: behind it, the vehicle could not continue. At most 0.45 m from the nearest position.
  EXPECT_GT(*commanded()[0].number("x"), 1.2);
  EXPECT_LE(*commanded()[0].number("x"), 1.45 + 1e-9);
  EXPECT_NEAR(*commanded()[0].number("y"), 0.0, 1e-9);
  EXPECT_NEAR(*commanded()[0].number("theta"), 0.0, 1e-9);
  ASSERT_TRUE(orders.positions.entry_point(vehicle).has_value());
  EXPECT_NEAR(orders.positions.entry_point(vehicle)->s_m, *commanded()[0].number("x"), 1e-9);
  EXPECT_TRUE(orders.traffic.track_position(vehicle).has_value()) << "others have to keep away from there";
}

TEST_F(Joins, no_other_position_while_it_does_not_wait) {
  orders.waits.end(vehicle);
  try_after(10s);
  EXPECT_THAT(commanded(), IsEmpty());
}

TEST_F(Joins, no_other_position_where_it_follows_the_path_already) {
  EXPECT_FALSE(orders.joins.join_elsewhere(other, false, 0.45));
}

TEST_F(Joins, until_the_action_has_finished_or_failed_or_fifteen_seconds_are_over) {
  EXPECT_FALSE(orders.joins.continue_joining(vehicle)) << "none is pending";
  try_after(1s);
  ASSERT_THAT(commanded(), SizeIs(1));
  EXPECT_TRUE(orders.joins.continue_joining(vehicle));
  orders.report_action(vehicle, commanded()[0], wire::ActionStatus::running);
  orders.pass(14999ms);
  EXPECT_TRUE(orders.joins.continue_joining(vehicle));
  orders.pass(1ms);
  EXPECT_FALSE(orders.joins.continue_joining(vehicle));
  EXPECT_FALSE(orders.joins.is_pending(vehicle));
  EXPECT_FALSE(orders.positions.entry_point(vehicle).has_value());
}

TEST_F(Joins, and_logs_the_reason_where_the_vehicle_could_not) {
  try_after(1s);
  ASSERT_THAT(commanded(), SizeIs(1));
  orders.report_action(vehicle, commanded()[0], wire::ActionStatus::failed, "blocked");
  EXPECT_FALSE(orders.joins.continue_joining(vehicle));
  EXPECT_THAT(orders.logs(), Contains("w CoSiVA/AIV1: did not join the path: blocked"));
}

TEST_F(Joins, without_a_log_line_where_the_vehicle_has_finished) {
  try_after(1s);
  ASSERT_THAT(commanded(), SizeIs(1));
  orders.report_action(vehicle, commanded()[0], wire::ActionStatus::finished);
  EXPECT_FALSE(orders.joins.continue_joining(vehicle));
  EXPECT_THAT(orders.logs(), IsEmpty());
}

/// A vehicle on the south side of the oval, and an off-path vehicle next to its path.
class OffPathBody : public testing::Test {
 protected:
  [[nodiscard]] VehicleIndex obstruction(double to_m) const {
    return orders.joins.off_path_obstruction(vehicle, 0.0, to_m);
  }
  OrdersFixture orders;
  VehicleIndex vehicle{orders.add_at("AIV1", orders.at("south", 0.3))};
};

TEST_F(OffPathBody, obstructs_a_vehicle_that_would_pass_it_within_four_centimetres) {
  const VehicleIndex body = orders.add_off_path("agv-1", orders.at("south", 1.3), 0.12 + 0.035, 0.0, "Acme");
  // The bodies would be side by side 0.8 m further on; the vehicle stops 0.12 m before a body by itself.
  EXPECT_EQ(obstruction(1.2), body);
  EXPECT_EQ(obstruction(0.5), no_vehicle);
  EXPECT_EQ(orders.joins.off_path_obstruction(body, 0.0, 1.2), no_vehicle) << "no vehicle obstructs itself";
}

TEST_F(OffPathBody, does_not_obstruct_a_vehicle_that_passes_it_with_more_clearance) {
  orders.add_off_path("agv-1", orders.at("south", 1.3), 0.12 + 0.045, 0.0, "Acme");
  EXPECT_EQ(obstruction(1.2), no_vehicle);
}

TEST_F(OffPathBody, obstructs_with_the_whole_area_of_its_entry_for_five_seconds) {
  const VehicleIndex joining = orders.add_off_path("AIV2", orders.at("south", 1.3), 0.25);
  EXPECT_EQ(obstruction(1.2), no_vehicle) << "it does not wait to be let in";
  orders.waits.wait_for(joining, vehicle, WaitReason::off_path);
  orders.waits.record(joining, true, orders.now);
  EXPECT_EQ(obstruction(1.2), joining);
  orders.pass(5s);
  EXPECT_EQ(obstruction(1.2), joining);
  orders.pass(1ms);
  EXPECT_EQ(obstruction(1.2), no_vehicle);
}

TEST_F(Joins, the_path_by_a_command_that_is_repeated_for_less_than_three_seconds) {
  try_after(1s);
  ASSERT_THAT(commanded(), SizeIs(1));
  EXPECT_EQ(commanded()[0].blocking_type, wire::BlockingType::hard);
  orders.pass(2999ms);
  orders.actions.tick(orders.server.registry, true);
  EXPECT_THAT(commanded(), SizeIs(2));
  orders.pass(301ms);
  orders.actions.tick(orders.server.registry, true);
  EXPECT_THAT(commanded(), SizeIs(2));
}

TEST(JoinsToMakeRoom, after_four_seconds_where_it_cannot_continue_from_any_position) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_off_path("AIV1", orders.at("south", 0.9), 0.25);
  const VehicleIndex other = orders.add_at("AIV2", orders.at("south", 1.0));
  orders.add_at("AIV3", orders.at("south", 1.3));
  orders.waits.wait_for(vehicle, other, WaitReason::off_path);
  orders.waits.record(vehicle, true, orders.now);
  const auto commanded_after = [&](SimDuration duration) {
    orders.pass(duration);
    orders.joins.try_other_positions(vehicle);
    return orders.actions_to(vehicle, "joinLine");
  };
  EXPECT_THAT(commanded_after(1s), IsEmpty()) << "the other vehicle is ahead of every free position";
  EXPECT_FALSE(orders.traffic.track_position(vehicle).has_value()) << "a position only tried keeps no vehicle away";
  EXPECT_THAT(commanded_after(2999ms), IsEmpty());
  const auto commanded = commanded_after(1ms);
  ASSERT_THAT(commanded, SizeIs(1));
  EXPECT_NEAR(*commanded[0].number("x"), 0.75, 1e-9) << "the nearest free position";
}

/// The vehicle that keeps another one from joining the path at `s_m`, from the right; it joins at 1.0 m itself, from
/// the left, in the given manner.
VehicleIndex obstructs_entry(double s_m, const std::function<bool(OrdersFixture&, VehicleIndex)>& joins) {
  OrdersFixture orders;
  const VehicleIndex first = orders.add_off_path("AIV1", orders.at("south", 1.0), 0.25);
  EXPECT_TRUE(joins(orders, first));
  const VehicleIndex second = orders.add_off_path("AIV2", orders.at("south", s_m), -0.25);
  return orders.joins.obstructs_line_entry(second, orders.at("south", s_m));
}

TEST(EntriesOfTwoVehicles, keep_two_half_diagonals_and_two_centimetres_apart) {
  // Half the diagonal of 0.20 m by 0.12 m is 0.1166 m: 0.2532 m.
  const auto with_order = [](OrdersFixture& orders, VehicleIndex first) { return orders.extend(first); };
  EXPECT_EQ(obstructs_entry(1.0 - 0.250, with_order), 0U);
  EXPECT_EQ(obstructs_entry(1.0 - 0.256, with_order), no_vehicle);
  const auto by_action = [](OrdersFixture& orders, VehicleIndex first) {
    return orders.joins.join_elsewhere(first, false, 0.45);
  };
  EXPECT_EQ(obstructs_entry(1.0 - 0.250, by_action), 0U);
  EXPECT_EQ(obstructs_entry(1.0 - 0.256, by_action), no_vehicle);
}

TEST(EntriesOfTwoVehicles, do_not_conflict_while_the_other_one_is_not_sent) {
  const auto not_sent = [](OrdersFixture& orders, VehicleIndex first) {
    orders.positions.set_entry_point(first, orders.at("south", 1.0));
    return true;
  };
  EXPECT_EQ(obstructs_entry(1.0 - 0.250, not_sent), no_vehicle);
}

TEST_F(OffPathBody, next_to_the_vehicle_may_be_passed_at_the_present_clearance) {
  const VehicleIndex side = orders.add_off_path("agv-1", orders.at("south", 0.29), 0.12 + 0.02, 0.0, "Acme");
  EXPECT_EQ(obstruction(1.2), no_vehicle);
  orders.proxy(side).membership.on_retired();
  const VehicleIndex front = orders.add_off_path("agv-2", orders.at("south", 0.45), 0.12 + 0.02, 0.0, "Acme");
  EXPECT_EQ(obstruction(1.2), front) << "its front end is ahead";
}

TEST_F(OffPathBody, behind_the_vehicle_or_before_the_stretch_does_not_count) {
  orders.add_off_path("agv-1", orders.at("south", 0.0), 0.15, 0.0, "Acme");
  EXPECT_EQ(orders.joins.off_path_obstruction(vehicle, -0.3, 0.2), no_vehicle);
  orders.add_off_path("agv-2", orders.at("south", 0.42), 0.15, 0.0, "Acme");
  EXPECT_EQ(orders.joins.off_path_obstruction(vehicle, 0.6, 0.8), no_vehicle);
  EXPECT_NE(orders.joins.off_path_obstruction(vehicle, 0.0, 0.8), no_vehicle);
}

TEST_F(Joins, no_position_from_which_a_body_next_to_the_path_would_soon_stop_it) {
  // From 1.25 m on, the free positions are in front of the other vehicle; 0.5 m further a body obstructs the path.
  orders.add_off_path("AIV3", orders.at("south", 1.95), 0.15);
  try_after(1s);
  EXPECT_THAT(commanded(), IsEmpty());
  EXPECT_NEAR(orders.positions.reported(vehicle).position->s_m, 1.0, 1e-9) << "its position as before";
}

}  // namespace
}  // namespace cosiva::virtual_side
