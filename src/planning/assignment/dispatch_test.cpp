#include "cosiva/planning/assignment/dispatch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "cosiva/planning/floor/grid.h"

namespace cosiva::planning {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

Grid open_grid(std::uint32_t width, std::uint32_t height) {
  return {width, height, std::vector<std::uint8_t>(std::size_t{width} * height, 1)};
}

/// A dispatcher on a grid; goal q is square q.
struct Site {
  Floor floor;
  Distances distances{floor};
  DispatchOptions options;
  Dispatch dispatch{floor, distances, options, 1};

  explicit Site(const Grid& grid, GridMotion motion = GridMotion::any_direction, DispatchOptions with = {})
      : floor{grid_floor(grid, motion)}, options{with} {}
};

OpenOrder order(std::uint64_t id, GoalId from, GoalId to) { return {id, {from, 0}, {to, 0}}; }
Carrier at(StateId state) { return {state, {}}; }

TEST(Dispatch, gives_an_order_to_the_nearest_vehicle) {
  Site site{open_grid(10, 1)};
  site.dispatch.plan(std::vector{at(0), at(6), at(9)}, std::vector{order(1, 4, 2)});
  EXPECT_EQ(site.dispatch.next(0), Dispatch::none);
  EXPECT_EQ(site.dispatch.next(1), 0U);
  EXPECT_EQ(site.dispatch.busy_for(1), 4U);
  EXPECT_EQ(site.dispatch.busy_for(2), 0U);
}

TEST(Dispatch, considers_when_a_busy_vehicle_becomes_free) {
  Site site{open_grid(10, 1)};
  // Vehicle 0 is free in square 4 after one move, and a stay of one step.
  const std::vector<Carrier> carriers{{3, {{4, 1}}}, at(9)};
  site.dispatch.plan(carriers, std::vector{order(1, 5, 6)});
  EXPECT_EQ(site.dispatch.next(0), 0U);
  EXPECT_EQ(site.dispatch.busy_for(0), 1U + 1U + 1U + 1U);
  const std::vector<Carrier> later{{3, {{4, 9}}}, at(9)};
  site.dispatch.plan(later, std::vector{order(1, 5, 6)});
  EXPECT_EQ(site.dispatch.next(1), 0U);
}

TEST(Dispatch, minimises_the_sum_and_not_the_first_choice) {
  Site site{open_grid(10, 1)};
  // Both vehicles are nearest to order 0; vehicle 1 is the only one near order 1.
  site.dispatch.plan(std::vector{at(2), at(5)}, std::vector{order(10, 4, 3), order(11, 7, 8)});
  EXPECT_EQ(site.dispatch.next(0), 0U);
  EXPECT_EQ(site.dispatch.next(1), 1U);
}

TEST(Dispatch, hands_an_order_on_to_a_vehicle_that_becomes_nearer) {
  Site site{open_grid(10, 1)};
  site.dispatch.plan(std::vector{at(0), at(9)}, std::vector{order(1, 4, 5)});
  EXPECT_EQ(site.dispatch.next(0), 0U);
  site.dispatch.plan(std::vector{at(0), at(5)}, std::vector{order(1, 4, 5)});
  EXPECT_EQ(site.dispatch.next(1), 0U);
  EXPECT_EQ(site.dispatch.next(0), Dispatch::none);
}

TEST(Dispatch, plans_tours_where_there_are_more_orders_than_vehicles) {
  Site site{open_grid(10, 1)};
  site.dispatch.plan(std::vector{at(0)}, std::vector{order(1, 5, 6), order(2, 2, 4), order(3, 7, 9)});
  EXPECT_THAT(site.dispatch.tour(0), ElementsAre(1, 0, 2));
  EXPECT_EQ(site.dispatch.busy_for(0), 9U);
}

TEST(Dispatch, prefers_orders_of_higher_priority) {
  Site site{open_grid(10, 1)};
  std::vector<OpenOrder> orders{order(1, 2, 0), order(2, 7, 9)};
  site.dispatch.plan(std::vector{at(4)}, orders);
  EXPECT_EQ(site.dispatch.next(0), 0U);
  orders[1].priority = 1;
  site.dispatch.plan(std::vector{at(4)}, orders);
  EXPECT_EQ(site.dispatch.next(0), 1U);
}

TEST(Dispatch, considers_only_so_many_orders_the_oldest_first) {
  Site site{open_grid(10, 1), GridMotion::any_direction, {.orders_max = 1}};
  std::vector<OpenOrder> orders{order(1, 1, 2), order(2, 8, 7)};
  orders[1].age = 5;
  site.dispatch.plan(std::vector{at(0)}, orders);
  EXPECT_THAT(site.dispatch.tour(0), ElementsAre(1));
}

TEST(Dispatch, gives_no_orders_to_vehicles_that_are_not_available) {
  Site site{open_grid(10, 1)};
  std::vector<Carrier> carriers{at(0), at(9)};
  site.dispatch.plan(carriers, std::vector{order(1, 1, 2)});
  EXPECT_EQ(site.dispatch.next(0), 0U);
  carriers[0].available = false;
  site.dispatch.plan(carriers, std::vector{order(1, 1, 2)});
  EXPECT_THAT(site.dispatch.tour(0), IsEmpty());
  EXPECT_EQ(site.dispatch.next(1), 0U);
}

TEST(Dispatch, leaves_orders_that_no_vehicle_can_carry) {
  Grid grid = open_grid(10, 1);
  grid.free[5] = 0;
  Site site{grid};
  // To another component; in another component; and one that can be carried.
  site.dispatch.plan(std::vector{at(0)}, std::vector{order(1, 1, 7), order(2, 6, 7), order(3, 2, 3)});
  EXPECT_THAT(site.dispatch.tour(0), ElementsAre(2));
}

TEST(Dispatch, of_an_empty_fleet_or_without_orders_does_nothing) {
  Site site{open_grid(4, 1)};
  site.dispatch.plan({}, std::vector{order(1, 1, 2)});
  site.dispatch.plan(std::vector{at(0)}, {});
  EXPECT_THAT(site.dispatch.tour(0), IsEmpty());
}

TEST(Dispatch, drops_orders_that_are_not_open_any_more) {
  Site site{open_grid(10, 1)};
  site.dispatch.plan(std::vector{at(0)}, std::vector{order(1, 1, 2), order(2, 3, 4)});
  site.dispatch.plan(std::vector{at(0)}, std::vector{order(2, 3, 4)});
  EXPECT_THAT(site.dispatch.tour(0), ElementsAre(0));
}

/// Cost of tours on an empty grid, by its definition: per order its waiting, per vehicle the square of its end.
class AllTours {
 public:
  AllTours(Site& site, std::vector<Carrier> carriers, std::vector<OpenOrder> orders)
      : site_{&site}, carriers_{std::move(carriers)}, orders_{std::move(orders)}, tours_(carriers_.size()) {}

  [[nodiscard]] std::uint64_t cost(const std::vector<std::vector<std::size_t>>& tours) {
    std::uint64_t sum = 0;
    for (std::size_t carrier = 0; carrier < tours.size(); ++carrier) {
      std::uint64_t end = 0;
      StateId at = carriers_[carrier].at;
      for (const std::size_t index : tours[carrier]) {
        const OpenOrder& order = orders_[index];
        end += site_->distances.to(order.pick_up.goal)[at];
        sum += site_->options.waiting_cost * end;
        at = order.delivery.goal;
        end += order.pick_up.stay + site_->distances.to(at)[order.pick_up.goal] + order.delivery.stay;
      }
      sum += end * end;
    }
    return sum;
  }
  /// The least cost of all tours.
  [[nodiscard]] std::uint64_t least() {
    least_ = ~std::uint64_t{0};
    extend(0);
    return least_;
  }

 private:
  void extend(std::size_t order) {
    if (order == orders_.size()) {
      least_ = std::min(least_, cost(tours_));
      return;
    }
    for (auto& tour : tours_) {
      for (std::size_t index = 0; index <= tour.size(); ++index) {
        tour.insert(tour.begin() + static_cast<std::ptrdiff_t>(index), order);
        extend(order + 1);
        tour.erase(tour.begin() + static_cast<std::ptrdiff_t>(index));
      }
    }
  }

  Site* site_;
  std::vector<Carrier> carriers_;
  std::vector<OpenOrder> orders_;
  std::vector<std::vector<std::size_t>> tours_;
  std::uint64_t least_{};
};

struct Case {
  std::vector<Carrier> carriers;
  std::vector<OpenOrder> orders;
};

Case random_case(Random& random, std::size_t carriers, std::size_t orders, std::uint64_t squares) {
  Case made;
  for (std::size_t i = 0; i < carriers; ++i) made.carriers.push_back(at(static_cast<StateId>(random.below(squares))));
  for (std::size_t i = 0; i < orders; ++i)
    made.orders.push_back({i,
                           {static_cast<GoalId>(random.below(squares)), static_cast<std::uint32_t>(random.below(3))},
                           {static_cast<GoalId>(random.below(squares)), static_cast<std::uint32_t>(random.below(3))}});
  return made;
}

std::vector<std::vector<std::size_t>> tours_of(const Dispatch& dispatch, std::size_t carriers) {
  std::vector<std::vector<std::size_t>> tours;
  for (std::size_t carrier = 0; carrier < carriers; ++carrier)
    tours.emplace_back(dispatch.tour(carrier).begin(), dispatch.tour(carrier).end());
  return tours;
}

TEST(Dispatch, finds_tours_close_to_the_best_of_all) {
  double found = 0.0;
  double least = 0.0;
  Random random{4, "test"};
  for (int round = 0; round < 50; ++round) {
    Site site{open_grid(6, 5)};
    const Case made = random_case(random, 1 + random.below(3), 1 + random.below(5), 30);
    site.dispatch.plan(made.carriers, made.orders);
    AllTours all{site, made.carriers, made.orders};
    const std::uint64_t cost = all.cost(tours_of(site.dispatch, made.carriers.size()));
    const std::uint64_t best = all.least();
    ASSERT_GE(cost, best);
    found += static_cast<double>(cost) / static_cast<double>(std::max<std::uint64_t>(1, best));
    least += 1.0;
  }
  EXPECT_LT(found / least, 1.01);
}

TEST(Dispatch, puts_each_order_into_one_tour_and_is_the_same_twice) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "test"};
    Site one{open_grid(5, 4), GridMotion::forward_turn, {.exchanges_max = 300}};
    Site two{open_grid(5, 4), GridMotion::forward_turn, {.exchanges_max = 300}};
    Case made = random_case(random, 1 + random.below(5), random.below(12), 20);
    for (int round = 0; round < 3; ++round) {
      one.dispatch.plan(made.carriers, made.orders);
      two.dispatch.plan(made.carriers, made.orders);
      const auto tours = tours_of(one.dispatch, made.carriers.size());
      RC_ASSERT(tours == tours_of(two.dispatch, made.carriers.size()));
      std::multiset<std::size_t> planned;
      for (const auto& tour : tours) planned.insert(tour.begin(), tour.end());
      RC_ASSERT(planned.size() == made.orders.size());
      for (std::size_t index = 0; index < made.orders.size(); ++index) RC_ASSERT(planned.count(index) == 1U);
      if (!made.orders.empty())
        made.orders.erase(made.orders.begin() + static_cast<std::ptrdiff_t>(random.below(made.orders.size())));
      made.carriers[random.below(made.carriers.size())].at = static_cast<StateId>(random.below(80));
    }
  }));
}

}  // namespace
}  // namespace cosiva::planning
