#include "cosiva/planning/floor/floor.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cosiva::planning {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

/// Two points with two headings each, a turn of 180 degrees on the spot that needs cell 2, and a track that passes
/// cell 3.
FloorDescription two_points() {
  FloorDescription floor;
  floor.cells = 5;
  floor.states = {
      {{0}, {{1, {2}}, {2, {3, 0}}}}, {{0}, {{0, {2}}}}, {{4, 1, 4}, {{3, {}}}}, {{1, 4}, {{2, {}}, {1, {3}}}}};
  floor.goals = {{1, 0, 1}, {3}};
  return floor;
}

std::string code_of(const FloorDescription& description) {
  const auto floor = Floor::make(description);
  return floor ? "" : floor.error().code;
}

TEST(Floor, has_the_states_moves_and_goals_of_its_description) {
  const auto floor = Floor::make(two_points());
  ASSERT_TRUE(floor);
  EXPECT_EQ(floor->states(), 4U);
  EXPECT_EQ(floor->cells(), 5U);
  EXPECT_EQ(floor->goals(), 2U);
  EXPECT_THAT(floor->successors(0), ElementsAre(1, 2));
  EXPECT_THAT(floor->predecessors(1), ElementsAre(0, 3));
  EXPECT_THAT(floor->predecessors(2), ElementsAre(0, 3));
}

TEST(Floor, sorts_footprints_and_goals_and_removes_repetitions) {
  const auto floor = Floor::make(two_points());
  ASSERT_TRUE(floor);
  EXPECT_THAT(floor->footprint(2), ElementsAre(1, 4));
  EXPECT_THAT(floor->goal(0), ElementsAre(0, 1));
}

TEST(Floor, leaves_the_cells_of_both_ends_out_of_a_sweep) {
  const auto floor = Floor::make(two_points());
  ASSERT_TRUE(floor);
  EXPECT_TRUE(floor->has_sweeps());
  EXPECT_THAT(floor->sweep(0, 0), ElementsAre(2));
  EXPECT_THAT(floor->sweep(0, 1), ElementsAre(3));
  EXPECT_THAT(floor->sweep(2, 0), IsEmpty());
}

TEST(Floor, knows_that_no_move_sweeps_a_cell) {
  FloorDescription description = two_points();
  for (auto& state : description.states)
    for (auto& move : state.moves) move.sweep.clear();
  const auto floor = Floor::make(description);
  ASSERT_TRUE(floor);
  EXPECT_FALSE(floor->has_sweeps());
}

TEST(Floor, may_be_empty) {
  const auto floor = Floor::make({});
  ASSERT_TRUE(floor);
  EXPECT_EQ(floor->states(), 0U);
  EXPECT_EQ(floor->goals(), 0U);
}

TEST(Floor, needs_a_cell_under_each_body) {
  auto description = two_points();
  description.states[1].footprint.clear();
  const auto floor = Floor::make(description);
  ASSERT_FALSE(floor);
  EXPECT_EQ(floor.error().code, "floor.footprint");
  EXPECT_THAT(floor.error().message, HasSubstr("state 1"));
}

TEST(Floor, refuses_cells_and_states_that_do_not_exist) {
  auto description = two_points();
  description.states[3].footprint.push_back(5);
  EXPECT_EQ(code_of(description), "floor.index");
  description = two_points();
  description.states[0].moves[1].to = 4;
  EXPECT_EQ(code_of(description), "floor.index");
  description = two_points();
  description.states[0].moves[0].sweep.push_back(5);
  EXPECT_EQ(code_of(description), "floor.index");
}

TEST(Floor, refuses_a_move_that_ends_where_it_begins) {
  auto description = two_points();
  description.states[2].moves[0].to = 2;
  EXPECT_EQ(code_of(description), "floor.move");
}

TEST(Floor, refuses_two_moves_between_the_same_states) {
  auto description = two_points();
  description.states[0].moves.push_back({2, {}});
  EXPECT_EQ(code_of(description), "floor.move");
}

TEST(Floor, refuses_goals_without_states_or_with_one_that_does_not_exist) {
  auto description = two_points();
  description.goals.push_back({});
  const auto floor = Floor::make(description);
  ASSERT_FALSE(floor);
  EXPECT_EQ(floor.error().code, "floor.goal");
  EXPECT_THAT(floor.error().message, HasSubstr("goal 2"));
  description.goals.back() = {4};
  EXPECT_EQ(code_of(description), "floor.goal");
}

TEST(Floor, without_what_is_obstructed_lacks_the_moves_that_need_it) {
  const Floor floor = *Floor::make(two_points());
  const Floor no_turn = floor.without({{2}, {}});
  EXPECT_THAT(no_turn.successors(0), ElementsAre(2));
  EXPECT_THAT(no_turn.sweep(0, 0), ElementsAre(3)) << "sweeps belong to the moves that remain";
  EXPECT_THAT(no_turn.predecessors(0), IsEmpty());
  const Floor no_move = floor.without({{}, {{3, 2}}});
  EXPECT_THAT(no_move.successors(3), ElementsAre(1));
  EXPECT_THAT(no_move.predecessors(2), ElementsAre(0));
  EXPECT_EQ(no_move.states(), floor.states());
  EXPECT_EQ(no_move.goals(), floor.goals());
}

TEST(Floor, without_a_cell_lets_a_vehicle_in_that_cell_leave_it) {
  const Floor floor = Floor::make(two_points())->without({{1}, {}});
  EXPECT_THAT(floor.successors(0), ElementsAre(1)) << "states 2 and 3 occupy cell 1";
  EXPECT_THAT(floor.successors(3), ElementsAre(2, 1)) << "a vehicle there has the cell already";
}

}  // namespace
}  // namespace cosiva::planning
