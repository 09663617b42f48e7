#include "cosiva/planning/search/configuration_search.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <set>
#include <vector>

#include "cosiva/planning/testing/test_floors.h"

namespace cosiva::planning {
namespace {

using Configuration = std::vector<StateId>;

/// All configurations that a fleet can reach, by brute force: every combination of moves and waits is tried.
class Reachable {
 public:
  Reachable(const fixture::TestFloor& made, Configuration begin) : made_{made} {
    open_.push_back(begin);
    known_.insert(std::move(begin));
    while (!open_.empty()) {
      const Configuration from = open_.back();
      open_.pop_back();
      Configuration to = from;
      follow(from, to, 0);
    }
  }

  [[nodiscard]] bool contains_at(Vehicle vehicle, std::span<const StateId> goal) const {
    return std::ranges::any_of(
        known_, [&](const Configuration& one) { return std::ranges::find(goal, one[vehicle]) != goal.end(); });
  }

 private:
  void follow(const Configuration& from, Configuration& to, Vehicle vehicle) {
    if (vehicle < from.size()) {
      to[vehicle] = from[vehicle];
      follow(from, to, vehicle + 1);
      for (const auto& move : made_.description.states[from[vehicle]].moves) {
        to[vehicle] = move.to;
        follow(from, to, vehicle + 1);
      }
      to[vehicle] = from[vehicle];
      return;
    }
    std::vector<std::vector<StateId>> paths;
    for (Vehicle one = 0; one < from.size(); ++one) paths.push_back({from[one], to[one]});
    if (fixture::PathChecker{made_.description, false}.fault(paths).empty() && known_.insert(to).second)
      open_.push_back(to);
  }

  const fixture::TestFloor& made_;
  std::set<Configuration> known_;
  std::vector<Configuration> open_;
};

/// The first fault of the steps found, or an empty text.
std::string fault_of(const fixture::TestFloor& made, const Configuration& begin,
                     const std::vector<Configuration>& steps) {
  std::vector<std::vector<StateId>> paths;
  for (const StateId state : begin) paths.push_back({state});
  for (const Configuration& step : steps)
    for (std::size_t vehicle = 0; vehicle < step.size(); ++vehicle) paths[vehicle].push_back(step[vehicle]);
  return fixture::PathChecker{made.description, false}.fault(paths);
}

TEST(ConfigurationSearch, lets_two_vehicles_pass_each_other_at_a_side_track) {
  // Five squares in a row and one below the third.
  Grid grid{5, 2, {1, 1, 1, 1, 1, 0, 0, 1, 0, 0}};
  const auto made = fixture::grid_test_floor(grid);
  Distances distances{made.floor};
  ConfigurationSearch search{made.floor, distances, false};
  const Configuration begin{0, 4};
  ASSERT_EQ(search.find(begin, std::array<GoalId, 2>{4, 0}, 0, {}, 1'000), SearchResult::solved);
  EXPECT_EQ(fault_of(made, begin, search.steps()), "");
  EXPECT_EQ(search.steps().back()[0], 4U);
}

TEST(ConfigurationSearch, proves_that_vehicles_on_one_lane_cannot_change_their_order) {
  const auto made = fixture::grid_test_floor(fixture::open_grid(6, 1));
  Distances distances{made.floor};
  ConfigurationSearch search{made.floor, distances, false};
  EXPECT_EQ(search.find(Configuration{0, 3}, std::array<GoalId, 2>{5, 0}, 0, {}, 100'000), SearchResult::impossible);
}

TEST(ConfigurationSearch, is_undecided_when_its_budget_is_used_up) {
  const auto made = fixture::grid_test_floor(fixture::open_grid(6, 1));
  Distances distances{made.floor};
  ConfigurationSearch search{made.floor, distances, false};
  EXPECT_EQ(search.find(Configuration{0, 3}, std::array<GoalId, 2>{5, 0}, 0, {}, 5), SearchResult::undecided);
}

TEST(ConfigurationSearch, moves_no_vehicle_that_is_fixed) {
  // Squares 0 1 2 above 3 4 5 above 6 7 8; the path from 0 to 2 leads past the vehicle on 3.
  const auto made = fixture::grid_test_floor(fixture::open_grid(3, 3));
  Distances distances{made.floor};
  ConfigurationSearch search{made.floor, distances, false};
  const Configuration begin{0, 1, 3};
  const std::array<GoalId, 3> goals{2, no_goal, no_goal};
  EXPECT_EQ(search.find(begin, goals, 0, std::array<std::uint8_t, 3>{0, 1, 1}, 10'000), SearchResult::impossible);
  ASSERT_EQ(search.find(begin, goals, 0, std::array<std::uint8_t, 3>{0, 1, 0}, 10'000), SearchResult::solved);
  for (const auto& step : search.steps()) EXPECT_EQ(step[1], 1U);
}

TEST(ConfigurationSearch, finds_steps_exactly_where_a_brute_force_search_finds_some) {
  std::size_t impossible = 0;
  EXPECT_TRUE(rc::check([&impossible](std::uint64_t seed) {
    Random random{seed, "floor"};
    const std::uint64_t kind = random.below(3);
    const auto motion = kind == 1 ? GridMotion::forward_turn : GridMotion::any_direction;
    const auto made = kind == 2
                          ? fixture::random_floor(random)
                          : fixture::grid_test_floor(fixture::random_grid(random, kind == 1 ? 2 : 3, 2, 0.2), motion);
    const Configuration begin = fixture::random_fleet(made.floor, random, kind == 0 ? 3 : 2);
    RC_PRE(begin.size() >= 2U);
    std::vector<GoalId> goals;
    for (std::size_t i = 0; i < begin.size(); ++i)
      goals.push_back(static_cast<GoalId>(random.below(made.floor.goals())));
    Distances distances{made.floor};
    ConfigurationSearch search{made.floor, distances, false};
    const auto result = search.find(begin, goals, 0, {}, 3'000'000);
    const bool possible = Reachable{made, begin}.contains_at(0, made.floor.goal(goals[0]));
    RC_ASSERT(result == (possible ? SearchResult::solved : SearchResult::impossible));
    if (!possible) ++impossible;
    if (possible) {
      RC_ASSERT(fault_of(made, begin, search.steps()).empty());
      const Configuration& end = search.steps().empty() ? begin : search.steps().back();
      RC_ASSERT(distances.to(goals[0])[end[0]] == 0);
    }
  }));
  EXPECT_GT(impossible, 0U) << "both results have to occur";
}

}  // namespace
}  // namespace cosiva::planning
