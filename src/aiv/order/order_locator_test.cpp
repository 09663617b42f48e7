#include "cosiva/aiv/order/order_locator.h"

#include <gtest/gtest.h>

#include <vector>

#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_orders.h"

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

}  // namespace
}  // namespace cosiva::aiv
