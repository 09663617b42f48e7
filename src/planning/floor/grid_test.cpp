#include "cosiva/planning/floor/grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "cosiva/planning/floor/distances.h"

namespace cosiva::planning {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

constexpr std::string_view small_map = "type octile\nheight 2\nwidth 3\nmap\n.@G\nS.E\n";

struct Fault {
  std::string text;
  std::string code;
  std::string location;
};

void expect_fault(const Fault& fault) {
  const auto grid = read_grid(fault.text);
  ASSERT_FALSE(grid) << fault.text;
  EXPECT_EQ(grid.error().code, fault.code) << fault.text;
  EXPECT_EQ(grid.error().location, fault.location) << fault.text;
}

TEST(Grid, reads_a_movingai_map) {
  const auto grid = read_grid(small_map);
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->width, 3U);
  EXPECT_EQ(grid->height, 2U);
  EXPECT_THAT(grid->free, ElementsAre(1, 0, 1, 1, 1, 1));
  EXPECT_TRUE(grid->is_free(2, 0));
  EXPECT_FALSE(grid->is_free(1, 0));
  EXPECT_FALSE(grid->is_free(3, 0));
  EXPECT_FALSE(grid->is_free(0, 2));
}

TEST(Grid, reads_lines_that_end_with_carriage_return_and_line_feed) {
  const auto grid = read_grid("type octile\r\nheight 1\r\nwidth 2\r\nmap\r\n.T\r\n\r\n");
  ASSERT_TRUE(grid);
  EXPECT_THAT(grid->free, ElementsAre(1, 0));
}

TEST(Grid, names_the_line_of_a_bad_header) {
  expect_fault({"", "grid.header", "line 0"});
  expect_fault({"type octile\nheight 2\n", "grid.header", "line 2"});
  expect_fault({"type octile\nheight 2\nmap\n..\n..\n", "grid.header", "line 3"});
  expect_fault({"height 0\nwidth 1\nmap\n", "grid.header", "line 1"});
  expect_fault({"height 16385\nwidth 1\nmap\n", "grid.header", "line 1"});
  expect_fault({"height 99999999999999999999\nwidth 1\nmap\n", "grid.header", "line 1"});
  expect_fault({"height 1\nwidth -1\nmap\n.\n", "grid.header", "line 2"});
  expect_fault({"height 1\nwidth 1 1\nmap\n.\n", "grid.header", "line 2"});
  expect_fault({"height 1\nbreadth 1\nmap\n.\n", "grid.header", "line 2"});
}

TEST(Grid, names_the_line_of_a_row_with_another_length) {
  expect_fault({"height 2\nwidth 2\nmap\n..\n.\n", "grid.row", "line 5"});
  expect_fault({"height 2\nwidth 2\nmap\n...\n..\n", "grid.row", "line 4"});
}

TEST(Grid, has_as_many_rows_as_stated) {
  expect_fault({"height 2\nwidth 2\nmap\n..\n", "grid.row", "line 4"});
  expect_fault({"height 1\nwidth 2\nmap\n..\n\n..\n", "grid.row", "line 6"});
}

TEST(Grid, refuses_characters_that_are_no_squares) {
  expect_fault({"height 1\nwidth 2\nmap\n.x\n", "grid.character", "line 4"});
}

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
