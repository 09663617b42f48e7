#pragma once

#include <cstdint>

#include "cosiva/planning/floor/floor.h"
#include "cosiva/zone/grid/grid.h"

namespace cosiva::planning {

using zone::Grid;
using zone::read_grid;

/// How a vehicle moves on a grid, one action per step.
enum class GridMotion : std::uint8_t {
  any_direction,  ///< to one of four neighbours, as in most MAPF benchmarks
  forward_turn,   ///< forward, or a turn of 90 degrees on the spot, as in the League of Robot Runners
};

/// The floor of a grid: one cell and one goal per square, free or not, with the square's number. With `any_direction`
/// the state of a square has its number; with `forward_turn` square q has the states 4q (east), 4q + 1 (south, towards
/// the next row), 4q + 2 (west), 4q + 3 (north). States of blocked squares have no moves to or from them.
[[nodiscard]] Floor grid_floor(const Grid& grid, GridMotion motion);

}  // namespace cosiva::planning
