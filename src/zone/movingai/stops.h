#pragma once

#include <cstdint>
#include <vector>

#include "cosiva/zone/grid/grid.h"

namespace cosiva::zone {

/// Squares of the largest part of a grid, distributed over it, such that with vehicles stopped at all of them the other
/// squares of the part remain connected, and each of them has one of those next to it. Ascending; fewer than `count`
/// where no more are found.
[[nodiscard]] std::vector<std::uint32_t> distributed_stops(const Grid& grid, std::size_t count);

/// The squares that a vehicle can drive to from each other, part by part, the largest first; each part ascending.
[[nodiscard]] std::vector<std::vector<std::uint32_t>> connected_squares(const Grid& grid);

}  // namespace cosiva::zone
