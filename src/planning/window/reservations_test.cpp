#include "cosiva/planning/window/reservations.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>

#include "cosiva/planning/testing/test_floors.h"

namespace cosiva::planning {
namespace {

using testing::ElementsAre;
using Path = std::vector<StateId>;

auto is_conflict(Vehicle vehicle, std::uint32_t step) {
  return testing::AllOf(testing::Field(&Conflict::vehicle, vehicle), testing::Field(&Conflict::step, step));
}

/// Squares of 3 × 2:  0 1 2
///                    3 4 5
struct SixSquares {
  Floor floor = grid_floor(fixture::open_grid(3, 2), GridMotion::any_direction);
  Reservations reservations;

  explicit SixSquares(const std::vector<Path>& paths, bool cycles = false) : reservations{floor, 2, cycles} {
    std::vector<StateId> present;
    for (const Path& path : paths) present.push_back(path[0]);
    reservations.begin(present);
    for (Vehicle vehicle = 0; vehicle < paths.size(); ++vehicle)
      if (paths[vehicle].size() > 1) reservations.add(vehicle, paths[vehicle]);
  }
};

TEST(Reservations, name_the_vehicle_in_each_cell_and_step) {
  SixSquares squares{{{0, 1, 1}, {2}}};
  const Reservations& reservations = squares.reservations;
  EXPECT_EQ(reservations.owner(0, 0), 0U);
  EXPECT_EQ(reservations.owner(0, 2), 1U);
  EXPECT_EQ(reservations.owner(1, 1), 0U);
  EXPECT_EQ(reservations.owner(1, 0), no_vehicle);
  EXPECT_EQ(reservations.owner(1, 2), no_vehicle);
  EXPECT_TRUE(reservations.has_path(0));
  EXPECT_FALSE(reservations.has_path(1));
  EXPECT_THAT(reservations.path(0), ElementsAre(0, 1, 1));
}

TEST(Reservations, forget_a_path_that_is_removed_but_not_the_present) {
  SixSquares squares{{{0, 1, 1}, {2}}};
  squares.reservations.remove(0);
  EXPECT_EQ(squares.reservations.owner(1, 1), no_vehicle);
  EXPECT_EQ(squares.reservations.owner(0, 0), 0U);
  EXPECT_TRUE(squares.reservations.permits(1, 2, 1, 1));
}

TEST(Reservations, begin_again_without_traces_of_the_paths_before) {
  SixSquares squares{{{0, 1, 1}, {2, 2, 5}}};
  squares.reservations.begin(std::array<StateId, 1>{4});
  EXPECT_EQ(squares.reservations.vehicles(), 1U);
  for (CellId cell = 0; cell < 6; ++cell)
    for (std::uint32_t step = 0; step <= 2; ++step)
      EXPECT_EQ(squares.reservations.owner(step, cell), cell == 4 && step == 0 ? 0U : no_vehicle);
}

TEST(Reservations, refuse_a_cell_that_another_vehicle_is_in) {
  SixSquares squares{{{0, 1, 1}, {2}}};
  EXPECT_FALSE(squares.reservations.permits(1, 2, 1, 1));
  EXPECT_FALSE(squares.reservations.permits(1, 2, 1, 2));
  EXPECT_TRUE(squares.reservations.permits(1, 2, 5, 1));
}

TEST(Reservations, permit_to_follow_a_vehicle_that_leaves) {
  SixSquares squares{{{1, 2, 2}, {0}}};
  EXPECT_TRUE(squares.reservations.permits(1, 0, 1, 1));
}

TEST(Reservations, refuse_that_two_vehicles_change_cells) {
  for (const bool cycles : {false, true}) {
    SixSquares squares{{{0, 1, 1}, {1}}, cycles};
    EXPECT_FALSE(squares.reservations.permits(1, 1, 0, 1));
    EXPECT_TRUE(squares.reservations.permits(1, 1, 4, 1));
  }
}

TEST(Reservations, permit_a_cycle_of_four_only_on_request) {
  const std::vector<Path> paths{{0, 1, 1}, {1, 4, 4}, {4, 3, 3}, {3}};
  EXPECT_FALSE((SixSquares{paths, false}.reservations.permits(3, 3, 0, 1)));
  EXPECT_TRUE((SixSquares{paths, true}.reservations.permits(3, 3, 0, 1)));
}

TEST(Reservations, list_each_conflict_once_with_its_first_step) {
  SixSquares squares{{{0, 1, 1}, {5, 4, 4}, {2}}};
  std::vector<Conflict> found;
  squares.reservations.conflicts(2, Path{2, 1, 4}, 9, found);
  EXPECT_THAT(found, ElementsAre(is_conflict(0, 1), is_conflict(1, 2)));
}

TEST(Reservations, list_one_conflict_more_than_the_limit_at_most) {
  SixSquares squares{{{0, 1, 1}, {5, 4, 4}, {2}}};
  std::vector<Conflict> found;
  squares.reservations.conflicts(2, Path{2, 1, 4}, 0, found);
  EXPECT_THAT(found, ElementsAre(is_conflict(0, 1)));
}

/// State 0 leads to state 1 and sweeps cell 2 (of state 2), which one can leave to state 3 (cell 3); state 4 leads to
/// state 5 and sweeps cell 2, too.
Floor sweeping_floor() {
  FloorDescription floor;
  floor.cells = 6;
  floor.states = {{{0}, {{1, {2}}}}, {{1}, {}}, {{2}, {{3, {}}}}, {{3}, {{2, {}}}}, {{4}, {{5, {2}}}}, {{5}, {}}};
  return *Floor::make(floor);
}

TEST(Reservations, refuse_to_sweep_a_cell_that_another_vehicle_leaves_or_enters_in_this_step) {
  const Floor floor = sweeping_floor();
  for (const Path& other : {Path{2, 2}, Path{2, 3}, Path{3, 2}}) {
    Reservations reservations{floor, 1, false};
    reservations.begin(std::array<StateId, 2>{0, other[0]});
    reservations.add(1, other);
    EXPECT_FALSE(reservations.permits(0, 0, 1, 1));
    EXPECT_TRUE(reservations.permits(0, 0, 0, 1));
    reservations.remove(1);
    reservations.add(0, Path{0, 1});
    EXPECT_FALSE(reservations.permits(1, other[0], other[1], 1));
  }
}

TEST(Reservations, refuse_to_sweep_a_cell_that_another_vehicle_sweeps) {
  const Floor floor = sweeping_floor();
  Reservations reservations{floor, 1, false};
  reservations.begin(std::array<StateId, 2>{0, 4});
  reservations.add(0, Path{0, 1});
  EXPECT_FALSE(reservations.permits(1, 4, 5, 1));
}

TEST(Reservations, refuse_to_sweep_the_present_cell_of_a_vehicle_without_path) {
  const Floor floor = sweeping_floor();
  Reservations reservations{floor, 2, false};
  reservations.begin(std::array<StateId, 2>{0, 2});
  EXPECT_FALSE(reservations.permits(0, 0, 1, 1));
  EXPECT_TRUE(reservations.permits(0, 0, 1, 2));
}

/// A path of random moves and waits.
Path random_walk(const Floor& floor, StateId at, std::uint32_t steps, Random& random) {
  Path path{at};
  while (path.size() <= steps) {
    const auto successors = floor.successors(path.back());
    const std::uint64_t choice = random.below(successors.size() + 1);
    path.push_back(choice == successors.size() ? path.back() : successors[choice]);
  }
  return path;
}

/// The reservations refuse a path exactly where the checker finds a fault in it.
void compare_with_checker(const fixture::TestFloor& made, Random& random, bool cycles) {
  constexpr std::uint32_t horizon = 3;
  const auto fleet = fixture::random_fleet(made.floor, random, 6);
  const fixture::PathChecker checker{made.description, cycles};
  Reservations reservations{made.floor, horizon, cycles};
  reservations.begin(fleet);
  std::vector<Path> paths;
  for (const StateId state : fleet) paths.push_back({state});
  for (int round = 0; round < 30 && !fleet.empty(); ++round) {
    const auto vehicle = static_cast<Vehicle>(random.below(fleet.size()));
    if (reservations.has_path(vehicle)) {
      reservations.remove(vehicle);
      paths[vehicle].resize(1);
    }
    auto with_it = paths;
    with_it[vehicle] = random_walk(made.floor, fleet[vehicle], horizon, random);
    std::vector<Conflict> conflicts;
    reservations.conflicts(vehicle, with_it[vehicle], 99, conflicts);
    bool permitted = true;
    for (std::uint32_t step = 1; step <= horizon; ++step)
      permitted &= reservations.permits(vehicle, with_it[vehicle][step - 1], with_it[vehicle][step], step);
    RC_ASSERT(permitted == conflicts.empty());
    const std::string fault = checker.fault(with_it);
    if (permitted != fault.empty()) RC_FAIL("permitted: " + std::to_string(permitted) + ", fault: " + fault);
    if (!permitted) continue;
    paths = with_it;
    reservations.add(vehicle, paths[vehicle]);
  }
}

TEST(Reservations, permit_what_an_independent_checker_permits_on_random_floors) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed, bool cycles) {
    Random random{seed, "test"};
    compare_with_checker(fixture::random_floor(random), random, cycles);
  }));
}

TEST(Reservations, permit_what_an_independent_checker_permits_on_grids) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed, bool cycles) {
    Random random{seed, "test"};
    compare_with_checker(fixture::grid_test_floor(fixture::open_grid(3, 2)), random, cycles);
  }));
}

/// Bodies of many cells, each of which follows all others of the row before: there are as many chains as paths through
/// the rows, and each vehicle must be examined once only.
TEST(Reservations, examine_long_chains_of_wide_bodies_in_short_time) {
  constexpr std::uint32_t rows = 40;
  FloorDescription floor;
  floor.cells = 2 * 2 * (rows + 1);
  const auto cell = [](std::uint32_t row, std::uint32_t from, std::uint32_t to) { return 4 * row + 2 * from + to; };
  // The body (row, i) has its cells (row, i, 0) and (row, i, 1), and moves to (row + 1, 0, i) and (row + 1, 1, i).
  for (std::uint32_t row = 0; row <= rows; ++row)
    for (std::uint32_t i = 0; i < 2; ++i) floor.states.push_back({{cell(row, i, 0), cell(row, i, 1)}, {}});
  for (std::uint32_t row = 0; row < rows; ++row)
    for (std::uint32_t i = 0; i < 2; ++i) {
      floor.states[2 * row + i].moves.push_back({static_cast<StateId>(floor.states.size()), {}});
      floor.states.push_back({{cell(row + 1, 0, i), cell(row + 1, 1, i)}, {}});
    }
  const auto made = Floor::make(floor);
  ASSERT_TRUE(made);
  std::vector<StateId> present;
  for (StateId state = 0; state < 2 * rows; ++state) present.push_back(state);
  Reservations reservations{*made, 1, false};
  reservations.begin(present);
  for (Vehicle vehicle = 2; vehicle < 2 * rows; ++vehicle)
    reservations.add(vehicle, Path{vehicle, made->successors(vehicle)[0]});
  EXPECT_TRUE(reservations.permits(0, 0, made->successors(0)[0], 1));
}

}  // namespace
}  // namespace cosiva::planning
