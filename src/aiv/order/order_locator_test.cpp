#include "cosiva/aiv/order/order_locator.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::diamond;
using test::order;

std::vector<zone::TrackPosition> firsts_of(const OrderLocator& locator, const wire::Order& order) {
  return locator.router().first_positions(order).value();
}

TEST(OrderLocator, measures_how_far_the_vehicle_is_beyond_the_first_node) {
  const OrderLocator locator{diamond()};
  const wire::Order to_fork = order("O-1").through({"T", "F"});
  const auto behind = locator.locate(to_fork, firsts_of(locator, to_fork), at(diamond(), "trunk", 0.3), {});
  ASSERT_TRUE(behind);
  EXPECT_NEAR(behind->vehicle_m, 0.3, 1e-9);
  EXPECT_EQ(behind->from, at(diamond(), "trunk", 0.3));
}

TEST(OrderLocator, refuses_an_order_that_starts_elsewhere) {
  const OrderLocator locator{diamond()};
  const wire::Order to_fork = order("O-1").through({"T", "F"});
  const auto elsewhere = locator.locate(to_fork, firsts_of(locator, to_fork), at(diamond(), "tail", 0.5), {});
  ASSERT_FALSE(elsewhere);
  EXPECT_EQ(elsewhere.error().code, "noRouteError");
}

TEST(OrderLocator, takes_the_other_position_of_the_vehicle_from_which_alone_there_is_a_route) {
  const OrderLocator locator{diamond()};
  const wire::Order to_merge = order("O-1").through({"F", "ro", "M"});
  const std::vector<zone::TrackPosition> also{at(diamond(), "r_up", 0.0)};
  const auto found = locator.locate(to_merge, firsts_of(locator, to_merge), at(diamond(), "l_up", 0.0), also);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->from, also.front());
}

TEST(OrderLocator, continues_a_base_from_its_end) {
  const OrderLocator locator{diamond()};
  const wire::Order update = order("O-1", 1).through({"F", "ro"});
  const zone::TrackPosition fork = firsts_of(locator, update).front();
  const auto found = locator.continuation(update, {fork, at(diamond(), "trunk", 0.0), 2.0});
  ASSERT_TRUE(found);
  EXPECT_EQ(found->route.legs.size(), 1U);
}

TEST(OrderLocator, names_the_node_where_the_vehicle_is_not_rather_than_the_lack_of_a_route) {
  const OrderLocator locator{diamond()};
  const wire::Order to_right = order("O-1").through({"F", "ro"});
  // From the left branch's position of F there is no route, from the right branch's the vehicle is too far away.
  const std::vector<zone::TrackPosition> firsts{at(diamond(), "l_up", 0.0), at(diamond(), "r_up", 0.0)};
  const std::vector<zone::TrackPosition> reversed{firsts[1], firsts[0]};
  for (const auto& positions : {firsts, reversed}) {
    const auto found = locator.locate(to_right, positions, at(diamond(), "tail", 1.0), {});
    ASSERT_FALSE(found);
    EXPECT_EQ(found.error().message.substr(0, 39), "node 'F' is not where the vehicle is: n");
  }
  const auto no_route = locator.locate(to_right, {firsts[0]}, at(diamond(), "tail", 1.0), {});
  ASSERT_FALSE(no_route);
  EXPECT_EQ(no_route.error().message, "no route along the circuit from node 'F' to node 'ro'");
}

TEST(OrderLocator, starts_from_the_position_of_the_first_node_that_is_nearest_to_the_vehicle) {
  const OrderLocator locator{diamond()};
  const wire::Order to_fork = order("O-1").through({"T1", "F"});
  const std::vector<zone::TrackPosition> firsts{at(diamond(), "trunk", 0.5), at(diamond(), "trunk", 0.9)};
  const std::vector<zone::TrackPosition> reversed{firsts[1], firsts[0]};
  for (const auto& positions : {firsts, reversed}) {
    const auto found = locator.locate(to_fork, positions, at(diamond(), "trunk", 1.0), {});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->route.first, at(diamond(), "trunk", 0.9));
    EXPECT_NEAR(found->vehicle_m, 0.1, 1e-12);
    EXPECT_NEAR(found->route.length_m(), 1.1, 1e-12);
  }
}

TEST(OrderLocator, takes_of_equally_near_first_positions_the_one_with_the_shorter_route) {
  const zone::TrafficZone& zone = test::square();
  const OrderLocator locator{zone};
  // From corner to corner the side is 1 m long, the bow π/3 m.
  const wire::Order to_corner = order("O-1").through({"A", "B"});
  const std::vector<zone::TrackPosition> firsts{at(zone, "bow", 0.0), at(zone, "south", 0.0)};
  const std::vector<zone::TrackPosition> reversed{firsts[1], firsts[0]};
  for (const auto& positions : {firsts, reversed}) {
    const auto found = locator.locate(to_corner, positions, at(zone, "west", 0.95), {});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->route.first, at(zone, "south", 0.0));
    EXPECT_NEAR(found->vehicle_m, -0.05, 1e-9);
  }
}

/// Two sections from A to B, 1 m apart: the straight, and an arc that leaves it at this angle.
zone::TrafficZone straight_and_bow(double half_rad) {
  const double curvature_per_m = 2.0 * std::sin(half_rad);
  return test::graph("bowed",
                     {{"in", {-1.0, 0.0, 0.0}, 1.0, 0.0, {1, 2}, true},
                      {"straight", {0.0, 0.0, 0.0}, 1.0, 0.0, {3}, true},
                      {"bow", {0.0, 0.0, -half_rad}, 2.0 * half_rad / curvature_per_m, curvature_per_m, {3}, true},
                      {"out", {1.0, 0.0, 0.0}, 1.0, 0.0, {}}},
                     {{"A", {1, 0.0}}, {"A", {2, 0.0}}, {"B", {3, 0.0}}});
}

TEST(OrderLocator, leaves_the_vehicle_s_own_position_only_for_a_route_that_is_shorter_by_ten_centimetres) {
  // The bow is θ/sin θ long: 1.087 m and 1.115 m.
  for (const auto& [half_rad, leaves] : {std::pair{0.70, false}, {0.80, true}}) {
    const zone::TrafficZone zone = straight_and_bow(half_rad);
    const OrderLocator locator{zone};
    const wire::Order to_corner = order("O-1").through({"A", "B"});
    const std::vector<zone::TrackPosition> also{at(zone, "straight", 0.0)};
    const auto found = locator.locate(to_corner, firsts_of(locator, to_corner), at(zone, "bow", 0.0), also);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->from, leaves ? also.front() : at(zone, "bow", 0.0)) << half_rad;
    EXPECT_NEAR(found->route.length_m(), leaves ? 1.0 : half_rad / std::sin(half_rad), 1e-9);
  }
}

TEST(OrderLocator, measures_back_to_the_first_node_where_that_is_nearer_than_round_the_loop) {
  const zone::TrafficZone& zone = test::lacet4();
  const OrderLocator locator{zone};
  // Almost a round, with a deviation of a metre: the vehicle is half a metre before the first node.
  auto lap = order("O-1").through({"loop_se@0", "east@1310"});
  lap.node(0).position = wire::NodePosition{0.75, -0.15, {}, 1.0, {}, ""};
  const double length_m = zone.circuit.section(0).length_m();
  const auto found = locator.locate(lap, firsts_of(locator, lap), at(zone, "east", length_m - 0.5), {});
  ASSERT_TRUE(found);
  EXPECT_NEAR(found->vehicle_m, -0.5, 1e-9);
}

TEST(OrderLocator, continues_a_base_from_another_position_of_its_last_node_that_is_as_far) {
  const OrderLocator locator{diamond()};
  const wire::Order update = order("O-1", 1).through({"F", "ro"});
  const zone::TrackPosition left = at(diamond(), "l_up", 0.0);
  const zone::TrackPosition right = at(diamond(), "r_up", 0.0);
  const auto continued = [&](zone::TrackPosition end, double edge_m) {
    return locator.continuation(update, {end, at(diamond(), "trunk", 0.0), edge_m});
  };
  const auto over = continued(left, 2.0);
  ASSERT_TRUE(over);
  EXPECT_EQ(over->route.first, right);
  ASSERT_TRUE(over->other_edge);
  EXPECT_NEAR(over->other_edge->length_m, 2.0, 1e-12);
  const auto straight = continued(right, 2.0);
  ASSERT_TRUE(straight);
  EXPECT_FALSE(straight->other_edge);
  EXPECT_FALSE(continued(left, 2.5)) << "the other position is nearer";
  EXPECT_FALSE(continued(left, 1.5)) << "the other position is further";
  EXPECT_EQ(continued(left, 1.5).error().code, "noRouteError");
}

TEST(OrderLocator, continues_a_base_by_the_shorter_route_and_of_equal_ones_from_its_own_end) {
  const zone::TrafficZone& zone = test::square();
  const OrderLocator by_length{zone};
  const wire::Order to_corner = order("O-1", 1).through({"A", "B"});
  for (const char* end : {"south", "bow"}) {
    const auto found = by_length.continuation(to_corner, {at(zone, end, 0.0), at(zone, "west", 0.0), 1.0});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->route.first, at(zone, "south", 0.0));
    EXPECT_EQ(found->other_edge.has_value(), std::string(end) == "bow");
  }
  const OrderLocator by_end{diamond()};
  const wire::Order to_merge = order("O-1", 1).through({"F", "M"});
  for (const char* end : {"l_up", "r_up"}) {
    const auto found = by_end.continuation(to_merge, {at(diamond(), end, 0.0), at(diamond(), "trunk", 0.0), 2.0});
    ASSERT_TRUE(found);
    EXPECT_EQ(found->route.first, at(diamond(), end, 0.0));
    EXPECT_FALSE(found->other_edge);
  }
}

TEST(OrderLocator, gives_the_position_that_was_found_first_and_then_the_others_of_its_name) {
  const OrderLocator locator{diamond()};
  const wire::Order from_fork = order("O-1").through({"F", "ro"});
  const zone::TrackPosition left = at(diamond(), "l_up", 0.0);
  const zone::TrackPosition right = at(diamond(), "r_up", 0.0);
  EXPECT_EQ(locator.positions_like(right, from_fork), (std::vector<zone::TrackPosition>{right, left}));
  EXPECT_EQ(locator.positions_like(left, from_fork), (std::vector<zone::TrackPosition>{left, right}));
}

}  // namespace
}  // namespace cosiva::aiv
