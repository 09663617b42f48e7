#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"

namespace cosiva::zone {

/// A rectangle of equal squares, free or blocked: a MovingAI map (Sturtevant 2012, "Benchmarks for Grid-Based
/// Pathfinding"), as the MAPF benchmarks use them. Squares are numbered row by row from the first line's first.
struct Grid {
  std::uint32_t width{};
  std::uint32_t height{};
  std::vector<std::uint8_t> free;  ///< width × height, row by row; 1: a vehicle may be there
  /// Ascending: the squares at which loads are picked up or delivered, E and S of the League of Robot Runners' maps. A
  /// map without E has none: there S is a swamp.
  std::vector<std::uint32_t> stops{};

  [[nodiscard]] bool is_free(std::uint32_t x, std::uint32_t y) const noexcept {
    return x < width && y < height && free[y * width + x] != 0;
  }
};

/// Reads a MovingAI map: the lines "type …", "height N", "width N" and "map", then one line per row. Free squares are a
/// dot, G and S (and E, of the League of Robot Runners' maps); an at sign, O, T and W are blocked.
/// Fails ("grid.header", "grid.row", "grid.character") and names line and column ("line 4, column 2").
[[nodiscard]] Result<Grid> read_grid(std::string_view text);

}  // namespace cosiva::zone
