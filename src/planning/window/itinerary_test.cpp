#include "cosiva/planning/window/itinerary.h"

#include <gtest/gtest.h>

#include <array>

#include "cosiva/planning/testing/test_floors.h"

namespace cosiva::planning {
namespace {

using Path = std::vector<StateId>;

/// Seven squares in a row.
struct Row {
  Floor floor = grid_floor(fixture::open_grid(7, 1), GridMotion::any_direction);
  Distances distances{floor};

  [[nodiscard]] Itinerary from(StateId at, const std::vector<Stop>& stops) { return {at, stops, floor, distances}; }
};

TEST(Itinerary, without_stops_is_done_at_once) {
  Row row;
  const Itinerary idle = row.from(3, {});
  EXPECT_TRUE(idle.idle());
  EXPECT_TRUE(idle.complete());
  EXPECT_TRUE(idle.done(idle.start(3)));
  EXPECT_EQ(idle.cost(Path{3, 4, 5}), 0U);
}

TEST(Itinerary, needs_the_distances_between_its_stops_and_its_stays) {
  Row row;
  const Itinerary itinerary = row.from(1, std::vector<Stop>{{4, 2}, {0, 0}, {6, 3}});
  EXPECT_EQ(itinerary.legs(), 3U);
  EXPECT_EQ(itinerary.remaining(itinerary.start(1), 1), 3U + 2U + 4U + 6U + 3U);
  EXPECT_EQ(itinerary.to_goal(itinerary.start(1), 1), 3U);
}

TEST(Itinerary, goes_on_after_the_last_step_of_a_stay) {
  Row row;
  const Itinerary itinerary = row.from(3, std::vector<Stop>{{4, 2}, {3, 0}});
  auto progress = itinerary.next(itinerary.start(3), 4);
  EXPECT_TRUE(Itinerary::staying(progress));
  EXPECT_EQ(itinerary.remaining(progress, 4), 3U);
  progress = itinerary.next(progress, 4);
  EXPECT_TRUE(Itinerary::staying(progress));
  EXPECT_EQ(itinerary.remaining(progress, 4), 2U);
  progress = itinerary.next(progress, 4);
  EXPECT_FALSE(Itinerary::staying(progress));
  EXPECT_EQ(itinerary.remaining(progress, 4), 1U);
  EXPECT_TRUE(itinerary.done(itinerary.next(progress, 3)));
}

TEST(Itinerary, begins_a_stay_anew_after_an_interruption) {
  Row row;
  const Itinerary itinerary = row.from(4, std::vector<Stop>{{4, 2}});
  EXPECT_EQ(itinerary.cost(Path{4, 4, 4}), 2U);
  EXPECT_EQ(itinerary.cost(Path{4, 4, 5, 4, 4, 4}), 5U);
}

TEST(Itinerary, passes_several_stops_without_stay_in_one_state) {
  Row row;
  const Itinerary itinerary = row.from(2, std::vector<Stop>{{2, 0}, {2, 0}, {3, 0}});
  EXPECT_EQ(itinerary.start(2).leg, 2U);
  EXPECT_EQ(itinerary.cost(Path{2, 3}), 1U);
}

TEST(Itinerary, costs_of_a_path_that_ends_before_are_a_bound_from_below) {
  Row row;
  const Itinerary itinerary = row.from(0, std::vector<Stop>{{5, 0}});
  EXPECT_EQ(itinerary.cost(Path{0, 1, 1, 2}), 6U);
  EXPECT_EQ(itinerary.end(Path{0, 1, 1, 2}), (Itinerary::Progress{0, 0}));
  EXPECT_EQ(itinerary.cost(Path{0, 0, 1, 2, 3, 4, 5, 5, 5}), 6U);
}

TEST(Itinerary, ends_before_the_first_stop_that_cannot_be_reached) {
  Grid grid = fixture::open_grid(7, 1);
  grid.free[4] = 0;
  const Floor floor = grid_floor(grid, GridMotion::any_direction);
  Distances distances{floor};
  const Itinerary itinerary{0, std::array{Stop{2, 0}, Stop{6, 0}, Stop{1, 0}}, floor, distances};
  EXPECT_FALSE(itinerary.complete());
  EXPECT_EQ(itinerary.legs(), 1U);
  EXPECT_EQ(itinerary.remaining(itinerary.start(0), 0), 2U);
  EXPECT_TRUE((Itinerary{0, std::array{Stop{5, 0}}, floor, distances}.idle()));
}

TEST(Itinerary, of_a_goal_with_several_states_leaves_from_the_best_one) {
  const Floor floor = grid_floor(fixture::open_grid(3, 1), GridMotion::forward_turn);
  Distances distances{floor};
  // East in the first square; east again in the last one; back: two turns and two moves.
  const Itinerary itinerary{0, std::array{Stop{2, 1}, Stop{0, 0}}, floor, distances};
  EXPECT_EQ(itinerary.remaining(itinerary.start(0), 0), 2U + 1U + 2U);
}

}  // namespace
}  // namespace cosiva::planning
