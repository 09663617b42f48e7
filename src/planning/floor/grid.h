#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "cosiva/planning/floor/floor.h"

namespace cosiva::planning {

/// A rectangle of equal squares, free or blocked: a MovingAI map (Sturtevant 2012, "Benchmarks for Grid-Based
/// Pathfinding"), as the MAPF benchmarks use them. Squares are numbered row by row from the first line's first.
struct Grid {
  std::uint32_t width{};
  std::uint32_t height{};
  std::vector<std::uint8_t> free;  ///< width × height, row by row; 1: a vehicle may be there

  [[nodiscard]] bool is_free(std::uint32_t x, std::uint32_t y) const noexcept {
    return x < width && y < height && free[y * width + x] != 0;
  }
};

/// Reads a MovingAI map: the lines "type …", "height N", "width N" and "map", then one line per row. Free squares are a
/// dot, G and S (and E, of the League of Robot Runners' maps); an at sign, O, T and W are blocked.
/// Fails ("grid.header", "grid.row", "grid.character") and names the line.
[[nodiscard]] Result<Grid> read_grid(std::string_view text);

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
