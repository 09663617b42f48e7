#include "cosiva/planning/window/window_planner.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "cosiva/planning/testing/test_floors.h"

namespace cosiva::planning {
namespace {

using testing::ElementsAre;

/// A fleet that is driven by a planner: a vehicle that has arrived stays, then goes to its next stop.
struct Drive {
  fixture::TestFloor made;
  WindowOptions options;
  Distances distances{made.floor};
  WindowPlanner planner{made.floor, distances, options, 1};
  std::vector<Traveller> fleet;
  std::size_t arrivals{0};
  std::size_t interrupted{0};  // vehicles that have left before the end of their stay

  Drive(fixture::TestFloor floor, WindowOptions with, const std::vector<StateId>& begin)
      : made{std::move(floor)}, options{with} {
    for (const StateId at : begin) fleet.push_back({at, {}, 0});
  }

  /// Plans; the first fault of all paths, or an empty text.
  std::string plan(std::uint64_t expansions) {
    planner.plan(fleet, expansions);
    std::vector<std::vector<StateId>> paths;
    for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle) {
      const auto path = planner.path(vehicle);
      if (path.size() != options.horizon + 1 || path[0] != fleet[vehicle].at) return "a path of another vehicle";
      paths.emplace_back(path.begin(), path.end());
    }
    return fixture::PathChecker{made.description, options.cycles}.fault(paths);
  }

  void move() {
    for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle) {
      Traveller& traveller = fleet[vehicle];
      const StateId to = planner.path(vehicle)[1];
      auto& stops = traveller.stops;
      if (!stops.empty() && stops[0].stay > 0 && is_at(stops[0].goal, traveller.at)) {
        if (to != traveller.at) ++interrupted;
        --stops[0].stay;
      }
      traveller.at = to;
      while (!stops.empty() && stops[0].stay == 0 && is_at(stops[0].goal, to)) {
        stops.erase(stops.begin());
        ++arrivals;
      }
    }
  }

 private:
  [[nodiscard]] bool is_at(GoalId goal, StateId state) { return distances.to(goal)[state] == 0; }
};

WindowOptions short_window(bool cycles = false) { return {.horizon = 8, .cycles = cycles, .group = 4}; }

TEST(WindowPlanner, leads_a_vehicle_through_all_its_stops) {
  Drive drive{fixture::grid_test_floor(fixture::open_grid(4, 1)), short_window(), {1}};
  drive.fleet[0].stops = {{3, 1}, {0, 0}};
  EXPECT_EQ(drive.plan(100), "");
  EXPECT_THAT(drive.planner.path(0), ElementsAre(1, 2, 3, 3, 2, 1, 0, 0, 0));
}

TEST(WindowPlanner, lets_two_vehicles_pass_each_other_at_a_bay) {
  Grid grid = fixture::open_grid(5, 2);
  for (const std::size_t square : {5U, 6U, 8U, 9U}) grid.free[square] = 0;
  Drive drive{fixture::grid_test_floor(grid), short_window(), {0, 4}};
  drive.fleet[0].stops = {{4, 0}};
  drive.fleet[1].stops = {{0, 0}};
  for (int step = 0; step < 12 && drive.arrivals < 2; ++step) {
    EXPECT_EQ(drive.plan(1000), "");
    drive.move();
  }
  EXPECT_EQ(drive.arrivals, 2U);
}

TEST(WindowPlanner, follows_its_plan_as_long_as_nothing_changes) {
  Drive drive{fixture::grid_test_floor(fixture::open_grid(6, 6)), short_window(), {0, 5, 30, 35}};
  for (Vehicle vehicle = 0; vehicle < 4; ++vehicle) drive.fleet[vehicle].stops = {{35 - drive.fleet[vehicle].at, 0}};
  EXPECT_EQ(drive.plan(2000), "");
  const auto before = drive.planner.path(2);
  const std::vector<StateId> rest(before.begin() + 1, before.end());
  drive.move();
  EXPECT_EQ(drive.plan(0), "");
  EXPECT_TRUE(std::ranges::equal(rest, drive.planner.path(2).first(rest.size())));
}

TEST(WindowPlanner, begins_anew_where_a_vehicle_is_not_where_it_was_led) {
  Drive drive{fixture::grid_test_floor(fixture::open_grid(6, 1)), short_window(), {0, 5}};
  drive.fleet[0].stops = {{4, 0}};
  EXPECT_EQ(drive.plan(100), "");
  EXPECT_EQ(drive.plan(100), "");  // delayed: vehicle 0 is where it was
  EXPECT_EQ(drive.planner.path(0)[1], 1U);
  drive.fleet.pop_back();
  EXPECT_EQ(drive.plan(100), "");
}

TEST(WindowPlanner, reports_which_vehicle_cannot_reach_all_stops) {
  Grid grid = fixture::open_grid(5, 1);
  grid.free[3] = 0;
  Drive drive{fixture::grid_test_floor(grid), short_window(), {0, 1}};
  drive.fleet[0].stops = {{4, 0}};
  drive.fleet[1].stops = {{2, 0}};
  EXPECT_EQ(drive.plan(100), "");
  EXPECT_FALSE(drive.planner.complete(0));
  EXPECT_TRUE(drive.planner.complete(1));
}

TEST(WindowPlanner, plans_an_empty_fleet) {
  Drive drive{fixture::grid_test_floor(fixture::open_grid(2, 1)), short_window(), {}};
  EXPECT_EQ(drive.plan(100), "");
}

TEST(WindowPlanner, needs_no_expansions_for_a_plan_without_faults) {
  Drive drive{fixture::grid_test_floor(fixture::open_grid(5, 5)), short_window(), {0, 4, 20, 24}};
  for (auto& traveller : drive.fleet) traveller.stops = {{24 - traveller.at, 0}};
  for (int step = 0; step < 40 && drive.arrivals < 4; ++step) {
    EXPECT_EQ(drive.plan(0), "");
    drive.move();
  }
  EXPECT_EQ(drive.arrivals, 4U);
}

TEST(WindowPlanner, with_more_expansions_serves_more_stops) {
  std::vector<std::size_t> arrivals;
  for (const std::uint64_t expansions : {0U, 5000U}) {
    Random random{5, "test"};
    const auto made = fixture::grid_test_floor(fixture::random_grid(random, 12, 12, 0.15));
    Drive drive{made, short_window(true), fixture::random_fleet(made.floor, random, 40)};
    const auto goals = fixture::random_fleet(made.floor, random, 60);
    for (int step = 0; step < 100; ++step) {
      for (auto& traveller : drive.fleet)
        if (traveller.stops.empty()) traveller.stops = {{goals[random.below(goals.size())], 0}};
      // The checker takes longer than the planner.
      if (step % 20 == 0)
        ASSERT_EQ(drive.plan(expansions), "");
      else
        drive.planner.plan(drive.fleet, expansions);
      drive.move();
    }
    arrivals.push_back(drive.arrivals);
  }
  EXPECT_GT(arrivals[1], arrivals[0] * 11 / 10);
}

struct Load {
  std::size_t vehicles;
  std::uint64_t expansions;
  int steps;
};

/// A fleet with random stops that change at random, checked in each step.
void drive_at_random(fixture::TestFloor made, Random& random, bool cycles, const Load& load) {
  const auto begin = fixture::random_fleet(made.floor, random, load.vehicles);
  Drive one{made, short_window(cycles), begin};
  Drive two{std::move(made), short_window(cycles), begin};
  for (int step = 0; step < load.steps; ++step) {
    for (auto& traveller : one.fleet) {
      if (!traveller.stops.empty() || random.chance(0.3)) continue;
      while (random.chance(0.6) && traveller.stops.size() < 4)
        traveller.stops.push_back(
            {static_cast<GoalId>(random.below(one.made.floor.goals())), static_cast<std::uint32_t>(random.below(4))});
      traveller.urgency = static_cast<std::uint32_t>(random.below(3));
    }
    two.fleet = one.fleet;
    RC_ASSERT(one.plan(load.expansions) == "");
    RC_ASSERT(two.plan(load.expansions) == "");
    one.move();
    two.move();
    RC_ASSERT(one.interrupted == 0U);
    for (std::size_t i = 0; i < one.fleet.size(); ++i) RC_ASSERT(one.fleet[i].at == two.fleet[i].at);
  }
  RC_ASSERT(one.planner.expansions() == two.planner.expansions());
}

TEST(WindowPlanner, is_without_faults_and_the_same_twice_on_random_floors) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed, bool cycles) {
    Random random{seed, "test"};
    drive_at_random(fixture::random_floor(random), random, cycles, {5, 200, 10});
  }));
}

TEST(WindowPlanner, is_without_faults_and_the_same_twice_on_grids) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed, bool cycles, bool turns) {
    Random random{seed, "test"};
    const Grid grid = fixture::random_grid(random, 5, 4, 0.1);
    drive_at_random(fixture::grid_test_floor(grid, turns ? GridMotion::forward_turn : GridMotion::any_direction),
                    random, cycles, {8, 200, 8});
  }));
}

}  // namespace
}  // namespace cosiva::planning
