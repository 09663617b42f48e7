#include "cosiva/aiv/decision/order_progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::order;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr double edge_m = 0.282743338823;

/// An order of three nodes 0.28 m apart, accepted on the first of them.
struct Progress : OrderProgress {
  Progress() : OrderProgress{lacet4()} {
    EXPECT_TRUE(offer(order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565"}), start()));
  }
  static OrderBook::StartState start() { return {at(lacet4(), "loop_se", 0.0), true}; }
  std::vector<std::string> traversed() {
    std::vector<std::string> ids;
    for (const wire::OrderNode& node : take_traversed()) ids.push_back(node.node_id);
    return ids;
  }
};

TEST(OrderProgress, collects_traversed_nodes_until_they_are_taken) {
  Progress progress;
  progress.advance(0.0);
  progress.advance(0.30);
  progress.advance(0.30);
  EXPECT_THAT(progress.traversed(), ElementsAre("loop_se@283", "loop_se@565")) << "the first node was passed already";
  EXPECT_THAT(progress.traversed(), IsEmpty());
}

TEST(OrderProgress, accepts_no_order_while_a_cancellation_is_pending) {
  Progress progress;
  ASSERT_TRUE(progress.begin_cancel());
  const auto refused = progress.offer(order("O-2").through({"loop_se@0", "loop_se@283"}), Progress::start());
  ASSERT_FALSE(refused);
  EXPECT_EQ(refused.error().code, "orderUpdateError");
  EXPECT_TRUE(progress.book().active()) << "the order is dropped only when the vehicle has stopped";
  progress.end_cancel();
  EXPECT_FALSE(progress.book().active());
  EXPECT_FALSE(progress.cancelling());
  EXPECT_TRUE(progress.offer(order("O-2").through({"loop_se@0", "loop_se@283"}), Progress::start()));
}

TEST(OrderProgress, has_nothing_to_cancel_without_an_order) {
  OrderProgress progress{lacet4()};
  EXPECT_FALSE(progress.begin_cancel());
  EXPECT_FALSE(progress.cancelling());
}

TEST(OrderProgress, cancels_once_when_requested_twice) {
  Progress progress;
  EXPECT_TRUE(progress.begin_cancel());
  EXPECT_TRUE(progress.begin_cancel());
}

TEST(OrderProgress, continues_from_another_position_of_its_order) {
  Progress progress;
  const zone::TrackPosition further = at(lacet4(), "loop_se", 0.40);
  EXPECT_TRUE(progress.relocate(&further));
  EXPECT_FALSE(progress.take_lost());
  EXPECT_TRUE(progress.book().active());
}

TEST(OrderProgress, is_lost_once_where_the_position_is_not_on_the_order) {
  Progress progress;
  const zone::TrackPosition elsewhere = at(lacet4(), "east", 0.1);
  EXPECT_FALSE(progress.relocate(&elsewhere));
  EXPECT_FALSE(progress.book().active());
  EXPECT_TRUE(progress.take_lost());
  EXPECT_FALSE(progress.take_lost());
  EXPECT_FALSE(progress.relocate(&elsewhere)) << "without an order";
  EXPECT_FALSE(progress.take_lost());
}

TEST(OrderProgress, is_lost_where_the_position_is_unknown) {
  Progress progress;
  EXPECT_FALSE(progress.relocate(nullptr));
  EXPECT_TRUE(progress.take_lost());
}

TEST(OrderProgressDeathTest, ends_no_cancellation_that_has_not_begun) {
  Progress progress;
  EXPECT_DEATH(progress.end_cancel(), "cancelling_");
}

TEST(OrderProgress, counts_the_rest_of_a_move_from_its_beginning) {
  Progress progress;
  progress.advance(0.10);
  EXPECT_FALSE(progress.moving());
  progress.begin_move(0.25);
  EXPECT_DOUBLE_EQ(progress.move_left_m(), 0.25);
  progress.advance(0.30);
  EXPECT_NEAR(progress.move_left_m(), -0.05, 1e-12);
  EXPECT_TRUE(progress.moving()) << "reached, and still in force";
  progress.end_move();
  progress.advance(0.10);
  EXPECT_FALSE(progress.moving());
}

// --- stops for actions --------------------------------------------------------------------------------------------

std::vector<wire::Action> action_of(wire::BlockingType blocking) { return {{"noop", "1", "", blocking, {}}}; }

struct StopsForActions : ::testing::Test {
  OrderProgress progress{lacet4(), usual_actions()};
  test::OrderText text{order("O-1").through({"loop_se@0", "loop_se@283", "loop_se@565", "loop_se@848"})};

  [[nodiscard]] bool accepts(const wire::Order& offered, double at_m = 0.0) {
    return progress.offer(offered, {at(lacet4(), "loop_se", at_m), true}).has_value();
  }
};

TEST_F(StopsForActions, are_nodes_with_soft_or_hard_actions_on_the_base) {
  text.node(1).actions = action_of(wire::BlockingType::none);
  text.node(2).actions = action_of(wire::BlockingType::soft);
  text.node(2).actions[0].action_id = "2";
  ASSERT_TRUE(accepts(text));
  EXPECT_FALSE(progress.at_stop());
  EXPECT_NEAR(progress.stop_left_m(), 2.0 * edge_m, 1e-9);
  progress.advance(edge_m);
  EXPECT_NEAR(progress.stop_left_m(), edge_m, 1e-9);
  progress.advance(edge_m - 0.016);
  EXPECT_FALSE(progress.at_stop());
  progress.advance(0.002);
  EXPECT_TRUE(progress.at_stop()) << "a vehicle that stops is as often just before the node as just behind";
  EXPECT_NEAR(progress.stop_left_m(), 0.014, 1e-9) << "it still drives the last millimetres";
  EXPECT_EQ(progress.take_traversed().size(), 2U);
  progress.end_stop();
  EXPECT_FALSE(progress.at_stop());
  EXPECT_TRUE(std::isinf(progress.stop_left_m()));
}

TEST_F(StopsForActions, are_starts_of_edges_with_soft_or_hard_actions) {
  text.edge(1).actions = action_of(wire::BlockingType::hard);
  ASSERT_TRUE(accepts(text));
  EXPECT_NEAR(progress.stop_left_m(), edge_m, 1e-9);
}

TEST_F(StopsForActions, begin_at_once_at_the_first_node_and_edge) {
  for (const bool at_node : {true, false}) {
    OrderProgress at_first{lacet4(), usual_actions()};
    test::OrderText of = order("O-1").through({"loop_se@0", "loop_se@283"});
    (at_node ? of.node(0).actions : of.edge(0).actions) = action_of(wire::BlockingType::hard);
    ASSERT_TRUE(at_first.offer(of, Progress::start()));
    EXPECT_TRUE(at_first.at_stop());
    EXPECT_EQ(at_first.stop_left_m(), 0.0);
    at_first.end_stop();
    EXPECT_TRUE(std::isinf(at_first.stop_left_m()));
  }
}

TEST_F(StopsForActions, of_an_update_count_where_the_vehicle_still_arrives_at_the_end_of_its_base) {
  ASSERT_TRUE(accepts(text));
  progress.advance(3.0 * edge_m - 0.01);
  ASSERT_FALSE(progress.book().base_left());
  test::OrderText update = order("O-1", 1).from_sequence(6).through({"loop_se@848", "loop_se@1131"});
  update.edge(0).actions = action_of(wire::BlockingType::soft);
  ASSERT_TRUE(accepts(update, 3.0 * edge_m - 0.01));
  EXPECT_TRUE(progress.at_stop());
  EXPECT_NEAR(progress.stop_left_m(), 0.01, 1e-9);
}

TEST_F(StopsForActions, of_the_horizon_count_only_when_they_are_released) {
  test::OrderText announced = order("O-1").through({"loop_se@0", "loop_se@283"}).then({"loop_se@565"});
  announced.edge(1).actions = action_of(wire::BlockingType::hard);
  announced.node(2).actions = action_of(wire::BlockingType::hard);
  announced.node(2).actions[0].action_id = "2";
  ASSERT_TRUE(accepts(announced));
  EXPECT_TRUE(std::isinf(progress.stop_left_m()));
  test::OrderText update = order("O-1", 1).from_sequence(2).through({"loop_se@283", "loop_se@565"});
  update.node(1).actions = action_of(wire::BlockingType::hard);
  ASSERT_TRUE(accepts(update));
  EXPECT_NEAR(progress.stop_left_m(), 2.0 * edge_m, 1e-9) << "the edge of the update has no action";
}

TEST_F(StopsForActions, end_with_the_order) {
  text.node(1).actions = action_of(wire::BlockingType::hard);
  ASSERT_TRUE(accepts(text));
  ASSERT_TRUE(progress.begin_cancel());
  progress.end_cancel();
  EXPECT_TRUE(std::isinf(progress.stop_left_m()));
  EXPECT_FALSE(progress.begin_cancel());
  EXPECT_TRUE(progress.begin_cancel(true)) << "actions of the order are left";
}

}  // namespace
}  // namespace cosiva::aiv
