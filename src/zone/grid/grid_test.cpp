#include "cosiva/zone/grid/grid.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

namespace cosiva::zone {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

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
  const auto grid = read_grid("type octile\nheight 2\nwidth 3\nmap\n.@G\nS.E\n");
  ASSERT_TRUE(grid);
  EXPECT_EQ(grid->width, 3U);
  EXPECT_EQ(grid->height, 2U);
  EXPECT_THAT(grid->free, ElementsAre(1, 0, 1, 1, 1, 1));
  EXPECT_TRUE(grid->is_free(2, 0));
  EXPECT_FALSE(grid->is_free(1, 0));
  EXPECT_FALSE(grid->is_free(3, 0));
  EXPECT_FALSE(grid->is_free(0, 2));
}

TEST(Grid, has_stops_at_the_emitters_and_service_points_of_the_league_of_robot_runners) {
  EXPECT_THAT(read_grid("height 2\nwidth 3\nmap\n.@G\nS.E\n")->stops, ElementsAre(3, 5));
}

TEST(Grid, has_no_stops_in_a_swamp) { EXPECT_THAT(read_grid("height 1\nwidth 3\nmap\nSS.\n")->stops, IsEmpty()); }

TEST(Grid, reads_lines_that_end_with_carriage_return_and_line_feed) {
  const auto grid = read_grid("type octile\r\nheight 1\r\nwidth 2\r\nmap\r\n.T\r\n\r\n");
  ASSERT_TRUE(grid);
  EXPECT_THAT(grid->free, ElementsAre(1, 0));
}

TEST(Grid, names_the_line_and_the_column_of_a_bad_header) {
  expect_fault({"", "grid.header", "line 1, column 1"});
  expect_fault({"type octile\nheight 2\n", "grid.header", "line 2, column 9"});
  expect_fault({"type octile\nheight 2\nmap\n..\n..\n", "grid.header", "line 3, column 1"});
  expect_fault({"height 0\nwidth 1\nmap\n", "grid.header", "line 1, column 8"});
  expect_fault({"height 16385\nwidth 1\nmap\n", "grid.header", "line 1, column 8"});
  expect_fault({"height 99999999999999999999\nwidth 1\nmap\n", "grid.header", "line 1, column 8"});
  expect_fault({"height 1\nwidth -1\nmap\n.\n", "grid.header", "line 2, column 7"});
  expect_fault({"height 1\nwidth 1 1\nmap\n.\n", "grid.header", "line 2, column 7"});
  expect_fault({"height 1\nbreadth 1\nmap\n.\n", "grid.header", "line 2, column 1"});
  expect_fault({"height\n", "grid.header", "line 1, column 1"});
}

TEST(Grid, names_the_line_of_a_row_with_another_length_and_the_column_where_it_differs) {
  expect_fault({"height 2\nwidth 2\nmap\n..\n.\n", "grid.row", "line 5, column 2"});
  expect_fault({"height 2\nwidth 2\nmap\n...\n..\n", "grid.row", "line 4, column 3"});
}

TEST(Grid, has_as_many_rows_as_stated) {
  expect_fault({"height 2\nwidth 2\nmap\n..\n", "grid.row", "line 4, column 3"});
  expect_fault({"height 1\nwidth 2\nmap\n..\n\n..\n", "grid.row", "line 6, column 1"});
}

TEST(Grid, refuses_characters_that_are_no_squares) {
  expect_fault({"height 1\nwidth 2\nmap\n.x\n", "grid.character", "line 4, column 2"});
  EXPECT_THAT(read_grid("height 1\nwidth 2\nmap\n.x\n").error().message, HasSubstr("x"));
}

}  // namespace
}  // namespace cosiva::zone
