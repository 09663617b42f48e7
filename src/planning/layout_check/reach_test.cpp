#include "cosiva/planning/layout_check/reach.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>

namespace cosiva::planning {
namespace {

using ::testing::ElementsAre;

/// States 0 → 1 → 2 → 3, each with its own cell; the move from 1 to 2 sweeps cell 4.
Floor row() {
  FloorDescription description;
  description.cells = 5;
  description.states = {{{0}, {{1, {}}}}, {{1}, {{2, {4}}}}, {{2}, {{3, {}}}}, {{3}, {}}};
  return *Floor::make(description);
}

constexpr std::array<StateId, 1> first{0};
constexpr std::array<StateId, 1> last{3};

TEST(Reach, finds_what_is_reached_from_a_state_and_what_reaches_it) {
  const Floor floor = row();
  Reach reach{floor};
  EXPECT_THAT(reach.from(first), ElementsAre(1, 1, 1, 1));
  EXPECT_THAT(reach.from(last), ElementsAre(0, 0, 0, 1));
  EXPECT_THAT(reach.to(last), ElementsAre(1, 1, 1, 1));
  EXPECT_THAT(reach.to(first), ElementsAre(1, 0, 0, 0));
  EXPECT_EQ(reach.work(), 6U);
}

TEST(Reach, is_obstructed_by_vehicles_in_states_and_in_what_a_move_sweeps) {
  const Floor floor = row();
  Reach reach{floor};
  constexpr std::array<CellId, 1> swept{4};
  reach.occupy(swept);
  EXPECT_THAT(reach.from(first), ElementsAre(1, 1, 0, 0));
  EXPECT_THAT(reach.to(last), ElementsAre(0, 0, 1, 1));
  constexpr std::array<CellId, 1> state{1};
  reach.occupy(state);
  reach.occupy(state);
  reach.release(swept);
  reach.release(state);
  EXPECT_THAT(reach.from(first), ElementsAre(1, 0, 0, 0)) << "another vehicle is still there";
  reach.release(state);
  EXPECT_THAT(reach.from(first), ElementsAre(1, 1, 1, 1));
}

TEST(Reach, reaches_nothing_from_an_occupied_state) {
  const Floor floor = row();
  Reach reach{floor};
  constexpr std::array<CellId, 1> state{0};
  reach.occupy(state);
  EXPECT_THAT(reach.from(first), ElementsAre(0, 0, 0, 0));
}

TEST(Reach, counts_wanted_states_until_there_are_enough) {
  const Floor floor = row();
  Reach reach{floor};
  const Reach::Reached wanted{1, 1, 0, 1};
  EXPECT_EQ(reach.count(first, Reach::Direction::from, wanted, 9), 3U);
  EXPECT_EQ(reach.count(first, Reach::Direction::from, wanted, 2), 2U);
  EXPECT_EQ(reach.count(last, Reach::Direction::from, wanted, 9), 1U);
  EXPECT_EQ(reach.count(last, Reach::Direction::to, wanted, 9), 3U);
}

}  // namespace
}  // namespace cosiva::planning
