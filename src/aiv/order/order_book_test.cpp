#include "cosiva/aiv/order/order_book.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <functional>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::order;
using test::OrderText;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using Verdict = OrderBook::Verdict;

/// Nodes of the loop in the south-east, 0.2827 m apart.
constexpr double edge_m = 0.282743338823;

OrderBook::StartState reference(std::string_view section, double s_m) { return {at(lacet4(), section, s_m), true}; }
const OrderBook::StartState start = reference("loop_se", 0.0);

std::vector<std::string> ids(const std::vector<wire::OrderNode>& nodes) {
  std::vector<std::string> names;
  for (const auto& node : nodes) names.push_back(node.node_id);
  return names;
}
std::vector<std::string> left(const OrderBook& book) {
  std::vector<std::string> names;
  for (const auto& state : book.node_states()) names.push_back(state.node_id + (state.released ? "" : "?"));
  return names;
}

/// Base of two nodes, one more announced.
OrderText usual() { return order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565"}).then({"loop_se@848"}); }

struct Book : OrderBook {
  Book() : OrderBook{lacet4()} {}
  std::string refusal(const wire::Order& order_, const StartState& where = start) {
    auto verdict = offer(order_, where);
    return verdict ? "accepted" : verdict.error().code;
  }
};

// --- a new order --------------------------------------------------------------------------------------------------

TEST(NewOrder, is_accepted_and_its_first_node_is_the_last_node) {
  Book book;
  EXPECT_FALSE(book.active());
  EXPECT_EQ(book.offer(usual(), start), Verdict::accepted_new);
  EXPECT_TRUE(book.active());
  EXPECT_EQ(book.ids().order_id, "O-1");
  EXPECT_EQ(book.last_node().node_id, "loop_se@0");
  EXPECT_EQ(book.last_node().sequence_id, 0U);
  EXPECT_THAT(left(book), ElementsAre("loop_se@283", "loop_se@565", "loop_se@848?"));
  EXPECT_EQ(book.edge_states().size(), 3U);
  EXPECT_EQ(book.edge_states().front().edge_id, "loop_se@0-loop_se@283");
  EXPECT_NEAR(book.distance_to_base_end_m(), 2.0 * edge_m, 1e-9);
  EXPECT_TRUE(book.base_left());
  EXPECT_TRUE(book.horizon_left());
}

TEST(NewOrder, of_one_node_and_no_edge_is_valid_and_finished_at_once) {
  Book book;
  EXPECT_EQ(book.offer(order("O-1").through({"loop_se@0"}), start), Verdict::accepted_new);
  EXPECT_FALSE(book.active());
  EXPECT_EQ(book.last_node().node_id, "loop_se@0");
  EXPECT_EQ(book.distance_to_base_end_m(), 0.0);
}

TEST(NewOrder, needs_a_known_position) {
  Book book;
  EXPECT_EQ(book.refusal(usual(), {start.position, false}), "noRouteError");
}

TEST(NewOrder, is_refused_while_the_present_order_has_base_or_horizon_left) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  EXPECT_EQ(book.refusal(order("O-2").through({"loop_se@0"})), "orderUpdateError");
  book.travelled(2.0 * edge_m);
  EXPECT_FALSE(book.base_left());
  EXPECT_EQ(book.refusal(order("O-2").through({"loop_se@565"}), reference("loop_se", 2.0 * edge_m)),
            "orderUpdateError");
  EXPECT_EQ(book.ids().order_id, "O-1");
}

TEST(NewOrder, is_accepted_when_the_previous_order_is_finished) {
  Book book;
  ASSERT_TRUE(book.offer(order("O-1").through({"loop_se@0", "loop_se@283"}), start));
  book.travelled(edge_m);
  EXPECT_FALSE(book.active());
  EXPECT_EQ(book.offer(order("O-2", 7).through({"loop_se@283", "loop_se@565"}), reference("loop_se", edge_m)),
            Verdict::accepted_new);
  EXPECT_EQ(book.ids().order_update_id, 7U);
}

TEST(FirstNode, may_lie_on_the_edge_behind_the_vehicle) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), reference("loop_se", 0.25)));
  EXPECT_NEAR(book.since_last_node_m(), 0.25, 1e-9);
  EXPECT_NEAR(book.distance_to_base_end_m(), 2.0 * edge_m - 0.25, 1e-9);
}

TEST(FirstNode, may_lie_a_little_in_front_of_the_vehicle) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), reference("east", 1.45)));
  EXPECT_NEAR(book.distance_to_base_end_m(), 2.0 * edge_m + 0.05, 1e-9);
  EXPECT_EQ(book.since_last_node_m(), 0.0);
}

TEST(FirstNode, may_lie_within_its_allowed_deviation) {
  auto wide = usual();
  wide.node(0).position = wire::NodePosition{0.75, -0.15, {}, 0.5, {}, "lacet4"};
  Book book;
  EXPECT_EQ(book.refusal(wide, reference("east", 1.1)), "accepted");
  EXPECT_EQ(Book{}.refusal(usual(), reference("east", 1.1)), "noRouteError");
  EXPECT_EQ(Book{}.refusal(wide, reference("east", 0.9)), "noRouteError");
}

TEST(FirstNode, too_far_behind_is_refused) {
  EXPECT_EQ(Book{}.refusal(usual(), reference("loop_se", 0.5)), "noRouteError");
}

TEST(FirstNode, with_a_wide_deviation_lets_nodes_behind_the_vehicle_be_traversed_at_once) {
  auto wide = usual();
  wide.node(0).position = wire::NodePosition{0.75, -0.15, {}, 1.0, {}, ""};
  Book book;
  ASSERT_TRUE(book.offer(wide, reference("loop_se", 0.4)));
  EXPECT_THAT(ids(book.travelled(0.0)), ElementsAre("loop_se@283"));
}

// --- refusals and their error types -------------------------------------------------------------------------------

struct BadOrder {
  const char* what;
  const char* type;
  std::function<void(OrderText&)> spoil;
};
void PrintTo(const BadOrder& bad, std::ostream* out) { *out << bad.what; }

class BadOrders : public ::testing::TestWithParam<BadOrder> {};

TEST_P(BadOrders, are_refused_with_the_right_type_and_change_nothing) {
  auto bad = usual();
  GetParam().spoil(bad);
  Book book;
  EXPECT_EQ(book.refusal(bad), GetParam().type) << GetParam().what;
  EXPECT_EQ(book.ids().order_id, "");
  EXPECT_FALSE(book.active());

  ASSERT_TRUE(book.offer(order("O-0").through({"loop_se@0", "loop_se@283"}), start));
  book.travelled(edge_m);
  EXPECT_NE(book.refusal(bad, reference("loop_se", edge_m)), "accepted");
  EXPECT_EQ(book.ids().order_id, "O-0");
}

const BadOrder bad_orders[] = {
    {"no id", "validationError", [](OrderText& o) { o.order().order_id.clear(); }},
    {"no nodes", "validationError",
     [](OrderText& o) {
       o.order().nodes.clear();
       o.order().edges.clear();
     }},
    {"an edge too many", "validationError", [](OrderText& o) { o.order().edges.push_back(o.edge(0)); }},
    {"an edge too few", "validationError", [](OrderText& o) { o.order().edges.pop_back(); }},
    {"a gap in the nodes' numbers", "validationError", [](OrderText& o) { o.node(2).sequence_id = 6; }},
    {"a gap in the edges' numbers", "validationError", [](OrderText& o) { o.edge(1).sequence_id = 5; }},
    {"an odd first number", "validationError", [](OrderText& o) { o.node(0).sequence_id = 1; }},
    {"an unreleased first node", "validationError", [](OrderText& o) { o.node(0).released = false; }},
    {"a base behind a horizon", "validationError", [](OrderText& o) { o.node(1).released = false; }},
    {"an edge released without its end", "validationError", [](OrderText& o) { o.edge(2).released = true; }},
    {"an unreleased edge to a released node", "validationError", [](OrderText& o) { o.edge(1).released = false; }},
    {"an edge from elsewhere", "validationError", [](OrderText& o) { o.edge(1).start_node_id = "loop_se@848"; }},
    {"an edge to elsewhere", "validationError", [](OrderText& o) { o.edge(1).end_node_id = "loop_se@848"; }},
    {"an edge without id", "validationError", [](OrderText& o) { o.edge(1).edge_id.clear(); }},
    {"a node without id", "validationError", [](OrderText& o) { o.node(1).node_id.clear(); }},
    {"a speed limit of zero", "validationError", [](OrderText& o) { o.edge(1).max_speed_mps = 0.0; }},
    {"a negative deviation", "validationError",
     [](OrderText& o) { o.node(1).position = wire::NodePosition{1.022, -0.215, {}, -1.0, {}, ""}; }},
    {"an unknown node without position", "noRouteError",
     [](OrderText& o) { o.node(1).node_id = o.edge(0).end_node_id = o.edge(1).start_node_id = "moon"; }},
    {"an unknown node off the circuit", "noRouteError",
     [](OrderText& o) {
       o.node(1).node_id = o.edge(0).end_node_id = o.edge(1).start_node_id = "moon";
       o.node(1).position = wire::NodePosition{5.0, 5.0, {}, {}, {}, "lacet4"};
     }},
    {"another map", "noRouteError",
     [](OrderText& o) { o.node(1).position = wire::NodePosition{1.022, -0.215, {}, {}, {}, "attic"}; }},
    {"a known node at another position", "noRouteError",
     [](OrderText& o) { o.node(1).position = wire::NodePosition{0.0, 0.0, {}, {}, {}, "lacet4"}; }},
    {"an edge field that cannot be honoured", "orderError",
     [](OrderText& o) { o.edge(0).unsupported = {"trajectory"}; }},
    {"an unknown node action", "orderError",
     [](OrderText& o) {
       o.node(1).actions = {{"pick", "a1", "", wire::BlockingType::hard, {}}};
     }},
    {"an unknown edge action", "orderError",
     [](OrderText& o) {
       o.edge(0).actions = {{"honk", "a2", "", wire::BlockingType::none, {}}};
     }},
};
INSTANTIATE_TEST_SUITE_P(Of, BadOrders, ::testing::ValuesIn(bad_orders));

TEST(Refusals, name_the_field) {
  auto bad = usual();
  bad.edge(0).unsupported = {"trajectory"};
  Book book;
  const auto verdict = book.offer(bad, start);
  ASSERT_FALSE(verdict);
  EXPECT_THAT(verdict.error().message, HasSubstr("trajectory"));
  EXPECT_EQ(verdict.error().location, "edges[0].trajectory");
}

TEST(Actions, that_the_vehicle_supports_are_accepted) {
  OrderBook book{lacet4(), usual_actions()};
  auto with_action = usual();
  with_action.node(1).actions = {{"pick", "a1", "", wire::BlockingType::hard, {}}};
  EXPECT_TRUE(book.offer(with_action, start));
}

// --- nodes of third-party maps ------------------------------------------------------------------------------------

TEST(UnknownNodes, are_found_on_the_circuit_by_their_position) {
  Book book;
  auto foreign = order("F-1").through({"a", "b", "c"});
  // On the first straight, its crossing point with the lane south, and 10 cm off the straight.
  foreign.node(0).position = wire::NodePosition{-0.65, -0.15, {}, {}, {}, ""};
  foreign.node(1).position = wire::NodePosition{-0.15, -0.15, {}, {}, {}, "lacet4"};
  foreign.node(2).position = wire::NodePosition{0.50, -0.25, {}, {}, {}, "lacet4"};
  ASSERT_EQ(book.refusal(foreign, reference("east", 0.1)), "accepted");
  EXPECT_EQ(book.targets()[0].position.section, 0U) << "the section on which the order continues, not the crossing one";
  EXPECT_NEAR(book.targets()[0].path_m, 0.5, 1e-9);
  EXPECT_NEAR(book.targets()[1].path_m, 1.15, 1e-9);
}

TEST(UnknownNodes, with_opposite_heading_are_not_on_the_circuit) {
  auto foreign = order("F-1").through({"a"});
  foreign.node(0).position = wire::NodePosition{-0.65, -0.15, 3.1, {}, {}, ""};
  EXPECT_EQ(Book{}.refusal(foreign, reference("east", 0.1)), "noRouteError");
}

TEST(UnknownNodes, as_first_node_may_lie_behind_the_vehicle) {
  Book book;
  auto foreign = order("F-1").through({"a", "b"});
  foreign.node(0).position = wire::NodePosition{-0.25, -0.15, {}, 0.5, {}, ""};
  foreign.node(1).position = wire::NodePosition{0.25, -0.15, {}, {}, {}, ""};
  ASSERT_EQ(book.refusal(foreign, reference("east", 0.6)), "accepted");
  EXPECT_NEAR(book.since_last_node_m(), 0.1, 1e-9);
  EXPECT_NEAR(book.distance_to_base_end_m(), 0.4, 1e-9);
}

// --- updates ------------------------------------------------------------------------------------------------------

OrderText extension(std::uint32_t update_id = 1) {
  return order("O-1", update_id).from_sequence(4).through({"loop_se@565", "loop_se@848", "loop_se@1131"});
}

TEST(Update, stitched_at_the_last_node_of_the_base_extends_it) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  book.travelled(0.1);
  EXPECT_EQ(book.offer(extension(), start), Verdict::accepted_update);
  EXPECT_THAT(left(book), ElementsAre("loop_se@283", "loop_se@565", "loop_se@848", "loop_se@1131"));
  EXPECT_NEAR(book.distance_to_base_end_m(), 4.0 * edge_m - 0.1, 1e-9);
  EXPECT_EQ(book.edge_states().size(), 4U);
}

TEST(Update, replaces_the_horizon) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  ASSERT_EQ(book.offer(order("O-1", 1).from_sequence(4).through({"loop_se@565"}).then({"loop_se@1131"}), start),
            Verdict::accepted_update);
  EXPECT_THAT(left(book), ElementsAre("loop_se@283", "loop_se@565", "loop_se@1131?"));
}

TEST(Update, may_delete_the_horizon) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  ASSERT_TRUE(book.offer(order("O-1", 1).from_sequence(4).through({"loop_se@565"}), start));
  EXPECT_FALSE(book.horizon_left());
}

TEST(Update, keeps_the_stitching_node_as_it_was_first_sent) {
  OrderBook book{lacet4(), usual_actions()};
  ASSERT_TRUE(book.offer(usual(), start));
  auto resent = extension();
  resent.node(0).actions = {{"pick", "a1", "", wire::BlockingType::none, {}}};
  ASSERT_TRUE(book.offer(resent, start));
  EXPECT_THAT(book.targets()[1].node.actions, IsEmpty());
}

TEST(Update, stitched_at_the_end_of_the_horizon_is_refused) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  EXPECT_EQ(book.refusal(order("O-1", 1).from_sequence(6).through({"loop_se@848", "loop_se@1131"})),
            "orderUpdateError");
}

TEST(Update, whose_first_node_has_another_number_is_refused) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  EXPECT_EQ(book.refusal(order("O-1", 1).from_sequence(6).through({"loop_se@565", "loop_se@848"})), "orderUpdateError");
}

TEST(Update, older_than_the_present_one_is_refused_and_the_order_continues) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  ASSERT_TRUE(book.offer(extension(5), start));
  EXPECT_EQ(book.refusal(extension(4)), "orderUpdateError");
  EXPECT_EQ(book.ids().order_update_id, 5U);
  EXPECT_TRUE(book.active());
}

TEST(Update, that_arrives_twice_is_accepted_once_and_then_ignored) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  ASSERT_TRUE(book.offer(extension(), start));
  book.travelled(3.5 * edge_m);
  EXPECT_EQ(book.offer(extension(), start), Verdict::ignored_same);
  EXPECT_THAT(left(book), ElementsAre("loop_se@1131"));
}

TEST(Update, of_a_finished_order_starts_at_its_last_node) {
  Book book;
  ASSERT_TRUE(book.offer(order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565"}), start));
  book.travelled(2.0 * edge_m - 0.004);
  EXPECT_FALSE(book.active());
  EXPECT_EQ(book.offer(extension(), reference("loop_se", 2.0 * edge_m - 0.004)), Verdict::accepted_update);
  EXPECT_NEAR(book.distance_to_base_end_m(), 2.0 * edge_m + 0.004, 1e-9);
}

TEST(Update, of_a_finished_order_is_refused_when_the_vehicle_was_moved_away) {
  Book book;
  ASSERT_TRUE(book.offer(order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565"}), start));
  book.travelled(2.0 * edge_m);
  EXPECT_EQ(book.refusal(extension(), reference("west", 0.3)), "noRouteError");
}

TEST(Update, of_a_cancelled_order_is_refused) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  book.cancel();
  EXPECT_EQ(book.refusal(order("O-1", 1).from_sequence(0).through({"loop_se@0", "loop_se@283"})), "orderUpdateError");
}

// --- driving ------------------------------------------------------------------------------------------------------

TEST(Traversal, takes_nodes_and_the_edges_before_them_out_of_the_states) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  EXPECT_THAT(ids(book.travelled(edge_m - 0.01)), IsEmpty()) << "a node on the route is traversed when passed";
  EXPECT_THAT(ids(book.travelled(0.01 + 1e-9)), ElementsAre("loop_se@283"));
  EXPECT_EQ(book.last_node().node_id, "loop_se@283");
  EXPECT_EQ(book.last_node().sequence_id, 2U);
  EXPECT_THAT(left(book), ElementsAre("loop_se@565", "loop_se@848?"));
  EXPECT_EQ(book.edge_states().front().edge_id, "loop_se@283-loop_se@565");
  EXPECT_NEAR(book.since_last_node_m(), 0.0, 1e-8);
}

TEST(Traversal, of_the_end_of_the_base_counts_15_mm_before) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  EXPECT_THAT(ids(book.travelled(2.0 * edge_m - 0.016)), ElementsAre("loop_se@283"));
  EXPECT_THAT(ids(book.travelled(0.002)), ElementsAre("loop_se@565"));
  EXPECT_NEAR(book.distance_to_base_end_m(), 0.014, 1e-9) << "the remaining distance may still be driven";
}

TEST(Traversal, never_goes_beyond_what_is_released) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  EXPECT_THAT(ids(book.travelled(5.0)), ElementsAre("loop_se@283", "loop_se@565"));
  EXPECT_THAT(left(book), ElementsAre("loop_se@848?"));
}

TEST(Traversal, may_pass_several_nodes_at_once_in_order) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  EXPECT_THAT(ids(book.travelled(2.0 * edge_m)), ElementsAre("loop_se@283", "loop_se@565"));
}

TEST(Cancel, keeps_the_ids_and_discards_the_rest) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  book.travelled(0.1);
  book.cancel();
  EXPECT_FALSE(book.active());
  EXPECT_EQ(book.distance_to_base_end_m(), 0.0);
  EXPECT_EQ(book.ids().order_id, "O-1");
  EXPECT_THAT(book.edge_states(), IsEmpty());
  EXPECT_EQ(book.refusal(order("O-2").through({"loop_se@0", "loop_se@283"}), reference("loop_se", 0.1)), "accepted");
}

TEST(Relocation, on_the_route_of_the_order_continues_from_there) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  EXPECT_TRUE(book.relocate(at(lacet4(), "loop_se", 0.4)));
  EXPECT_NEAR(book.distance_to_base_end_m(), 2.0 * edge_m - 0.4, 1e-9);
  EXPECT_TRUE(book.relocate(at(lacet4(), "east", 1.45)));
  EXPECT_NEAR(book.distance_to_base_end_m(), 2.0 * edge_m + 0.05, 1e-9);
}

TEST(Relocation, elsewhere_changes_nothing) {
  Book book;
  ASSERT_TRUE(book.offer(usual(), start));
  EXPECT_FALSE(book.relocate(at(lacet4(), "west", 0.4)));
  EXPECT_NEAR(book.distance_to_base_end_m(), 2.0 * edge_m, 1e-9);
}

TEST(RollingOrder, repeats_its_loop_in_bounded_space) {
  const auto& zone = lacet4();
  Book book;
  std::size_t waypoint = zone.waypoint_ahead(start.position);
  const auto name = [&] { return zone.waypoints[waypoint].id; };
  std::string first = name();
  waypoint = zone.next_waypoint(waypoint);
  ASSERT_TRUE(book.offer(order("R").through({first, name()}), start));
  std::uint32_t sequence = 2;
  for (std::uint32_t update = 1; update <= 500; ++update) {
    first = name();
    waypoint = zone.next_waypoint(waypoint);
    const auto rolled = order("R", update).from_sequence(sequence).through({first, name()});
    ASSERT_EQ(book.offer(rolled, start), Verdict::accepted_update) << update;
    sequence += 2;
    book.travelled(book.distance_to_base_end_m() - 0.1);
    ASSERT_LE(book.targets().size(), 2U);
  }
  EXPECT_GE(book.last_node().sequence_id, 998U);
}

}  // namespace
}  // namespace cosiva::aiv
