#include "cosiva/planning/window/joint_step.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include "cosiva/planning/testing/test_floors.h"

namespace cosiva::planning {
namespace {

/// A fleet that is moved by joint steps alone.
struct Fleet {
  fixture::TestFloor made;
  bool cycles;
  Distances distances{made.floor};
  JointStep joint{made.floor, cycles};
  std::vector<StateId> at;
  std::vector<std::vector<Stop>> stops;
  std::vector<std::uint32_t> urgency;

  Fleet(fixture::TestFloor floor, bool with_cycles, std::vector<StateId> begin)
      : made{std::move(floor)}, cycles{with_cycles}, at{std::move(begin)}, stops(at.size()), urgency(at.size(), 0) {}

  /// Plans and makes one step; the first fault of the step, or an empty text.
  std::string step() {
    std::vector<Itinerary> itineraries;
    for (std::size_t i = 0; i < at.size(); ++i) itineraries.emplace_back(at[i], stops[i], made.floor, distances);
    std::vector<StepVehicle> fleet;
    for (std::size_t i = 0; i < at.size(); ++i)
      fleet.push_back({at[i], &itineraries[i], itineraries[i].start(at[i]), urgency[i]});
    joint.plan(fleet);
    std::vector<std::vector<StateId>> paths;
    for (Vehicle vehicle = 0; vehicle < at.size(); ++vehicle) {
      paths.push_back({at[vehicle], joint.next(vehicle)});
      at[vehicle] = joint.next(vehicle);
    }
    return fixture::PathChecker{made.description, cycles}.fault(paths);
  }
  [[nodiscard]] bool arrived(std::size_t vehicle) { return distances.to(stops[vehicle][0].goal)[at[vehicle]] == 0; }
};

TEST(JointStep, brings_a_vehicle_nearer_to_its_goal_in_each_step) {
  Fleet fleet{fixture::grid_test_floor(fixture::open_grid(5, 1)), false, {0}};
  fleet.stops[0] = {{4, 0}};
  for (StateId expected = 1; expected <= 4; ++expected) {
    EXPECT_EQ(fleet.step(), "");
    EXPECT_EQ(fleet.at[0], expected);
  }
}

TEST(JointStep, lets_an_idle_vehicle_wait) {
  Fleet fleet{fixture::grid_test_floor(fixture::open_grid(3, 3)), false, {4}};
  for (int step = 0; step < 5; ++step) EXPECT_EQ(fleet.step(), "");
  EXPECT_EQ(fleet.at[0], 4U);
}

TEST(JointStep, moves_an_idle_vehicle_out_of_a_dead_end) {
  // Squares 0 to 3 in a row; the idle vehicle in square 1 separates the other one from its goal and evades into the
  // bay.
  Grid grid = fixture::open_grid(4, 2);
  grid.free[4] = grid.free[5] = grid.free[7] = 0;
  Fleet fleet{fixture::grid_test_floor(grid), false, {0, 1}};
  fleet.stops[0] = {{3, 0}};
  for (int step = 0; step < 8 && !fleet.arrived(0); ++step) EXPECT_EQ(fleet.step(), "");
  EXPECT_TRUE(fleet.arrived(0));
}

TEST(JointStep, does_not_displace_a_vehicle_that_stays) {
  Fleet fleet{fixture::grid_test_floor(fixture::open_grid(4, 1)), false, {0, 1}};
  fleet.stops = {{{3, 0}}, {{1, 5}}};
  fleet.urgency[0] = 9;
  for (int step = 0; step < 5; ++step) {
    EXPECT_EQ(fleet.step(), "");
    EXPECT_EQ(fleet.at[1], 1U);
    --fleet.stops[1][0].stay;
  }
  fleet.stops[1].clear();
  for (int step = 0; step < 4; ++step) EXPECT_EQ(fleet.step(), "");
  EXPECT_NE(fleet.at[1], 1U);
}

TEST(JointStep, does_not_enter_a_dead_end_to_make_room) {
  // One-way: 0 → 1 → 2 → 3 → 0, and 1 → 4, from where nothing leads back. Vehicle 1 has to wait for vehicle 2.
  FloorDescription floor;
  floor.cells = 5;
  floor.states = {{{0}, {{1, {}}}}, {{1}, {{2, {}}, {4, {}}}}, {{2}, {{3, {}}}}, {{3}, {{0, {}}}}, {{4}, {}}};
  floor.goals = {{0}, {3}, {2}};
  Fleet fleet{fixture::TestFloor{floor}, false, {0, 1, 2}};
  fleet.stops = {{{1, 0}}, {{0, 0}}, {{2, 3}}};
  fleet.urgency[0] = 9;
  for (int step = 0; step < 3; ++step) {
    EXPECT_EQ(fleet.step(), "");
    EXPECT_EQ(fleet.at[1], 1U);
    --fleet.stops[2][0].stay;
  }
}

/// Many steps of a fleet whose vehicles get a new goal wherever they arrive.
void drive(fixture::TestFloor made, Random& random, bool cycles, std::size_t vehicles) {
  auto begin = fixture::random_fleet(made.floor, random, vehicles);
  Fleet fleet{std::move(made), cycles, std::move(begin)};
  for (int step = 0; step < 25; ++step) {
    for (std::size_t i = 0; i < fleet.at.size(); ++i)
      if (random.chance(0.2))
        fleet.stops[i] = {
            {static_cast<GoalId>(random.below(fleet.made.floor.goals())), static_cast<std::uint32_t>(random.below(3))}};
    RC_ASSERT(fleet.step() == "");
  }
}

TEST(JointStep, never_lets_vehicles_touch_on_random_floors) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed, bool cycles) {
    Random random{seed, "test"};
    drive(fixture::random_floor(random), random, cycles, 5);
  }));
}

TEST(JointStep, never_lets_vehicles_touch_on_crowded_grids) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed, bool cycles, bool turns) {
    Random random{seed, "test"};
    const Grid grid = fixture::random_grid(random, 5, 4, 0.15);
    drive(fixture::grid_test_floor(grid, turns ? GridMotion::forward_turn : GridMotion::any_direction), random, cycles,
          12);
  }));
}

TEST(JointStep, brings_the_most_urgent_vehicle_to_its_goal_on_a_shortest_path_where_there_is_room) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "test"};
    auto made = fixture::grid_test_floor(fixture::open_grid(6, 6));
    auto begin = fixture::random_fleet(made.floor, random, 12);
    Fleet fleet{std::move(made), false, std::move(begin)};
    for (auto& stops : fleet.stops) stops = {{static_cast<GoalId>(random.below(36)), 0}};
    fleet.urgency[0] = 1;
    const int moves = fleet.distances.to(fleet.stops[0][0].goal)[fleet.at[0]];
    for (int step = 0; step < moves; ++step) RC_ASSERT(fleet.step() == "");
    RC_ASSERT(fleet.arrived(0));
  }));
}

TEST(JointStep, is_the_same_on_a_second_run) {
  Random random{11, "test"};
  const auto made = fixture::grid_test_floor(fixture::open_grid(6, 6));
  Fleet one{made, false, fixture::random_fleet(made.floor, random, 20)};
  for (auto& stops : one.stops) stops = {{static_cast<GoalId>(random.below(36)), 1}};
  Fleet two{made, false, one.at};
  two.stops = one.stops;
  for (int step = 0; step < 20; ++step) {
    EXPECT_EQ(one.step(), "");
    EXPECT_EQ(two.step(), "");
    EXPECT_EQ(one.at, two.at);
  }
  EXPECT_EQ(one.joint.expansions(), two.joint.expansions());
}

}  // namespace
}  // namespace cosiva::planning
