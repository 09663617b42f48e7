#include "cosiva/planning/passing/passing_order.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <map>

#include "cosiva/planning/testing/test_floors.h"
#include "cosiva/planning/window/window_planner.h"

namespace cosiva::planning {
namespace {

/// A row of squares 0, 1, 2, …, in which vehicles drive both ways.
Floor row(std::uint32_t squares) { return grid_floor(fixture::open_grid(squares, 1), GridMotion::any_direction); }

void add(PassingOrder& order, std::vector<std::vector<StateId>> steps) {
  for (const auto& step : steps) order.add_step(step);
}

TEST(PassingOrder, grants_a_move_when_no_other_vehicle_passes_its_cells_before) {
  const Floor floor = row(4);
  PassingOrder order{floor};
  order.begin(std::array<StateId, 1>{0});
  EXPECT_FALSE(order.grant(0)) << "nothing is planned";
  add(order, {{1}, {2}});
  EXPECT_TRUE(order.grant(0));
  EXPECT_TRUE(order.grant(0));
  EXPECT_EQ(order.granted_end(0), 2U);
  EXPECT_FALSE(order.grant(0));
}

TEST(PassingOrder, makes_a_follower_wait_until_the_leader_has_left_however_late_the_leader_is) {
  const Floor floor = row(4);
  PassingOrder order{floor};
  order.begin(std::array<StateId, 2>{0, 1});
  add(order, {{1, 2}, {2, 3}});
  EXPECT_FALSE(order.grant(0));
  EXPECT_EQ(order.waits_for(0), 1U);
  EXPECT_TRUE(order.grant(1));
  EXPECT_FALSE(order.grant(0)) << "the leader may leave, and has not left";
  order.arrive(1);
  EXPECT_TRUE(order.grant(0));
  EXPECT_FALSE(order.grant(0));
  EXPECT_TRUE(order.grant(1));
  order.arrive(1);
  EXPECT_TRUE(order.grant(0));
}

TEST(PassingOrder, keeps_the_planned_order_where_the_second_vehicle_is_early) {
  // Squares 0 1 2 above 3 4 5 above 6 7 8: both vehicles pass square 4.
  const Floor floor = grid_floor(fixture::open_grid(3, 3), GridMotion::any_direction);
  PassingOrder order{floor};
  order.begin(std::array<StateId, 2>{3, 1});
  add(order, {{4, 1}, {5, 4}, {5, 7}});
  EXPECT_FALSE(order.grant(1)) << "the other one passes the crossing first, and has not even begun";
  EXPECT_TRUE(order.grant(0));
  order.arrive(0);
  EXPECT_FALSE(order.grant(1));
  EXPECT_TRUE(order.grant(0));
  order.arrive(0);
  EXPECT_TRUE(order.grant(1));
}

TEST(PassingOrder, forgets_what_is_planned_and_keeps_what_is_granted) {
  const Floor floor = row(5);
  PassingOrder order{floor};
  order.begin(std::array<StateId, 2>{0, 4});
  add(order, {{1, 4}, {2, 4}, {3, 4}});
  ASSERT_TRUE(order.grant(0));
  order.drop_planned();
  EXPECT_EQ(order.planned_end(0), 1U);
  EXPECT_EQ(order.granted_moves(0), 1U);
  // Now the other vehicle comes first.
  add(order, {{1, 3}, {1, 2}});
  EXPECT_TRUE(order.grant(1));
  EXPECT_TRUE(order.grant(1));
  EXPECT_FALSE(order.grant(0));
}

TEST(PassingOrder, begins_with_moves_that_were_granted_before) {
  const Floor floor = row(5);
  PassingOrder order{floor};
  order.begin(std::vector<GrantedMoves>{{{0, 1, 2}, false}, {{4}, false}});
  EXPECT_EQ(order.granted_moves(0), 2U);
  add(order, {{2, 3}, {2, 2}, {2, 1}});
  EXPECT_TRUE(order.grant(1));
  EXPECT_FALSE(order.grant(1)) << "2 is granted to the first vehicle";
  order.arrive(0);
  order.arrive(0);
  EXPECT_EQ(order.ended_moves(0), 2U);
  EXPECT_EQ(order.waits_for(1), 0U);
}

TEST(PassingOrder, lets_a_follower_in_when_the_leader_is_clear_of_the_beginning_of_its_move) {
  const Floor floor = row(4);
  PassingOrder order{floor};
  order.begin(std::array<StateId, 2>{0, 1});
  add(order, {{1, 2}});
  ASSERT_TRUE(order.grant(1));
  EXPECT_FALSE(order.grant(0));
  order.clear(1);
  EXPECT_TRUE(order.is_clear(1));
  EXPECT_TRUE(order.grant(0)) << "the leader has not arrived yet";
  order.arrive(1);
  EXPECT_FALSE(order.is_clear(1));
  EXPECT_EQ(order.states(1).front(), 2U);
}

TEST(PassingOrder, begins_with_a_vehicle_that_is_clear_where_another_one_is_by_now) {
  const Floor floor = row(4);
  PassingOrder order{floor};
  order.begin(std::vector<GrantedMoves>{{{0, 1}, false}, {{1, 2}, true}});
  order.arrive(1);
  order.arrive(0);
  EXPECT_EQ(order.ended_moves(0), 1U);
  add(order, {{1, 3}});
  EXPECT_TRUE(order.grant(1));
}

TEST(PassingOrder, keeps_swept_cells_free_until_the_move_has_ended) {
  // State 0 leads past cell 1 to state 2; state 1 occupies that cell.
  FloorDescription description{4, {{{0}, {{2, {1}}}}, {{1}, {{3, {}}}}, {{2}, {}}, {{3}, {{1, {}}}}}, {{0}}};
  const Floor floor = *Floor::make(description);
  PassingOrder order{floor};
  order.begin(std::array<StateId, 2>{0, 3});
  add(order, {{2, 3}, {2, 1}});
  ASSERT_TRUE(order.grant(0));
  EXPECT_FALSE(order.grant(1));
  order.arrive(0);
  EXPECT_TRUE(order.grant(1));
}

/// Executes a plan in a random order of events and watches that no cell has two vehicles.
class Execution {
 public:
  Execution(const Floor& floor, PassingOrder& order, std::uint64_t seed)
      : floor_{floor}, order_{order}, random_{seed, "events"} {}

  /// Until nothing can be done any more. False: two vehicles were granted one cell.
  [[nodiscard]] bool run() {
    for (std::size_t idle = 0; idle < 40 * order_.vehicles();) {
      const auto vehicle = static_cast<std::uint32_t>(random_.below(order_.vehicles()));
      bool did = false;
      if (random_.chance(0.5)) {
        did = order_.grant(vehicle);
      } else if (order_.granted_moves(vehicle) > 0) {
        order_.arrive(vehicle);
        did = true;
      }
      idle = did ? 0 : idle + 1;
      if (!alone()) return false;
    }
    return true;
  }
  [[nodiscard]] bool finished() const {
    for (std::uint32_t vehicle = 0; vehicle < order_.vehicles(); ++vehicle)
      if (order_.planned_moves(vehicle) + order_.granted_moves(vehicle) > 0) return false;
    return true;
  }

 private:
  /// Of the cells of all granted moves none belongs to two vehicles.
  [[nodiscard]] bool alone() const {
    std::map<CellId, std::uint32_t> owners;
    for (std::uint32_t vehicle = 0; vehicle < order_.vehicles(); ++vehicle)
      for (std::size_t i = 0; i <= order_.granted_moves(vehicle); ++i)
        for (const CellId cell : floor_.footprint(order_.states(vehicle)[i]))
          if (owners.emplace(cell, vehicle).first->second != vehicle) return false;
    return true;
  }

  const Floor& floor_;
  PassingOrder& order_;
  Random random_;
};

TEST(PassingOrder, lets_every_plan_end_in_any_order_of_events_and_grants_no_cell_twice) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "floor"};
    const auto made = random.chance(0.5) ? fixture::random_floor(random)
                                         : fixture::grid_test_floor(fixture::random_grid(random, 4, 4, 0.2));
    const auto begin = fixture::random_fleet(made.floor, random, 6);
    RC_PRE(!begin.empty());
    Distances distances{made.floor};
    WindowPlanner planner{made.floor, distances, {.horizon = 6}, seed};
    PassingOrder order{made.floor};
    order.begin(begin);
    std::vector<Traveller> fleet;
    for (const StateId at : begin)
      fleet.push_back({at, {{static_cast<GoalId>(random.below(made.floor.goals())), 0}}, 0});
    for (int step = 0; step < 12; ++step) {
      planner.plan(fleet, 200);
      std::vector<StateId> next;
      for (Vehicle vehicle = 0; vehicle < fleet.size(); ++vehicle)
        next.push_back(fleet[vehicle].at = planner.path(vehicle)[1]);
      order.add_step(next);
    }
    Execution execution{made.floor, order, seed};
    RC_ASSERT(execution.run());
    RC_ASSERT(execution.finished());
  }));
}

}  // namespace
}  // namespace cosiva::planning
