#pragma once

#include <algorithm>
#include <set>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/planning/floor/floor.h"
#include "cosiva/planning/floor/grid.h"

/// Floors and fleets for tests, and a checker of paths that has no code in common with Reservations.
namespace cosiva::planning::fixture {

/// A floor with its description.
struct TestFloor {
  FloorDescription description;
  Floor floor;

  explicit TestFloor(FloorDescription made) : description{std::move(made)}, floor{*Floor::make(description)} {}
};

/// The squares of an open rectangle, or with some of them blocked; goal q is square q.
inline Grid open_grid(std::uint32_t width, std::uint32_t height) {
  return {width, height, std::vector<std::uint8_t>(std::size_t{width} * height, 1)};
}

inline Grid random_grid(Random& random, std::uint32_t width, std::uint32_t height, double blocked) {
  Grid grid = open_grid(width, height);
  for (auto& square : grid.free) square = random.chance(blocked) ? 0 : 1;
  return grid;
}

/// States with footprints of one to three cells, two-way and one-way moves, some of which sweep further cells, and one
/// goal per state.
inline TestFloor random_floor(Random& random) {
  FloorDescription floor;
  const auto states = static_cast<std::uint32_t>(4 + random.below(10));
  floor.cells = states + 4;
  const auto some_cell = [&] { return static_cast<CellId>(random.below(floor.cells)); };
  floor.states.resize(states);
  for (StateId state = 0; state < states; ++state) {
    auto& footprint = floor.states[state].footprint;
    footprint.push_back(state);
    while (random.chance(0.4) && footprint.size() < 3) footprint.push_back(some_cell());
    floor.goals.push_back({state});
  }
  const auto connect = [&](StateId from, StateId to) {
    auto& moves = floor.states[from].moves;
    if (from == to || std::ranges::count(moves, to, &FloorDescription::Move::to) > 0) return;
    moves.push_back({to, {}});
    while (random.chance(0.25)) moves.back().sweep.push_back(some_cell());
  };
  for (StateId state = 0; state < states; ++state) {
    const auto to = static_cast<StateId>(random.below(states));
    connect(state, (state + 1) % states);
    connect(state, to);
    if (random.chance(0.7)) connect(to, state);
  }
  return TestFloor{std::move(floor)};
}

/// Up to `count` different states with moves, no two with a cell in common.
inline std::vector<StateId> random_fleet(const Floor& floor, Random& random, std::size_t count) {
  std::vector<StateId> fleet;
  std::set<CellId> occupied;
  for (std::size_t attempt = 0; attempt < 8 * count && fleet.size() < count; ++attempt) {
    const auto state = static_cast<StateId>(random.below(floor.states()));
    const auto cells = floor.footprint(state);
    if (floor.successors(state).empty()) continue;
    if (std::ranges::any_of(cells, [&](CellId cell) { return occupied.contains(cell); })) continue;
    occupied.insert(cells.begin(), cells.end());
    fleet.push_back(state);
  }
  return fleet;
}

/// Checks paths, one per vehicle, against the description of their floor. A path of one state is that of a vehicle that
/// has not been planned: only its present cells count, and only for sweeps.
class PathChecker {
 public:
  PathChecker(const FloorDescription& floor, bool cycles) : floor_{&floor}, cycles_{cycles} {}

  /// The first fault, in words; empty: there is none.
  [[nodiscard]] std::string fault(const std::vector<std::vector<StateId>>& paths) const {
    std::size_t steps = 1;
    for (const auto& path : paths) steps = std::max(steps, path.size());
    for (std::size_t step = 1; step < steps; ++step) {
      for (std::size_t a = 0; a < paths.size(); ++a) {
        if (paths[a].size() <= step) continue;
        if (!is_move(paths[a][step - 1], paths[a][step])) return text(step, a, a, "no move of the floor");
        for (std::size_t b = 0; b < paths.size(); ++b)
          if (a != b)
            if (auto what = contact(paths[a], paths[b], step); !what.empty()) return text(step, a, b, what);
      }
      if (exchange(paths, step)) return "step " + std::to_string(step) + ": vehicles change cells in a cycle";
    }
    return {};
  }

 private:
  using Cells = std::set<CellId>;

  static std::string text(std::size_t step, std::size_t a, std::size_t b, const std::string& what) {
    return "step " + std::to_string(step) + ", vehicles " + std::to_string(a) + " and " + std::to_string(b) + ": " +
           what;
  }
  [[nodiscard]] Cells cells(StateId state) const {
    const auto& footprint = floor_->states[state].footprint;
    return {footprint.begin(), footprint.end()};
  }
  [[nodiscard]] bool is_move(StateId from, StateId to) const {
    return from == to || std::ranges::count(floor_->states[from].moves, to, &FloorDescription::Move::to) > 0;
  }
  [[nodiscard]] Cells sweep(StateId from, StateId to) const {
    Cells swept;
    for (const auto& move : floor_->states[from].moves)
      if (move.to == to) swept.insert(move.sweep.begin(), move.sweep.end());
    for (const CellId cell : cells(from)) swept.erase(cell);
    for (const CellId cell : cells(to)) swept.erase(cell);
    return swept;
  }
  static bool meet(const Cells& a, const Cells& b) {
    return std::ranges::any_of(a, [&](CellId cell) { return b.contains(cell); });
  }
  [[nodiscard]] std::string contact(const std::vector<StateId>& a, const std::vector<StateId>& b,
                                    std::size_t step) const {
    const Cells swept = sweep(a[step - 1], a[step]);
    if (b.size() >= step && meet(swept, cells(b[step - 1]))) return "sweep and body before";
    if (b.size() <= step) return {};
    if (meet(cells(a[step]), cells(b[step]))) return "two bodies in one cell";
    if (meet(swept, cells(b[step]))) return "sweep and body after";
    if (meet(swept, sweep(b[step - 1], b[step]))) return "two sweeps";
    return {};
  }
  /// Vehicles are removed as long as one of them enters no cell of a vehicle that is left: the rest is in cycles.
  [[nodiscard]] bool exchange(const std::vector<std::vector<StateId>>& paths, std::size_t step) const {
    const auto enters = [&](std::size_t a, std::size_t b) {
      return a != b && paths[a].size() > step && paths[b].size() > step &&
             meet(cells(paths[a][step]), cells(paths[b][step - 1]));
    };
    std::vector<std::size_t> left;
    for (std::size_t a = 0; a < paths.size(); ++a) left.push_back(a);
    if (cycles_)
      return std::ranges::any_of(left, [&](std::size_t a) {
        return std::ranges::any_of(left, [&](std::size_t b) { return enters(a, b) && enters(b, a); });
      });
    const auto enters_none = [&](std::size_t a) {
      return std::ranges::none_of(left, [&](std::size_t b) { return enters(a, b); });
    };
    for (auto found = std::ranges::find_if(left, enters_none); found != left.end();
         found = std::ranges::find_if(left, enters_none))
      left.erase(found);
    return !left.empty();
  }

  const FloorDescription* floor_;
  bool cycles_;
};

/// The description from which grid_floor makes its floor, as far as paths are concerned.
inline FloorDescription description_of(const Floor& floor) {
  FloorDescription description;
  description.cells = floor.cells();
  for (StateId state = 0; state < floor.states(); ++state) {
    auto& made = description.states.emplace_back();
    made.footprint.assign(floor.footprint(state).begin(), floor.footprint(state).end());
    for (std::size_t move = 0; move < floor.successors(state).size(); ++move) {
      const auto sweep = floor.sweep(state, move);
      made.moves.push_back({floor.successors(state)[move], {sweep.begin(), sweep.end()}});
    }
  }
  for (GoalId goal = 0; goal < floor.goals(); ++goal)
    description.goals.emplace_back(floor.goal(goal).begin(), floor.goal(goal).end());
  return description;
}

inline TestFloor grid_test_floor(const Grid& grid, GridMotion motion = GridMotion::any_direction) {
  return TestFloor{description_of(grid_floor(grid, motion))};
}

}  // namespace cosiva::planning::fixture
