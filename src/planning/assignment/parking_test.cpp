#include "cosiva/planning/assignment/parking.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <numeric>

#include "cosiva/base/random.h"
#include "cosiva/planning/floor/grid.h"

namespace cosiva::planning {
namespace {

using testing::Optional;

/// Squares in a row or rectangle, in each of which vehicles may wait.
struct Site {
  Floor floor;
  Distances distances{floor};
  Parking parking;

  Site(std::uint32_t width, std::uint32_t height, std::vector<GoalId> goals)
      : floor{grid_floor({width, height, std::vector<std::uint8_t>(std::size_t{width} * height, 1)},
                         GridMotion::any_direction)},
        parking{floor, distances, std::move(goals)} {}
};

std::vector<GoalId> all_goals(GoalId count) {
  std::vector<GoalId> goals(count);
  std::iota(goals.begin(), goals.end(), 0U);
  return goals;
}

Reserve idle(StateId at) { return {at, {}, 0}; }

TEST(Parking, leads_a_vehicle_to_the_median_of_the_demand) {
  Site site{9, 1, all_goals(9)};
  site.parking.set_demand({{0, 1}, {4, 1}, {8, 1}});
  site.parking.plan(std::vector{idle(0)});
  EXPECT_THAT(site.parking.goal(0), Optional(GoalId{4}));
}

TEST(Parking, weighs_the_demand) {
  Site site{9, 1, all_goals(9)};
  site.parking.set_demand({{0, 1}, {4, 1}, {8, 3}});
  site.parking.plan(std::vector{idle(0)});
  EXPECT_THAT(site.parking.goal(0), Optional(GoalId{8}));
}

TEST(Parking, learns_the_demand_from_orders) {
  Site site{9, 1, all_goals(9)};
  site.parking.set_demand({{0, 2}});
  for (int order = 0; order < 3; ++order) site.parking.count(7);
  site.parking.plan(std::vector{idle(3)});
  EXPECT_THAT(site.parking.goal(0), Optional(GoalId{7}));
}

TEST(Parking, lets_a_vehicle_wait_that_cannot_gain) {
  Site site{9, 1, all_goals(9)};
  site.parking.set_demand({{4, 1}});
  site.parking.plan(std::vector{idle(4)});
  EXPECT_EQ(site.parking.goal(0), std::nullopt);
  site.parking.set_demand({});
  site.parking.plan(std::vector{idle(2)});
  EXPECT_EQ(site.parking.goal(0), std::nullopt);
}

TEST(Parking, uses_only_goals_that_are_allowed) {
  Site site{9, 1, {1, 6, 8}};
  site.parking.set_demand({{4, 1}, {5, 1}});
  site.parking.plan(std::vector{idle(0)});
  EXPECT_THAT(site.parking.goal(0), Optional(GoalId{6}));
}

TEST(Parking, spreads_vehicles_over_the_demand_with_short_trips) {
  Site site{9, 1, all_goals(9)};
  site.parking.set_demand({{0, 1}, {8, 1}});
  for (int step = 0; step < 3; ++step) site.parking.plan(std::vector{idle(5), idle(3)});
  EXPECT_THAT(site.parking.goal(0), Optional(GoalId{8}));
  EXPECT_THAT(site.parking.goal(1), Optional(GoalId{0}));
}

TEST(Parking, counts_a_vehicle_with_an_order_from_where_it_becomes_free) {
  Site site{9, 1, all_goals(9)};
  site.parking.set_demand({{0, 1}, {8, 1}});
  const Reserve busy{4, GoalId{0}, 2};
  site.parking.plan(std::vector{idle(4), busy});
  EXPECT_THAT(site.parking.goal(0), Optional(GoalId{8}));
  EXPECT_EQ(site.parking.goal(1), std::nullopt);
}

TEST(Parking, forgets_the_goal_of_a_vehicle_that_gets_an_order) {
  Site site{9, 1, all_goals(9)};
  site.parking.set_demand({{8, 1}});
  site.parking.plan(std::vector{idle(0)});
  ASSERT_TRUE(site.parking.goal(0));
  site.parking.plan(std::vector{Reserve{1, GoalId{3}, 2}});
  EXPECT_EQ(site.parking.goal(0), std::nullopt);
}

/// Sum of weight × distance to the nearest of these states.
std::uint64_t cost(Distances& distances, const std::vector<Demand>& demand, const std::vector<StateId>& states) {
  std::uint64_t sum = 0;
  for (const Demand& one : demand) {
    std::uint64_t least = Distances::unreachable;
    for (const StateId state : states) least = std::min<std::uint64_t>(least, distances.to(one.goal)[state]);
    sum += one.weight * least;
  }
  return sum;
}

TEST(Parking, is_close_to_the_best_two_goals_of_all_and_never_has_one_goal_twice) {
  double ratios = 0.0;
  constexpr int rounds = 40;
  Random random{7, "test"};
  for (int round = 0; round < rounds; ++round) {
    Site site{5, 4, all_goals(20)};
    std::vector<Demand> demand;
    for (GoalId goal = 0; goal < 20; ++goal)
      if (random.chance(0.4)) demand.push_back({goal, static_cast<std::uint32_t>(1 + random.below(4))});
    site.parking.set_demand(demand);
    const std::vector<Reserve> vehicles{idle(static_cast<StateId>(random.below(20))),
                                        idle(static_cast<StateId>(random.below(20)))};
    for (int step = 0; step < 5; ++step) site.parking.plan(vehicles);
    std::vector<StateId> states;
    for (std::size_t vehicle = 0; vehicle < 2; ++vehicle)
      states.push_back(site.parking.goal(vehicle).value_or(vehicles[vehicle].at));
    if (site.parking.goal(0) && site.parking.goal(1)) {
      EXPECT_NE(*site.parking.goal(0), *site.parking.goal(1));
    }
    std::uint64_t least = cost(site.distances, demand, states);
    const auto reached = static_cast<double>(least);
    for (StateId a = 0; a < 20; ++a)
      for (StateId b = 0; b < a; ++b) least = std::min(least, cost(site.distances, demand, {a, b}));
    ratios += reached / static_cast<double>(std::max<std::uint64_t>(1, least));
  }
  EXPECT_LT(ratios / rounds, 1.15);
}

}  // namespace
}  // namespace cosiva::planning
