#include "cosiva/planning/floor/distances.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <numeric>

#include "cosiva/base/random.h"
#include "cosiva/base/test_property.h"

namespace cosiva::planning {
namespace {

/// A floor of one-way moves between states that have a cell each, and one goal of one or two states per state.
FloorDescription random_floor(std::uint32_t states, std::uint64_t seed) {
  Random random{seed, "floor"};
  FloorDescription floor;
  floor.cells = states;
  for (StateId state = 0; state < states; ++state) {
    floor.states.push_back({{state}, {}});
    for (StateId to = 0; to < states; ++to)
      if (to != state && random.chance(0.15)) floor.states.back().moves.push_back({to, {}});
    floor.goals.push_back({state, static_cast<StateId>(random.below(states))});
  }
  return floor;
}

/// Floyd 1962, "Algorithm 97: Shortest Path".
std::vector<std::vector<std::uint32_t>> all_distances(const FloorDescription& floor) {
  const std::size_t n = floor.states.size();
  std::vector<std::vector<std::uint32_t>> least(n, std::vector<std::uint32_t>(n, Distances::unreachable));
  for (std::size_t i = 0; i < n; ++i) {
    least[i][i] = 0;
    for (const auto& move : floor.states[i].moves) least[i][move.to] = 1;
  }
  for (std::size_t k = 0; k < n; ++k)
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j) least[i][j] = std::min(least[i][j], least[i][k] + least[k][j]);
  return least;
}

TEST(Distances, are_those_of_floyds_and_warshalls_algorithm) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    const auto states = *rc::gen::inRange<std::uint32_t>(1, 25);
    const FloorDescription description = random_floor(states, seed);
    const auto floor = Floor::make(description);
    const auto least = all_distances(description);
    Distances distances{*floor};
    for (GoalId goal = 0; goal < floor->goals(); ++goal) {
      const Distances::Steps* const to = distances.to(goal);
      for (StateId state = 0; state < floor->states(); ++state) {
        std::uint32_t expected = Distances::unreachable;
        for (const StateId end : floor->goal(goal)) expected = std::min(expected, least[state][end]);
        RC_ASSERT(to[state] == expected);
      }
    }
  }));
}

TEST(Distances, are_the_same_when_only_one_table_has_room) {
  const auto floor = Floor::make(random_floor(20, 3));
  Distances all{*floor};
  Distances one{*floor, 1};
  EXPECT_EQ(one.tables_max(), 1U);
  for (int round = 0; round < 2; ++round)
    for (GoalId goal = 0; goal < floor->goals(); ++goal)
      EXPECT_TRUE(
          std::ranges::equal(std::span{all.to(goal), floor->states()}, std::span{one.to(goal), floor->states()}));
}

TEST(Distances, stay_valid_until_as_many_other_goals_as_have_room) {
  const auto floor = Floor::make(random_floor(10, 4));
  Distances distances{*floor, 3 * 10 * sizeof(Distances::Steps)};
  ASSERT_EQ(distances.tables_max(), 3U);
  const auto* const first = distances.to(0);
  const std::vector<Distances::Steps> before(first, first + 10);
  (void)distances.to(1);
  (void)distances.to(2);
  EXPECT_EQ(distances.to(0), first);
  (void)distances.to(3);
  (void)distances.to(4);
  EXPECT_TRUE(std::equal(before.begin(), before.end(), first));
}

TEST(Distances, beyond_65534_moves_are_unreachable) {
  constexpr std::uint32_t length = 70'000;
  FloorDescription line;
  line.cells = 1;
  line.states.resize(length, {{0}, {}});
  for (StateId state = 1; state < length; ++state) line.states[state].moves.push_back({state - 1, {}});
  line.goals = {{0}};
  const auto floor = Floor::make(line);
  Distances distances{*floor};
  EXPECT_EQ(distances.to(0)[65'534], 65'534);
  EXPECT_EQ(distances.to(0)[65'535], Distances::unreachable);
  EXPECT_EQ(distances.to(0)[69'999], Distances::unreachable);
}

}  // namespace
}  // namespace cosiva::planning
