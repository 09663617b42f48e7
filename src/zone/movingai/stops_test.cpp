#include "cosiva/zone/movingai/stops.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "cosiva/base/random.h"

namespace cosiva::zone {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using ::testing::SizeIs;

Grid grid_of(const std::vector<std::string>& rows) {
  std::string text =
      "height " + std::to_string(rows.size()) + "\nwidth " + std::to_string(rows.front().size()) + "\nmap\n";
  for (const std::string& row : rows) text += row + "\n";
  auto grid = read_grid(text);
  EXPECT_TRUE(grid);
  return *grid;
}

TEST(Stops, are_at_the_ends_of_a_corridor) { EXPECT_THAT(distributed_stops(grid_of({"....."}), 9), ElementsAre(0, 4)); }

TEST(Stops, leave_a_square_next_to_each_of_them) {
  // With both ends of three squares as stops the one between them is next to both.
  EXPECT_THAT(distributed_stops(grid_of({"..."}), 9), ElementsAre(0, 2));
  EXPECT_THAT(distributed_stops(grid_of({".."}), 9), SizeIs(1));
  EXPECT_THAT(distributed_stops(grid_of({"."}), 9), IsEmpty());
}

TEST(Stops, are_in_the_largest_part) {
  EXPECT_THAT(distributed_stops(grid_of({"..@...", "..@...", "..@@@."}), 0), IsEmpty());
  for (const std::uint32_t stop : distributed_stops(grid_of({"..@...", "..@...", "..@@@."}), 9))
    EXPECT_GE(stop % 6, 3U);
}

TEST(Stops, are_as_many_as_requested_where_there_is_room) {
  EXPECT_THAT(distributed_stops(grid_of({"....", "....", "....", "...."}), 3), SizeIs(3));
}

TEST(Stops, leave_the_other_squares_connected) {
  Random random{3, "stops"};
  std::size_t stops_in_all = 0;
  for (int round = 0; round < 200; ++round) {
    Grid grid{8, 7, std::vector<std::uint8_t>(56)};
    for (auto& square : grid.free) square = random.chance(0.7) ? 1 : 0;
    const auto part = connected_squares(grid).front();
    const auto stops = distributed_stops(grid, 56);
    stops_in_all += stops.size();
    Grid open{8, 7, std::vector<std::uint8_t>(56)};
    for (const std::uint32_t square : part) open.free[square] = 1;
    for (const std::uint32_t stop : stops) {
      EXPECT_TRUE(std::ranges::binary_search(part, stop));
      open.free[stop] = 0;
    }
    EXPECT_THAT(connected_squares(open), SizeIs(part.empty() ? 0U : 1U));
    for (const std::uint32_t stop : stops) {
      const std::uint32_t x = stop % 8;
      const std::uint32_t y = stop / 8;
      EXPECT_TRUE(open.is_free(x + 1, y) || open.is_free(x - 1, y) || open.is_free(x, y + 1) || open.is_free(x, y - 1));
    }
  }
  EXPECT_GT(stops_in_all, 1000U);
}

TEST(ConnectedSquares, are_the_parts_of_a_grid_the_largest_first) {
  EXPECT_THAT(connected_squares(grid_of({".@..", "@@..", ".@@@"})),
              ElementsAre(ElementsAre(2, 3, 6, 7), ElementsAre(0), ElementsAre(8)));
  EXPECT_THAT(connected_squares(grid_of({"@"})), IsEmpty());
}

}  // namespace
}  // namespace cosiva::zone
