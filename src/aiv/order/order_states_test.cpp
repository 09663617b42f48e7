// What an order book states of its order, completely, and how far it tolerates differences.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include "cosiva/aiv/order/order_book.h"
#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_orders.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::diamond;
using test::order;

OrderBook::StartState on_the_trunk(double s_m) { return {at(diamond(), "trunk", s_m), true}; }

/// Nodes at 0, 1, 2 and 2 + π/4 m; the last is only announced.
wire::Order along_the_trunk() {
  auto text = order("O-7", 3).from_sequence(8).through({"T", "T1", "F"}).then({"ro"});
  text.order().zone_set_id = "set";
  text.edge(1).max_speed_mps = 0.25;
  text.node(1).position = wire::NodePosition{1.0, 0.0, {}, {}, {}, "diamond"};
  return text;
}

TEST(OrderStates, are_those_of_the_remaining_nodes_and_edges) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(along_the_trunk(), on_the_trunk(0.05)));
  EXPECT_EQ(book.ids().order_id, "O-7");
  EXPECT_EQ(book.ids().order_update_id, 3U);
  EXPECT_EQ(book.ids().zone_set_id, "set");
  EXPECT_EQ(book.last_node().sequence_id, 8U);
  EXPECT_EQ(book.last_node().position, at(diamond(), "trunk", 0.0));
  EXPECT_EQ(book.accepted_at(), at(diamond(), "trunk", 0.05));
  EXPECT_NEAR(book.travelled_m(), 0.05, 1e-12);
  EXPECT_NEAR(book.since_last_node_m(), 0.05, 1e-12);
  EXPECT_NEAR(book.distance_to_base_end_m(), 1.95, 1e-12);
  EXPECT_TRUE(book.base_left());
  EXPECT_TRUE(book.horizon_left());
  ASSERT_EQ(book.targets().size(), 3U);
  EXPECT_NEAR(book.targets()[0].path_m, 1.0, 1e-12);
  EXPECT_NEAR(book.targets()[1].path_m, 2.0, 1e-12);
  EXPECT_NEAR(book.targets()[2].path_m, 2.0 + pi / 4.0, 1e-12);
  EXPECT_FALSE(book.targets()[0].max_speed_mps);
  EXPECT_EQ(book.targets()[1].max_speed_mps, 0.25);
  const auto nodes = book.node_states();
  ASSERT_EQ(nodes.size(), 3U);
  EXPECT_EQ(nodes[0].node_id, "T1");
  EXPECT_EQ(nodes[0].sequence_id, 10U);
  EXPECT_TRUE(nodes[0].released);
  ASSERT_TRUE(nodes[0].position);
  EXPECT_EQ(nodes[0].position->x_m, 1.0);
  EXPECT_FALSE(nodes[1].position);
  EXPECT_FALSE(nodes[2].released);
  const auto edges = book.edge_states();
  ASSERT_EQ(edges.size(), 3U);
  EXPECT_EQ(edges[0].edge_id, "T-T1");
  EXPECT_EQ(edges[0].sequence_id, 9U);
  EXPECT_TRUE(edges[0].released);
  EXPECT_FALSE(edges[2].released);

  // One node further.
  EXPECT_TRUE(book.travelled(0.949).empty());
  const auto traversed = book.travelled(0.002);
  ASSERT_EQ(traversed.size(), 1U);
  EXPECT_EQ(traversed[0].sequence_id, 10U);
  EXPECT_EQ(book.last_node().node_id, "T1");
  EXPECT_EQ(book.last_node().sequence_id, 10U);
  EXPECT_EQ(book.last_node().position, at(diamond(), "trunk", 1.0));
  EXPECT_NEAR(book.last_node().path_m, 1.0, 1e-12);
  EXPECT_NEAR(book.since_last_node_m(), 0.001, 1e-9);
  EXPECT_EQ(book.node_states().size(), 2U);
  EXPECT_EQ(book.edge_states().front().edge_id, "T1-F");
  // The base ends 15 mm before its last node, and nothing beyond is traversed.
  EXPECT_TRUE(book.travelled(0.983).empty());
  EXPECT_EQ(book.travelled(0.002).size(), 1U);
  EXPECT_FALSE(book.base_left());
  EXPECT_TRUE(book.active());
  EXPECT_TRUE(book.travelled(2.0).empty());
  EXPECT_EQ(book.distance_to_base_end_m(), 0.0);
  book.cancel();
  EXPECT_FALSE(book.active());
  EXPECT_FALSE(book.horizon_left());
  EXPECT_TRUE(book.edge_states().empty());
  EXPECT_EQ(book.ids().order_id, "O-7");
}

TEST(OrderStates, of_a_backward_correction_do_not_bring_traversed_nodes_back) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(along_the_trunk(), on_the_trunk(0.0)));
  EXPECT_EQ(book.travelled(1.1).size(), 1U);
  EXPECT_TRUE(book.travelled(-0.3).empty());
  EXPECT_EQ(book.since_last_node_m(), 0.0);
  EXPECT_NEAR(book.distance_to_base_end_m(), 1.2, 1e-12);
  EXPECT_TRUE(book.travelled(0.25).empty());
}

TEST(OrderRelocation, counts_from_the_last_node_to_the_end_of_the_order_and_ten_centimetres_before_it) {
  struct Jump {
    const char* section;
    double s_m;
    bool on_order;
    double travelled_m;
  };
  for (const Jump& jump : {Jump{"trunk", 0.2, false, 0.0},
                           {"trunk", 0.89, false, 0.0},
                           {"trunk", 0.91, true, 0.91},
                           {"trunk", 1.6, true, 1.6},
                           {"r_up", 0.5, true, 2.5},
                           {"r_over", 0.0, true, 2.0 + pi / 4.0},
                           {"r_over", 0.1, false, 0.0},
                           {"l_up", 0.1, false, 0.0}}) {
    OrderBook book{diamond()};
    ASSERT_TRUE(book.offer(along_the_trunk(), on_the_trunk(0.0)));
    book.travelled(1.2);
    EXPECT_EQ(book.relocate(at(diamond(), jump.section, jump.s_m)), jump.on_order) << jump.section << jump.s_m;
    EXPECT_NEAR(book.travelled_m(), jump.on_order ? jump.travelled_m : 1.2, 1e-9) << jump.section << jump.s_m;
  }
  OrderBook idle{diamond()};
  EXPECT_TRUE(idle.relocate(at(diamond(), "tail", 1.0)));
}

TEST(OrderCourse, is_that_of_the_position_within_ten_centimetres_of_the_distance_travelled) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(along_the_trunk(), on_the_trunk(0.0)));
  book.travelled(0.5);
  const auto sections = [&](const char* section, double s_m) {
    const zone::Course course = book.course_from(at(diamond(), section, s_m));
    std::string text;
    for (const zone::SectionId id : course.remaining()) text += diamond().circuit.part(id).name + " ";
    return text;
  };
  EXPECT_EQ(sections("trunk", 0.59), "r_up r_over ");
  EXPECT_EQ(sections("trunk", 0.41), "r_up r_over ");
  EXPECT_EQ(sections("trunk", 0.61), "");
  EXPECT_EQ(sections("trunk", 0.39), "");
  EXPECT_EQ(sections("tail", 0.5), "");
}

TEST(OrderCourse, of_a_vehicle_before_the_first_node_leads_to_it) {
  OrderBook book{diamond()};
  auto text = order("O-1").through({"F", "ro"});
  text.node(0).position = wire::NodePosition{2.0, 0.0, {}, 0.5, {}, ""};
  ASSERT_TRUE(book.offer(text, on_the_trunk(1.6)));
  EXPECT_NEAR(book.travelled_m(), -0.4, 1e-9);
  EXPECT_EQ(book.since_last_node_m(), 0.0);
  EXPECT_NEAR(book.distance_to_base_end_m(), 0.4 + pi / 4.0, 1e-9);
  const zone::Course course = book.course_from(at(diamond(), "trunk", 1.6));
  ASSERT_EQ(course.remaining().size(), 2U);
  EXPECT_EQ(diamond().circuit.part(course.remaining()[0]).name, "r_up");
  EXPECT_EQ(diamond().circuit.part(course.remaining()[1]).name, "r_over");
  EXPECT_TRUE(book.course_from(at(diamond(), "trunk", 1.45)).remaining().empty()) << "too far before it";
}

TEST(OrderIds, of_another_zone_stay_without_their_order) {
  OrderBook before{diamond()};
  ASSERT_TRUE(before.offer(along_the_trunk(), on_the_trunk(0.0)));
  OrderBook book{diamond()};
  book.take_over_ids(before);
  EXPECT_EQ(book.ids().order_id, "O-7");
  EXPECT_FALSE(book.active());
  auto update = along_the_trunk();
  update.order_update_id = 4;
  const auto refused = book.offer(update, on_the_trunk(0.0));
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, "orderUpdateError");
  EXPECT_EQ(refused.error().message, "order 'O-7' was cancelled");
  EXPECT_EQ(book.offer(along_the_trunk(), on_the_trunk(0.0)), OrderBook::Verdict::ignored_same);
}

TEST(LastNode, is_given_only_to_a_vehicle_without_an_order_and_ends_the_order_before) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(order("O-1").from_sequence(2).through({"T"}), on_the_trunk(0.0)));
  book.set_last_node("T1");
  EXPECT_EQ(book.last_node().node_id, "T1");
  EXPECT_EQ(book.last_node().sequence_id, 0U);
  const auto update = book.offer(order("O-1", 1).through({"T1", "F"}), on_the_trunk(1.0));
  ASSERT_FALSE(update);
  EXPECT_EQ(update.error().message, "order 'O-1' was cancelled");
  ASSERT_TRUE(book.offer(order("O-2").through({"T1", "F"}), on_the_trunk(1.0)));
  book.set_last_node("M");
  EXPECT_EQ(book.last_node().node_id, "T1");
}

TEST(OrderRefusals, state_the_reason) {
  OrderBook book{diamond()};
  const auto message = [&](const wire::Order& text, const OrderBook::StartState& start) {
    const auto verdict = book.offer(text, start);
    return verdict ? std::string("accepted") : verdict.error().code + ": " + verdict.error().message;
  };
  EXPECT_EQ(message(along_the_trunk(), {{}, false}), "noRouteError: the vehicle's position is not known");
  EXPECT_EQ(message(along_the_trunk(), {at(diamond(), "tail", 1.0), true}),
            "noRouteError: node 'T' is not where the vehicle is: neither on it within 0.100000 m nor on the edge "
            "behind it");
  ASSERT_EQ(message(along_the_trunk(), on_the_trunk(0.0)), "accepted");
  EXPECT_EQ(message(order("O-8").through({"T", "T1"}), on_the_trunk(0.0)),
            "orderUpdateError: order 'O-7' is not finished: it has base left");
  EXPECT_EQ(message(order("O-7", 2).through({"T", "T1"}), on_the_trunk(0.0)),
            "orderUpdateError: update 2 is older than 3, which is being followed");
  EXPECT_EQ(message(order("O-7", 4).from_sequence(12).through({"T1", "F"}), on_the_trunk(0.0)),
            "orderUpdateError: the update starts at 'T1' (12), the base ends at 'F' (12)");
  EXPECT_EQ(message(order("O-7", 4).from_sequence(10).through({"F", "ro"}), on_the_trunk(0.0)),
            "orderUpdateError: the update starts at 'F' (10), the base ends at 'F' (12)");
  book.travelled(2.0);
  EXPECT_EQ(message(order("O-8").through({"F", "ro"}), on_the_trunk(2.0)),
            "orderUpdateError: order 'O-7' is not finished: it has horizon left");
}

TEST(FirstNode, is_reached_within_ten_centimetres_or_its_deviation_before_it_and_on_the_whole_edge_behind_it) {
  const auto accepted = [](double s_m, double deviation_m) {
    OrderBook book{diamond()};
    auto text = order("O-1").through({"T1", "F", "ro"});
    text.node(0).position = wire::NodePosition{1.0, 0.0, {}, deviation_m, {}, ""};
    return book.offer(text, on_the_trunk(s_m)).has_value();
  };
  EXPECT_FALSE(accepted(0.89, 0.0));
  EXPECT_TRUE(accepted(0.91, 0.0));
  EXPECT_TRUE(accepted(0.91, 0.05)) << "a smaller deviation has no effect";
  EXPECT_FALSE(accepted(0.69, 0.3));
  EXPECT_TRUE(accepted(0.71, 0.3));
  EXPECT_TRUE(accepted(1.99, 0.0));
  OrderBook alone{diamond()};
  EXPECT_FALSE(alone.offer(order("O-1").through({"T1"}), on_the_trunk(1.11)));
  EXPECT_TRUE(alone.offer(order("O-1").through({"T1"}), on_the_trunk(1.09)));
}

TEST(NodePosition, locates_an_unknown_node_within_25_centimetres_and_in_its_direction) {
  const auto refusal = [](double x_m, double y_m, std::optional<double> theta_rad, const char* map = "") {
    OrderBook book{diamond()};
    auto text = order("O-1").through({"T", "here"});
    text.node(1).position = wire::NodePosition{x_m, y_m, theta_rad, {}, {}, map};
    const auto verdict = book.offer(text, on_the_trunk(0.0));
    return verdict ? std::string{} : verdict.error().message;
  };
  EXPECT_EQ(refusal(1.5, 0.249, {}), "");
  EXPECT_EQ(refusal(1.5, -0.251, {}), "node 'here' does not lie on the circuit");
  EXPECT_EQ(refusal(1.5, 0.0, 1.57), "");
  EXPECT_EQ(refusal(1.5, 0.0, 1.58), "node 'here' does not lie on the circuit");
  EXPECT_EQ(refusal(1.5, 0.0, -1.58), "node 'here' does not lie on the circuit");
  EXPECT_EQ(refusal(1.5, 0.0, {}, "diamond"), "");
  EXPECT_EQ(refusal(1.5, 0.0, {}, "clover"), "node 'here' is on map 'clover', the vehicle on 'diamond'");
  OrderBook book{diamond()};
  EXPECT_EQ(book.offer(order("O-1").through({"T", "here"}), on_the_trunk(0.0)).error().message,
            "node 'here' is unknown here and has no nodePosition");
  auto moved = order("O-1").through({"T", "T1"});
  moved.node(1).position = wire::NodePosition{1.251, 0.0, {}, {}, {}, ""};
  EXPECT_EQ(book.offer(moved, on_the_trunk(0.0)).error().message, "node 'T1' does not lie at its nodePosition");
  moved.node(1).position->x_m = 1.249;
  EXPECT_TRUE(book.offer(moved, on_the_trunk(0.0)));
}

TEST(OrderStates, lose_a_node_on_the_route_exactly_where_it_lies) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(along_the_trunk(), on_the_trunk(0.0)));
  EXPECT_TRUE(book.travelled(0.999).empty());
  OrderBook exact{diamond()};
  ASSERT_TRUE(exact.offer(along_the_trunk(), on_the_trunk(0.0)));
  const auto traversed = exact.travelled(1.0);
  ASSERT_EQ(traversed.size(), 1U);
  EXPECT_EQ(traversed[0].node_id, "T1");
}

TEST(OrderCourse, is_that_of_a_position_exactly_ten_centimetres_off) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(along_the_trunk(), on_the_trunk(0.0)));
  EXPECT_EQ(book.course_from(at(diamond(), "trunk", 0.10)).remaining().size(), 2U);
}

TEST(OrderUpdate, without_a_base_left_starts_where_the_vehicle_is_and_counts_on) {
  OrderBook book{diamond()};
  ASSERT_TRUE(book.offer(order("O-1").through({"T", "T1"}), on_the_trunk(0.0)));
  EXPECT_EQ(book.travelled(0.99).size(), 1U);
  ASSERT_FALSE(book.active());
  // The vehicle was pushed on by 0.04 m.
  ASSERT_TRUE(book.offer(order("O-1", 1).from_sequence(2).through({"T1", "F"}), on_the_trunk(1.03)));
  EXPECT_NEAR(book.travelled_m(), 1.03, 1e-9);
  EXPECT_EQ(book.accepted_at(), at(diamond(), "trunk", 1.03));
  EXPECT_NEAR(book.distance_to_base_end_m(), 0.97, 1e-9);
  ASSERT_EQ(book.targets().size(), 1U);
  EXPECT_NEAR(book.targets()[0].path_m, 2.0, 1e-9);
}

}  // namespace
}  // namespace cosiva::aiv
