#include "cosiva/virtual/server/orders/yielding.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <optional>
#include <string>
#include <utility>
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

TEST_F(Yields, only_while_more_than_two_centimetres_of_its_base_are_left) {
  const zone::TrackPosition end = orders.map->waypoint(orders.sessions[vehicle].base_end()).position;
  const auto cost_before_end_m = [&](double left_m) {
    orders.report_at(vehicle, orders.map->circuit().advance(end, -left_m));
    return cost_m(Means::wait, WaitReason::crossing);
  };
  EXPECT_EQ(cost_before_end_m(0.021), 0.0);
  EXPECT_EQ(cost_before_end_m(0.019), std::nullopt) << "there is nothing to release";
}

TEST_F(Yields, by_backing_up_no_further_than_half_a_metre) {
  orders.context.rules.back_up_m_max = 0.046;
  EXPECT_TRUE(cost_m(Means::back_up).has_value());
  orders.context.rules.back_up_m_max = 0.044;
  EXPECT_EQ(cost_m(Means::back_up), std::nullopt);
}

TEST_F(Yields, by_backing_up_only_where_no_virtual_object_is_behind) {
  // The rear of the body comes to 0.8 - 0.1 - 0.045 - 0.04 m; 0.03 m further there is nothing.
  const double free_from_m = 0.8 - 0.1 - 0.045 - 0.04 - 0.03;
  const auto cost_with_object_m = [&](double edge_m, double left_m) {
    auto& augmented = orders.server.simulator.augmented();
    augmented.add(VirtualObject{"box", VirtualObjectKind::obstacle, 0, 0.05,
                                Walk({{edge_m - 0.05, left_m}}, 0.0, Repeat::once), orders.now, orders.now});
    const auto cost = cost_m(Means::back_up);
    augmented.remove("box");
    return cost;
  };
  EXPECT_TRUE(cost_with_object_m(free_from_m - 0.002, 0.0).has_value());
  EXPECT_EQ(cost_with_object_m(free_from_m + 0.002, 0.0), std::nullopt);
  EXPECT_TRUE(cost_with_object_m(0.70, 0.06 + 0.05 + 0.032).has_value()) << "next to the body, where it backs up to";
  EXPECT_EQ(cost_with_object_m(0.70, 0.06 + 0.05 + 0.028), std::nullopt);
}

TEST(YieldsNearAJoint, by_backing_up_over_it) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("north", 0.01));
  const VehicleIndex other = orders.add_at("AIV2", orders.at("north", 0.8));
  const std::vector<Wait> waits{{other, vehicle, WaitReason::turn}};
  EXPECT_NEAR(orders.yielding.can_yield(vehicle, Means::back_up, waits).value_or(0.0), 0.045, 1e-9)
      << "only one section leads to this one, and the path does not bend there";
}

TEST(YieldsOnAnOpenPath, by_backing_up_no_further_than_to_its_beginning) {
  OrdersFixture orders{{"toml", "track",
                        "name = \"track\"\nformat_version = 1\n[vehicle]\nlength_m = 0.20\nwidth_m = 0.12\n"
                        "[circuit]\nstart = { x = 0.0, y = 0.0, heading_deg = 0 }\nclosed = false\n"
                        "[[section]]\nname = \"track\"\nkind = \"straight\"\nlength_m = 4.0\n"}};
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("track", 0.044));
  const VehicleIndex other = orders.add_at("AIV2", orders.at("track", 1.0));
  const std::vector<Wait> waits{{other, vehicle, WaitReason::turn}};
  EXPECT_EQ(orders.yielding.can_yield(vehicle, Means::back_up, waits), std::nullopt);
  orders.report_at(vehicle, orders.at("track", 0.046));
  EXPECT_TRUE(orders.yielding.can_yield(vehicle, Means::back_up, waits).has_value());
}

TEST_F(Yields, by_a_detour_only_around_what_it_waits_for) {
  EXPECT_EQ(cost_m(Means::detour), std::nullopt) << "it waits for nothing";
  EXPECT_EQ(cost_m(Means::other_position), std::nullopt) << "it is on the path";
}

TEST_F(Yields, by_backing_up_only_when_it_is_stopped) {
  ASSERT_TRUE(yield(Means::back_up));
  end_order();
  orders.report_field(vehicle, &wire::State::driving, true);
  EXPECT_TRUE(continues());
  EXPECT_THAT(back_ups(), IsEmpty());
  orders.report_field(vehicle, &wire::State::driving, false);
  EXPECT_TRUE(continues());
  ASSERT_THAT(back_ups(), SizeIs(1));
  EXPECT_EQ(back_ups()[0].blocking_type, wire::BlockingType::hard);
}

TEST_F(Yields, by_backing_up_when_the_vehicle_behind_has_left) {
  ASSERT_TRUE(yield(Means::back_up));
  end_order();
  const VehicleIndex behind = orders.add_at("AIV3", orders.at("south", 0.8 - 0.30));
  EXPECT_TRUE(continues());
  EXPECT_THAT(back_ups(), IsEmpty());
  orders.report_at(behind, orders.at("south", 0.1));
  orders.pass(1s);
  EXPECT_TRUE(continues());
  EXPECT_THAT(back_ups(), SizeIs(1));
}

TEST_F(Yields, by_a_command_that_is_repeated_for_less_than_three_seconds) {
  ASSERT_TRUE(yield(Means::back_up));
  end_order();
  EXPECT_TRUE(continues());
  orders.pass(2999ms);
  orders.actions.tick(orders.server.registry, true);
  EXPECT_THAT(back_ups(), SizeIs(2));
  orders.pass(301ms);
  orders.actions.tick(orders.server.registry, true);
  EXPECT_THAT(back_ups(), SizeIs(2));
}

TEST(YieldsInSteps, by_backing_up_until_its_body_is_clear_of_the_other_vehicle_s_entry) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_at("AIV1", orders.at("south", 1.0));
  const VehicleIndex joining = orders.add_off_path("AIV2", orders.at("south", 1.15), 0.25);
  const std::vector<Wait> waits{{joining, vehicle, WaitReason::off_path}};
  // Bodies are 0.20 m by 0.12 m, and 0.04 m have to be free around the one that turns at 1.15 m: half the diagonal of
  // 0.28 m by 0.20 m is 0.172 m, and half a body 0.10 m. That is 0.122 m further back: five steps of 0.025 m.
  EXPECT_NEAR(orders.yielding.can_yield(vehicle, Means::back_up, waits).value_or(0.0), 5 * 0.025 + 0.02, 1e-9);
}

// --- off the path ---------------------------------------------------------------------------------------------------

/// What it costs a vehicle to wait that is off the path at `s_m`, `left_m` to the left, and obstructs another vehicle
/// 0.2 m along the south side.
std::optional<double> cost_of_waiting_off_path(double s_m, double left_m, bool waits_itself) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_off_path("AIV1", orders.at("south", s_m), left_m);
  const VehicleIndex other = orders.add_at("AIV2", orders.at("south", 0.2));
  if (waits_itself) {
    orders.waits.wait_for(vehicle, other, WaitReason::off_path);
    orders.waits.record(vehicle, true, orders.now);
  }
  return orders.yielding.can_yield(vehicle, Means::wait, std::vector<Wait>{{other, vehicle, WaitReason::off_path}});
}

TEST(YieldsOffPath, by_waiting_only_where_it_waits_to_join_the_path) {
  EXPECT_EQ(cost_of_waiting_off_path(0.9, 0.25, true), 0.0);
  EXPECT_EQ(cost_of_waiting_off_path(0.9, 0.25, false), std::nullopt) << "there is nothing to release";
}

TEST(YieldsOffPath, not_by_waiting_where_its_body_is_less_than_four_centimetres_from_the_other_one_s_path) {
  EXPECT_EQ(cost_of_waiting_off_path(0.9, 0.12 + 0.039, true), std::nullopt);
  EXPECT_EQ(cost_of_waiting_off_path(0.9, 0.12 + 0.041, true), 0.0);
}

TEST(YieldsOffPath, by_waiting_where_its_body_is_further_along_the_path_than_the_next_stretch) {
  // The path is checked up to 0.81 m, 27 steps of 0.03 m; bodies of 0.20 m, and 0.04 m between them.
  EXPECT_EQ(cost_of_waiting_off_path(0.2 + 0.81 + 0.23, 0.15, true), std::nullopt);
  EXPECT_EQ(cost_of_waiting_off_path(0.2 + 0.81 + 0.25, 0.15, true), 0.0);
}

TEST(YieldsOffPath, by_joining_the_path_elsewhere_while_it_has_no_order_and_does_not_join_yet) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_off_path("AIV1", orders.at("south", 1.0), 0.25);
  const VehicleIndex other = orders.add_at("AIV2", orders.at("north", 1.0));
  const std::vector<Wait> waits{{other, vehicle, WaitReason::off_path}};
  EXPECT_EQ(orders.yielding.can_yield(vehicle, Means::other_position, waits), 0.0);
  EXPECT_EQ(orders.yielding.can_yield(vehicle, Means::detour, waits), std::nullopt);
  EXPECT_EQ(orders.yielding.can_yield(vehicle, Means::back_up, waits), std::nullopt);
  ASSERT_TRUE(orders.yielding.yield(vehicle, Means::other_position, waits));
  EXPECT_THAT(orders.actions_to(vehicle, "joinLine"), SizeIs(1));
  EXPECT_FALSE(orders.yielding.yields(vehicle)) << "it does not stop";
  EXPECT_EQ(orders.yielding.can_yield(vehicle, Means::other_position, waits), std::nullopt) << "it joins already";
  orders.joins.end(vehicle);
  orders.traffic.set_position(vehicle, std::nullopt);
  ASSERT_TRUE(orders.extend(vehicle));
  EXPECT_EQ(orders.yielding.can_yield(vehicle, Means::other_position, waits), std::nullopt) << "it has an order";
}

TEST(YieldsOffPath, by_joining_the_path_even_where_it_cannot_continue_from) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_off_path("AIV1", orders.at("south", 0.9), 0.25);
  const VehicleIndex other = orders.add_at("AIV2", orders.at("south", 1.0));
  orders.add_at("AIV3", orders.at("south", 1.3));
  ASSERT_TRUE(
      orders.yielding.yield(vehicle, Means::other_position, std::vector<Wait>{{other, vehicle, WaitReason::off_path}}));
  // Every 0.05 m, a position nearer than 0.22 m to a body on the path is not free: a body, and 0.02 m between them.
  ASSERT_THAT(orders.actions_to(vehicle, "joinLine"), SizeIs(1));
  EXPECT_NEAR(*orders.actions_to(vehicle, "joinLine")[0].number("x"), 0.75, 1e-9);
}

TEST(YieldsOffPath, not_by_joining_the_path_further_away_than_sixty_centimetres) {
  OrdersFixture orders;
  const VehicleIndex vehicle = orders.add_off_path("AIV1", orders.at("south", 1.0), 0.25);
  int number = 2;
  for (const double s_m : {0.55, 0.85, 1.15, 1.45})
    orders.add_at("AIV" + std::to_string(number++), orders.at("south", s_m));
  EXPECT_FALSE(
      orders.yielding.yield(vehicle, Means::other_position, std::vector<Wait>{{1, vehicle, WaitReason::off_path}}));
  EXPECT_THAT(orders.actions_to(vehicle, "joinLine"), IsEmpty());
}

// --- detours --------------------------------------------------------------------------------------------------------

/// A vehicle on "entry", before the fork, with a mission to the gate: over the south side, or over the bypass.
class Detours : public testing::Test {
 protected:
  Detours() : orders{fork()}, vehicle{orders.add_at("AIV1", orders.at("entry", 0.3))}, other{orders.add("AIV2")} {
    orders.missions.give(vehicle, {Mission::Kind::go, "gate"});
    EXPECT_TRUE(orders.planner.plan(vehicle));
  }
  [[nodiscard]] std::vector<Wait> waits() const { return {{other, vehicle, WaitReason::turn}}; }
  /// While the vehicle waits for the other one there.
  std::optional<double> cost_behind(zone::TrackPosition position) {
    orders.report_at(other, position);
    orders.waits.begin(vehicle);
    orders.waits.wait_for(vehicle, other, WaitReason::off_path);
    return orders.yielding.can_yield(vehicle, Means::detour, waits());
  }
  OrdersFixture orders;
  VehicleIndex vehicle;
  VehicleIndex other;
};

TEST_F(Detours, lead_around_the_section_where_the_other_vehicle_is) {
  EXPECT_EQ(cost_behind(orders.at("south", 1.2)), 0.0);
  ASSERT_TRUE(orders.yielding.yield(vehicle, Means::detour, waits()));
  EXPECT_FALSE(orders.yielding.yields(vehicle)) << "it does not stop";
  EXPECT_TRUE(orders.planner.is_outdated(vehicle));
  ASSERT_TRUE(orders.planner.plan(vehicle));
  EXPECT_EQ(orders.traffic.remaining(vehicle).front(), orders.section("bypass1"));
}

TEST_F(Detours, do_not_exist_around_a_section_of_every_route) {
  EXPECT_EQ(cost_behind(orders.at("east", 0.5)), std::nullopt);
}

TEST_F(Detours, are_not_taken_around_a_vehicle_that_is_not_on_the_route) {
  EXPECT_EQ(cost_behind(orders.at("bypass3", 0.5)), std::nullopt);
  EXPECT_EQ(cost_behind(orders.at("entry", 0.7)), std::nullopt) << "the vehicle is on that section itself";
}

TEST_F(Detours, lead_around_a_crossing) {
  const auto& crossings = orders.map->zone().crossings;
  const auto is_fork = [&](const zone::Crossing& crossing) {
    return std::ranges::find(crossing.spans, orders.section("bypass1"), &zone::CrossingSpan::section) !=
           crossing.spans.end();
  };
  const auto fork_crossing = std::ranges::find_if(crossings, is_fork);
  ASSERT_NE(fork_crossing, crossings.end());
  const auto index = static_cast<CrossingIndex>(fork_crossing - crossings.begin());
  orders.waits.wait_for(vehicle, Traffic::Response{false, index, no_vehicle, WaitReason::crossing});
  EXPECT_EQ(orders.yielding.can_yield(vehicle, Means::detour, waits()), 0.0) << "the first section with that crossing";
}

TEST_F(Detours, are_searched_up_to_the_vehicle_s_own_section) {
  std::vector<zone::SectionId> course;
  for (const char* name : {"entry", "south", "east", "north", "west", "entry", "bypass1", "bypass2", "bypass3"})
    course.push_back(orders.section(name));
  orders.traffic.set_course(vehicle, zone::Course(std::move(course)));
  EXPECT_EQ(cost_behind(orders.at("bypass3", 0.5)), std::nullopt) << "that is one lap further on";
}

// --- crossings ------------------------------------------------------------------------------------------------------

/// What it costs a vehicle to back up for another one that waits for its turn; the vehicle is `beyond_m` beyond the end
/// of the first span of the clover's first crossing, or in the centre of that span.
std::optional<double> cost_of_backing_up(std::optional<double> beyond_m) {
  OrdersFixture orders{zone_file("lacet4.toml")};
  const zone::CrossingSpan span = orders.map->zone().crossings.front().spans.front();
  const double s_m = beyond_m ? span.to_m + *beyond_m : 0.5 * (span.from_m + span.to_m);
  const VehicleIndex vehicle = orders.add_at("AIV1", {span.section, s_m});
  const VehicleIndex other = orders.add_at("AIV2", orders.at("loop_nw", 1.4));
  return orders.yielding.can_yield(vehicle, Means::back_up, std::vector<Wait>{{other, vehicle, WaitReason::turn}});
}

TEST(YieldsInACrossing, by_backing_up_within_it_but_not_back_into_it) {
  EXPECT_NEAR(cost_of_backing_up(std::nullopt).value_or(0.0), 0.025 + 0.02, 1e-9) << "it is in the crossing already";
  EXPECT_GT(cost_of_backing_up(0.02).value_or(1.0), 0.05) << "one step back it would obstruct others";
}

TEST_F(Yields, not_by_waiting_for_a_vehicle_that_is_too_far_from_the_path_to_join_it) {
  const VehicleIndex far = orders.add_off_path("AIV3", orders.at("south", 0.3), 0.35);
  EXPECT_EQ(orders.yielding.can_yield(vehicle, Means::wait, std::vector<Wait>{{far, vehicle, WaitReason::off_path}}),
            std::nullopt);
}

}  // namespace
}  // namespace cosiva::virtual_side
