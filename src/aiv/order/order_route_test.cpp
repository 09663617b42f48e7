#include "cosiva/aiv/order/order_route.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/order/order_book.h"
#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_orders.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::diamond;
using test::order;
using test::square;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Verdict = OrderBook::Verdict;

constexpr double detour_m = pi;  // from F to M, on either side

std::vector<std::string> names(const zone::TrafficZone& zone, std::span<const zone::SectionId> sections) {
  std::vector<std::string> all;
  for (const zone::SectionId id : sections) all.push_back(zone.circuit.part(id).name);
  return all;
}
OrderBook::StartState reference(const zone::TrafficZone& zone, std::string_view section, double s_m) {
  return {at(zone, section, s_m), true};
}
/// Sections ahead of a vehicle at this position.
std::vector<std::string> remaining(const OrderBook& book, const zone::TrafficZone& zone, std::string_view section,
                                   double s_m) {
  return names(zone, book.course_from(at(zone, section, s_m)).remaining());
}

TEST(OrderOnAGraph, follows_the_route_through_its_nodes) {
  for (const auto& [node, route] : {std::pair{"ro", std::vector<std::string>{"r_up", "r_over", "r_down", "tail"}},
                                    std::pair{"lo", std::vector<std::string>{"l_up", "l_over", "l_down", "tail"}}}) {
    OrderBook book{diamond()};
    const auto verdict = book.offer(order("O-1").through({"T", "F", node, "M"}), reference(diamond(), "trunk", 0.0));
    ASSERT_TRUE(verdict) << to_string(verdict.error());
    EXPECT_EQ(remaining(book, diamond(), "trunk", 0.0), route);
    EXPECT_NEAR(book.distance_to_base_end_m(), 2.0 + detour_m, 1e-9);
  }
}

TEST(OrderOnAGraph, may_omit_nodes_where_the_shortest_route_is_unique) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(order("O-1").through({"T", "rd", "E"}), reference(diamond(), "trunk", 0.0)));
  EXPECT_THAT(remaining(book, diamond(), "trunk", 0.0), ElementsAre("r_up", "r_over", "r_down", "tail"));
}

TEST(OrderOnAGraph, names_the_two_nodes_without_a_route_between_them) {
  OrderBook book{diamond()};
  const auto verdict = book.offer(order("O-1").through({"T", "lo", "rd"}), reference(diamond(), "trunk", 0.0));
  ASSERT_FALSE(verdict);
  EXPECT_EQ(verdict.error().code, "noRouteError");
  EXPECT_THAT(verdict.error().message, HasSubstr("from node 'lo' to node 'rd'"));
  EXPECT_FALSE(book.active());
}

TEST(OrderOnAGraph, is_refused_where_the_vehicle_is_on_the_other_branch) {
  OrderBook book{diamond()};
  const auto verdict = book.offer(order("O-1").through({"F", "ro", "M"}), reference(diamond(), "l_up", 0.3));
  ASSERT_FALSE(verdict);
  EXPECT_EQ(verdict.error().code, "noRouteError");
}

TEST(OrderOnAGraph, is_continued_into_either_branch_from_a_base_that_ends_at_a_fork) {
  for (const auto& [node, section] : {std::pair{"ro", "r_up"}, std::pair{"lo", "l_up"}}) {
    OrderBook book{diamond()};
    ASSERT_TRUE(book.offer(order("O-1").through({"T", "T1", "F"}), reference(diamond(), "trunk", 0.0)));
    book.travelled(0.5);
    const auto verdict =
        book.offer(order("O-1", 1).from_sequence(4).through({"F", node}), reference(diamond(), "trunk", 0.5));
    ASSERT_TRUE(verdict) << to_string(verdict.error());
    EXPECT_EQ(remaining(book, diamond(), "trunk", 0.5).front(), section);
    EXPECT_NEAR(book.distance_to_base_end_m(), 1.5 + pi / 4.0, 1e-9);
  }
}

TEST(OrderOnAGraph, is_continued_into_either_branch_by_a_vehicle_stopped_at_the_fork) {
  for (const auto& [node, section] : {std::pair{"ro", "r_up"}, std::pair{"lo", "l_up"}}) {
    OrderBook book{diamond()};
    ASSERT_TRUE(book.offer(order("O-1").through({"T", "T1", "F"}), reference(diamond(), "trunk", 0.0)));
    EXPECT_EQ(book.travelled(1.99).size(), 2U) << "a vehicle has arrived at a node 15 mm before it";
    EXPECT_FALSE(book.active());
    const auto verdict =
        book.offer(order("O-1", 1).from_sequence(4).through({"F", node}), reference(diamond(), "trunk", 1.99));
    ASSERT_TRUE(verdict) << to_string(verdict.error());
    EXPECT_EQ(remaining(book, diamond(), "trunk", 1.99).front(), section);
    EXPECT_NEAR(book.distance_to_base_end_m(), 0.01 + pi / 4.0, 1e-9);
  }
}

TEST(OrderOnAGraph, keeps_the_route_of_its_horizon_in_the_course) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(order("O-1").through({"T", "T1"}).then({"F", "ro"}), reference(diamond(), "trunk", 0.2)));
  EXPECT_THAT(remaining(book, diamond(), "trunk", 0.2), ElementsAre("r_up", "r_over"));
}

TEST(OrderOnAGraph, follows_the_named_edge_where_two_edges_connect_the_same_nodes) {
  for (const auto& [edge, length_m] : {std::pair{"south", 1.0}, std::pair{"bow", pi / 3.0}}) {
    OrderBook book{square()};
    auto text = order("O-1").through({"D", "A", "B", "C"});
    text.edge(1).edge_id = edge;
    ASSERT_TRUE(book.offer(text, reference(square(), "west", 0.0)));
    EXPECT_THAT(remaining(book, square(), "west", 0.0), ElementsAre(edge, "east", "north"));
    EXPECT_NEAR(book.distance_to_base_end_m(), 2.0 + length_m, 1e-9);
  }
}

TEST(OrderOnAGraph, continues_after_a_jump_along_its_route_and_not_off_it) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(order("O-1").through({"T", "F", "ro", "M"}), reference(diamond(), "trunk", 0.0)));
  EXPECT_FALSE(book.relocate(at(diamond(), "l_over", 0.1)));
  ASSERT_TRUE(book.relocate(at(diamond(), "r_over", 0.1)));
  EXPECT_NEAR(book.travelled_m(), 2.0 + pi / 4.0 + 0.1, 1e-9);
  EXPECT_THAT(names(diamond(), book.course_from(at(diamond(), "r_over", 0.1)).traversed()),
              ElementsAre("trunk", "r_up"));
}

TEST(OrderOnAGraph, that_passes_a_section_twice_distinguishes_both_passes) {
  OrderBook book{square()};
  auto text = order("O-1").through({"A", "B", "C", "D", "A", "B", "S"});
  for (const std::size_t edge : {0U, 4U}) text.edge(edge).edge_id = "south";
  ASSERT_TRUE(book.offer(text, reference(square(), "south", 0.0)));
  EXPECT_THAT(remaining(book, square(), "south", 0.0), ElementsAre("east", "north", "west", "south", "spur"));
  book.travelled(4.2);
  EXPECT_THAT(remaining(book, square(), "south", 0.2), ElementsAre("spur"));
}

TEST(OrderOnAGraph, may_have_edges_of_hundreds_of_metres) {
  const auto zone = test::graph("long",
                                {{"there", {}, 400.0, 0.0, {1, 2}},
                                 {"on", {400.0, 0.0, 0.0}, 150.0, 0.0, {}},
                                 {"off", {400.0, 0.0, 0.0}, 150.0, 0.001, {}}},
                                {{"a", {0, 0.0}}, {"b", {1, 150.0}}, {"c", {2, 150.0}}});
  OrderBook book{zone};
  ASSERT_TRUE(book.offer(order("O-1").through({"a", "c"}), reference(zone, "there", 200.0)));
  EXPECT_NEAR(book.distance_to_base_end_m(), 350.0, 1e-9);
  EXPECT_THAT(remaining(book, zone, "there", 200.0), ElementsAre("off"));
}

TEST(OrderOnAGraph, finds_unknown_nodes_by_position_on_the_branch_that_continues) {
  OrderBook book{diamond()};
  auto text = order("O-1").through({"here", "there", "M"});
  text.node(0).position = wire::NodePosition{0.0, 0.0, {}, {}, {}, "diamond"};
  text.node(1).position = wire::NodePosition{2.0 + std::sqrt(2.0), -2.0 + std::sqrt(2.0), {}, {}, {}, "diamond"};
  ASSERT_TRUE(book.offer(text, reference(diamond(), "trunk", 0.0)));
  EXPECT_THAT(remaining(book, diamond(), "trunk", 0.0), ElementsAre("r_up", "r_over", "r_down", "tail"));
}

TEST(OrderOnAGraph, takes_no_course_on_a_loop_without_branches) {
  OrderBook book{test::lacet4()};
  ASSERT_TRUE(
      book.offer(order("O-1").through({"loop_se@0", "loop_se@283"}), reference(test::lacet4(), "loop_se", 0.0)));
  EXPECT_TRUE(book.course_from(at(test::lacet4(), "loop_se", 0.0)).empty());
}

TEST(CourseOfAnOrder, is_the_present_section_when_there_was_no_order) {
  const OrderBook book{diamond()};
  const zone::Course course = book.course_from(at(diamond(), "r_over", 0.1));
  EXPECT_EQ(course.here(), at(diamond(), "r_over", 0.0).section);
  EXPECT_THAT(course.remaining(), testing::IsEmpty());
}

TEST(OrderRouter, follows_an_edge_s_name_only_where_edges_are_sections) {
  auto right = order("O-1").through({"F", "M"});
  right.edge(0).edge_id = "r_up";
  EXPECT_EQ(OrderRouter{diamond()}.first_positions(right)->size(), 2U);
  zone::TrafficZone named = diamond();
  named.edges_are_sections = true;
  const OrderRouter router{named};
  EXPECT_EQ(*router.first_positions(right), std::vector<zone::TrackPosition>{at(named, "r_up", 0.0)});
  right.edge(0).edge_id = "no section";
  EXPECT_EQ(router.first_positions(right)->size(), 2U);
  right.edge(0).edge_id = "tail";  // a section that does not start at the node
  EXPECT_EQ(router.first_positions(right)->size(), 2U);
  EXPECT_EQ(router.first_positions(order("O-1").through({"F"}))->size(), 2U);
}

TEST(OrderRouter, finds_at_most_sixteen_sections_under_one_unknown_node) {
  std::vector<test::GraphPart> star;
  for (int i = 0; i < 20; ++i) {
    const Pose2 from_centre{0.0, 0.0, wrap_angle(0.3 * i)};
    star.push_back({"ray" + std::to_string(i), from_centre, 1.0, 0.0, {}});
  }
  const zone::TrafficZone zone = test::graph("star", star, {});
  wire::OrderNode node;
  node.node_id = "centre";
  node.position = wire::NodePosition{0.0, 0.0, {}, {}, {}, ""};
  const auto all = OrderRouter{zone}.positions_of(node);
  ASSERT_TRUE(all);
  EXPECT_EQ(all->size(), 16U);
  EXPECT_EQ(all->front().section, 0U);
  EXPECT_EQ(all->back().section, 15U);
}

TEST(OrderRouter, takes_the_sections_that_pass_an_unknown_node_within_five_centimetres_of_the_nearest_one) {
  const auto sections_at = [](double apart_m) {
    const zone::TrafficZone zone = test::graph(
        "lanes", {{"south", {0.0, 0.0, 0.0}, 2.0, 0.0, {}}, {"north", {0.0, apart_m, 0.0}, 2.0, 0.0, {}}}, {});
    wire::OrderNode node;
    node.node_id = "here";
    node.position = wire::NodePosition{1.0, -0.1, {}, {}, {}, ""};
    return OrderRouter{zone}.positions_of(node)->size();
  };
  EXPECT_EQ(sections_at(0.049), 2U);
  EXPECT_EQ(sections_at(0.051), 1U);
}

TEST(OrderRouter, keeps_an_unknown_node_s_direction_to_a_quarter_turn_exactly) {
  const auto found = [](double theta_rad) {
    wire::OrderNode node;
    node.node_id = "here";
    node.position = wire::NodePosition{1.0, 0.1, theta_rad, {}, {}, ""};
    return OrderRouter{diamond()}.positions_of(node).has_value();
  };
  EXPECT_TRUE(found(0.5 * pi));
  EXPECT_TRUE(found(-0.5 * pi));
  EXPECT_FALSE(found(1.0001 * 0.5 * pi));
}

TEST(OrderRouter, accepts_a_known_node_up_to_25_centimetres_from_its_stated_position) {
  wire::OrderNode node;
  node.node_id = "T1";
  node.position = wire::NodePosition{1.25, 0.0, {}, {}, {}, ""};
  EXPECT_TRUE(OrderRouter{diamond()}.positions_of(node));
  node.position->x_m = 1.2500001;
  EXPECT_FALSE(OrderRouter{diamond()}.positions_of(node));
}

}  // namespace
}  // namespace cosiva::aiv
