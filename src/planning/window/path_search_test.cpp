#include "cosiva/planning/window/path_search.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <optional>

#include "cosiva/planning/testing/test_floors.h"

namespace cosiva::planning {
namespace {

using testing::ElementsAre;
using Path = std::vector<StateId>;
constexpr std::uint32_t no_limit = 1000;

/// A fleet on a floor; the vehicle 0 has stops and no path yet.
struct Scene {
  fixture::TestFloor made;
  std::uint32_t horizon;
  Distances distances{made.floor};
  Reservations reservations{made.floor, horizon, false};
  PathSearch search{made.floor, horizon};
  std::vector<Path> paths;  // of one state each until planned
  Itinerary itinerary;

  Scene(fixture::TestFloor floor, std::uint32_t steps) : made{std::move(floor)}, horizon{steps} {}

  void begin(const std::vector<StateId>& fleet, const std::vector<Stop>& stops) {
    reservations.begin(fleet);
    paths.clear();
    for (const StateId state : fleet) paths.push_back({state});
    itinerary = {fleet[0], stops, made.floor, distances};
  }
  void add(Vehicle vehicle, const Path& path) {
    reservations.add(vehicle, path);
    paths[vehicle] = path;
  }
  [[nodiscard]] std::optional<Path> find(std::uint32_t limit) {
    Path path(horizon + std::size_t{1}, 0);
    if (!search.find(0, paths[0][0], itinerary, reservations, limit, path)) return std::nullopt;
    return path;
  }
};

TEST(PathSearch, drives_to_the_goal_on_a_shortest_path) {
  Scene scene{fixture::grid_test_floor(fixture::open_grid(4, 1)), 5};
  scene.begin({0}, {{3, 0}});
  EXPECT_THAT(*scene.find(no_limit), ElementsAre(0, 1, 2, 3, 3, 3));
  EXPECT_GT(scene.search.expansions(), 4U);
}

TEST(PathSearch, waits_at_each_stop_for_its_stay) {
  Scene scene{fixture::grid_test_floor(fixture::open_grid(3, 1)), 6};
  scene.begin({0}, {{1, 2}, {2, 0}});
  EXPECT_THAT(*scene.find(no_limit), ElementsAre(0, 1, 1, 1, 2, 2, 2));
}

TEST(PathSearch, evades_the_paths_of_others) {
  // The other vehicle comes from square 2 to square 0: this one waits in the bay (square 4) below square 1.
  Grid grid = fixture::open_grid(3, 2);
  grid.free[3] = grid.free[5] = 0;
  Scene scene{fixture::grid_test_floor(grid), 5};
  scene.begin({1, 2}, {{2, 0}});
  scene.add(1, {2, 1, 0, 0, 0, 0});
  EXPECT_THAT(*scene.find(no_limit), ElementsAre(1, 4, 1, 2, 2, 2));
}

TEST(PathSearch, finds_nothing_that_costs_as_much_as_the_limit) {
  Scene scene{fixture::grid_test_floor(fixture::open_grid(4, 1)), 5};
  scene.begin({0}, {{3, 0}});
  EXPECT_FALSE(scene.find(3));
  EXPECT_TRUE(scene.find(4));
}

TEST(PathSearch, without_stops_moves_only_to_make_room) {
  Scene scene{fixture::grid_test_floor(fixture::open_grid(4, 1)), 3};
  scene.begin({1, 0}, {});
  EXPECT_THAT(*scene.find(no_limit), ElementsAre(1, 1, 1, 1));
  scene.add(1, {0, 0, 1, 2});
  const auto path = scene.find(no_limit);
  ASSERT_TRUE(path);
  EXPECT_EQ(path->back(), 3U);
}

/// All paths that the checker permits and that respect stays; the least cost of them.
class AllPaths {
 public:
  explicit AllPaths(Scene& scene) : scene_{&scene}, checker_{scene.made.description, false} {}

  [[nodiscard]] std::uint32_t least_cost() {
    Path path{scene_->paths[0][0]};
    extend(path, scene_->itinerary.start(path[0]));
    return least_;
  }

 private:
  void extend(Path& path, Itinerary::Progress progress) {
    auto paths = scene_->paths;
    paths[0] = path;
    for (auto& other : paths) other.resize(std::min(other.size(), path.size()));
    if (path.size() > 1 && !checker_.fault(paths).empty()) return;
    if (path.size() == scene_->horizon + std::size_t{1}) {
      least_ = std::min(least_, cost(path));
      return;
    }
    const StateId at = path.back();
    std::vector<StateId> next{at};
    if (!Itinerary::staying(progress))
      for (const StateId to : scene_->made.floor.successors(at)) next.push_back(to);
    for (const StateId to : next) {
      path.push_back(to);
      extend(path, scene_->itinerary.next(progress, to));
      path.pop_back();
    }
  }
  [[nodiscard]] std::uint32_t cost(const Path& path) const {
    if (!scene_->itinerary.idle()) return scene_->itinerary.cost(path);
    std::uint32_t moves = 0;
    for (std::size_t step = 1; step < path.size(); ++step) moves += path[step] != path[step - 1] ? 1U : 0U;
    return moves;
  }

  Scene* scene_;
  fixture::PathChecker checker_;
  std::uint32_t least_{0xFFFFFFFF};

 public:
  [[nodiscard]] std::uint32_t cost_of(const Path& path) const { return cost(path); }
};

void compare_with_all_paths(fixture::TestFloor made, Random& random) {
  Scene scene{std::move(made), 4};
  const auto fleet = fixture::random_fleet(scene.made.floor, random, 4);
  if (fleet.empty()) return;
  std::vector<Stop> stops;
  for (std::uint64_t count = random.below(4); count > 0; --count)
    stops.push_back(
        {static_cast<GoalId>(random.below(scene.made.floor.goals())), static_cast<std::uint32_t>(random.below(3))});
  scene.begin(fleet, stops);
  for (Vehicle vehicle = 1; vehicle < fleet.size(); ++vehicle) {
    Path path{fleet[vehicle]};
    while (path.size() <= scene.horizon) {
      const auto successors = scene.made.floor.successors(path.back());
      const std::uint64_t choice = random.below(successors.size() + 1);
      const StateId to = choice == successors.size() ? path.back() : successors[choice];
      const auto step = static_cast<std::uint32_t>(path.size());
      const bool good = scene.reservations.permits(vehicle, path.back(), to, step);
      path.push_back(good ? to : path.back());
    }
    std::vector<Conflict> conflicts;
    scene.reservations.conflicts(vehicle, path, 9, conflicts);
    if (conflicts.empty()) scene.add(vehicle, path);
  }
  AllPaths all{scene};
  const std::uint32_t least = all.least_cost();
  const auto path = scene.find(no_limit);
  // Costs far above the least possible one mean that the goal cannot be reached any more: both may differ there.
  RC_ASSERT(path.has_value() == (least < no_limit));
  if (!path) return;
  RC_ASSERT(all.cost_of(*path) == least);
  RC_ASSERT(!scene.find(least));
  auto paths = scene.paths;
  paths[0] = *path;
  const fixture::PathChecker checker{scene.made.description, false};
  RC_ASSERT(checker.fault(paths) == "");
}

TEST(PathSearch, finds_the_best_of_all_paths_on_random_floors) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "test"};
    compare_with_all_paths(fixture::random_floor(random), random);
  }));
}

TEST(PathSearch, finds_the_best_of_all_paths_on_grids) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "test"};
    compare_with_all_paths(fixture::grid_test_floor(fixture::random_grid(random, 4, 2, 0.1)), random);
  }));
}

}  // namespace
}  // namespace cosiva::planning
