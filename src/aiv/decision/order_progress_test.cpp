#include "cosiva/aiv/decision/order_progress.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/aiv/testing/test_orders.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::order;
using ::testing::ElementsAre;
using ::testing::IsEmpty;

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

}  // namespace
}  // namespace cosiva::aiv
