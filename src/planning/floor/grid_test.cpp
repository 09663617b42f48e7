#include "cosiva/planning/floor/grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/planning/floor/distances.h"

namespace cosiva::planning {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::string_view small_map = "type octile\nheight 2\nwidth 3\nmap\n.@G\nS.E\n";

TEST(GridFloor, connects_free_neighbours_in_four_directions) {
  const Floor floor = grid_floor(*read_grid(small_map), GridMotion::any_direction);
  EXPECT_EQ(floor.states(), 6U);
  EXPECT_EQ(floor.goals(), 6U);
  EXPECT_THAT(floor.successors(0), ElementsAre(3));
  EXPECT_THAT(floor.successors(4), ElementsAre(5, 3));
  EXPECT_THAT(floor.successors(1), IsEmpty());
  EXPECT_THAT(floor.predecessors(1), IsEmpty());
  EXPECT_THAT(floor.footprint(4), ElementsAre(4));
  EXPECT_THAT(floor.goal(5), ElementsAre(5));
}

TEST(GridFloor, with_headings_moves_forward_or_turns) {
  const Floor floor = grid_floor(*read_grid(small_map), GridMotion::forward_turn);
  EXPECT_EQ(floor.states(), 24U);
  // In square 3, row 1, column 0: east leads to square 4, south and west are walls, north leads to square 0.
  EXPECT_THAT(floor.successors(12), ElementsAre(16, 13, 15));
  EXPECT_THAT(floor.successors(13), ElementsAre(14, 12));
  EXPECT_THAT(floor.successors(14), ElementsAre(15, 13));
  EXPECT_THAT(floor.successors(15), ElementsAre(3, 12, 14));
  EXPECT_THAT(floor.goal(3), ElementsAre(12, 13, 14, 15));
  EXPECT_THAT(floor.footprint(15), ElementsAre(3));
  Distances distances{floor};
  // West in square 3 to square 5: two turns and two moves.
  EXPECT_EQ(distances.to(5)[14], 4);
}

}  // namespace
}  // namespace cosiva::planning
