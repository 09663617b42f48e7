#include "cosiva/aiv/order/order_check.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "cosiva/aiv/testing/test_orders.h"

namespace cosiva::aiv {
namespace {

using test::order;
using test::OrderText;

constexpr double no_finite_number = std::numeric_limits<double>::infinity();

OrderText three_nodes() { return order("O-1").from_sequence(4).through({"a", "b"}).then({"c"}); }

wire::NodePosition at_two_metres() { return {2.0, 1.0, 0.5, 0.1, 0.2, "map"}; }

struct Fault {
  const char* location;
  const char* message;
  std::function<void(OrderText&)> spoil;
};

TEST(OrderShape, is_refused_with_the_field_and_the_reason) {
  const auto position = [](double wire::NodePosition::*field) {
    return [field](OrderText& o) {
      o.node(1).position = at_two_metres();
      *o.node(1).position.*field = std::numeric_limits<double>::quiet_NaN();
    };
  };
  const Fault faults[] = {
      {"orderId", "an order needs an id", [](OrderText& o) { o.order().order_id.clear(); }},
      {"nodes", "an order needs a node", [](OrderText& o) { o.order().nodes.clear(); }},
      {"edges", "3 edges for 3 nodes, expected one less than nodes",
       [](OrderText& o) { o.order().edges.push_back(o.edge(0)); }},
      {"edges", "1 edges for 3 nodes, expected one less than nodes", [](OrderText& o) { o.order().edges.pop_back(); }},
      {"nodes[0].sequenceId", "nodes have even numbers, this one has 5",
       [](OrderText& o) { o.node(0).sequence_id = 5; }},
      {"nodes[0].released", "the base has at least its first node", [](OrderText& o) { o.node(0).released = false; }},
      {"nodes[0].nodeId", "a node needs an id", [](OrderText& o) { o.node(0).node_id.clear(); }},
      {"nodes[2].nodeId", "a node needs an id", [](OrderText& o) { o.node(2).node_id.clear(); }},
      {"nodes[1].sequenceId", "sequenceId 8, expected 6: numbers run without gap over nodes and edges",
       [](OrderText& o) { o.node(1).sequence_id = 8; }},
      {"nodes[2].sequenceId", "sequenceId 7, expected 8: numbers run without gap over nodes and edges",
       [](OrderText& o) { o.node(2).sequence_id = 7; }},
      {"nodes[2].released", "released after a node that is not",
       [](OrderText& o) {
         o.node(1).released = false;
         o.node(2).released = true;
       }},
      {"nodes[1].nodePosition", "a position that is no number", position(&wire::NodePosition::x_m)},
      {"nodes[1].nodePosition", "a position that is no number", position(&wire::NodePosition::y_m)},
      {"nodes[1].nodePosition", "a position that is no number",
       [](OrderText& o) {
         o.node(1).position = at_two_metres();
         o.node(1).position->theta_rad = no_finite_number;
       }},
      {"nodes[1].nodePosition", "a position that is no number",
       [](OrderText& o) {
         o.node(1).position = at_two_metres();
         o.node(1).position->allowed_deviation_xy_m = no_finite_number;
       }},
      {"nodes[1].nodePosition.allowedDeviationXY", "a deviation is not negative",
       [](OrderText& o) {
         o.node(1).position = at_two_metres();
         o.node(1).position->allowed_deviation_xy_m = -0.001;
       }},
      {"edges[1].edgeId", "an edge needs an id", [](OrderText& o) { o.edge(1).edge_id.clear(); }},
      {"edges[1].sequenceId", "sequenceId 8, expected 7: numbers run without gap over nodes and edges",
       [](OrderText& o) { o.edge(1).sequence_id = 8; }},
      {"edges[0].startNodeId", "starts at 'x', the node before it is 'a'",
       [](OrderText& o) { o.edge(0).start_node_id = "x"; }},
      {"edges[0].endNodeId", "ends at 'x', the node after it is 'b'",
       [](OrderText& o) { o.edge(0).end_node_id = "x"; }},
      {"edges[0].released", "an edge is released exactly when the node it leads to is",
       [](OrderText& o) { o.edge(0).released = false; }},
      {"edges[1].released", "an edge is released exactly when the node it leads to is",
       [](OrderText& o) { o.edge(1).released = true; }},
      {"edges[0].maxSpeed", "a speed limit is positive", [](OrderText& o) { o.edge(0).max_speed_mps = 0.0; }},
      {"edges[0].maxSpeed", "a speed limit is positive", [](OrderText& o) { o.edge(0).max_speed_mps = -0.1; }},
      {"edges[1].maxSpeed", "a speed limit is positive",
       [](OrderText& o) { o.edge(1).max_speed_mps = no_finite_number; }},
  };
  for (const Fault& fault : faults) {
    OrderText text = three_nodes();
    fault.spoil(text);
    const auto checked = check_shape(text);
    ASSERT_FALSE(checked) << fault.location << ": " << fault.message;
    EXPECT_EQ(checked.error(), (Error{"validationError", fault.message, fault.location}));
  }
}

TEST(OrderShape, with_all_that_is_permitted_is_accepted) {
  EXPECT_TRUE(check_shape(three_nodes()));
  EXPECT_TRUE(check_shape(order("O-1").through({"a"})));
  OrderText text = three_nodes();
  text.node(0).position = at_two_metres();
  text.node(1).position = wire::NodePosition{2.0, 1.0, {}, {}, {}, ""};
  text.node(2).position = wire::NodePosition{2.0, 1.0, {}, 0.0, {}, ""};
  text.edge(0).max_speed_mps = 0.001;
  EXPECT_TRUE(check_shape(text));
}

TEST(OrderShape, par_6_6_6_requires_that_an_action_id_occurs_once) {
  OrderText text = three_nodes();
  text.node(0).actions = {{"noop", "1", "", wire::BlockingType::none, {}}};
  text.edge(1).actions = {{"noop", "2", "", wire::BlockingType::none, {}}};
  EXPECT_TRUE(check_shape(text));
  text.edge(1).actions[0].action_id = "1";
  const auto refused = check_shape(text);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error(), (Error{"validationError", "an actionId occurs twice", "edges[1].actions"}));
}

TEST(OrderAbilities, name_the_first_field_or_action_that_the_vehicle_does_not_support) {
  const ActionCatalogue supported = usual_actions();
  const auto action = [](const char* type, const char* id) {
    return wire::Action{type, id, "", wire::BlockingType::hard, {}};
  };
  OrderText text = three_nodes();
  text.node(0).actions = {action("pick", "1")};
  text.node(2).actions = {action("drop", "2"), action("pick", "3")};
  text.edge(1).actions = {action("drop", "4")};
  EXPECT_TRUE(check_abilities(text, supported));
  const auto refused = check_abilities(text, {});
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error(), (Error{"orderError", "action 'drop' (4) is not supported", "edges[1].actions"}));

  OrderText at_node = text;
  at_node.node(2).actions.push_back(action("honk", "5"));
  const auto no_honking = check_abilities(at_node, supported);
  ASSERT_FALSE(no_honking);
  EXPECT_EQ(no_honking.error(), (Error{"orderError", "action 'honk' (5) is not supported", "nodes[2].actions"}));

  OrderText field = text;
  field.edge(1).unsupported = {"trajectory", "corridor"};
  const auto no_trajectory = check_abilities(field, supported);
  ASSERT_FALSE(no_trajectory);
  EXPECT_EQ(no_trajectory.error(), (Error{"orderError", "'trajectory' is not supported", "edges[1].trajectory"}));
}

TEST(OrderOrientation, is_that_of_the_zone_s_vehicles_or_open) {
  OrderText text = three_nodes();
  EXPECT_TRUE(check_orientation(text, false));
  EXPECT_TRUE(check_orientation(text, true));
  text.edge(1).backwards = true;
  EXPECT_TRUE(check_orientation(text, true));
  const auto refused = check_orientation(text, false);
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error(), (Error{"orderError", "on this map vehicles drive forwards, with an orientation of 0",
                                    "edges[1].orientation"}));
  text.edge(1).backwards = false;
  EXPECT_TRUE(check_orientation(text, false));
  EXPECT_FALSE(check_orientation(text, true));
}

}  // namespace
}  // namespace cosiva::aiv
