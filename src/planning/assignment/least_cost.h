#pragma once

#include <cstdint>
#include <limits>
#include <vector>

namespace cosiva::planning {

/// Costs of all pairs of a row and a column, row by row.
struct CostTable {
  std::size_t rows{};
  std::size_t columns{};
  std::vector<std::int64_t> costs;  ///< rows × columns, each `forbidden_cost` or from −cost_max to cost_max

  [[nodiscard]] std::int64_t at(std::size_t row, std::size_t column) const { return costs[row * columns + column]; }
};

inline constexpr std::int64_t cost_max = std::int64_t{1} << 26U;
inline constexpr std::int64_t forbidden_cost = std::numeric_limits<std::int64_t>::max();
inline constexpr std::size_t unassigned = std::numeric_limits<std::size_t>::max();

/// Gives each row at most one column and each column to at most one row: as many pairs as possible, and of those
/// assignments one with the least sum of costs (Kuhn 1955; shortest augmenting paths: Jonker and Volgenant 1987).
/// Takes O(n² m) for n ≤ m rows and columns, at most 2²⁰ of either. Same table: same assignment.
/// @return by row: its column, or `unassigned`
[[nodiscard]] std::vector<std::size_t> least_cost_assignment(const CostTable& table);

}  // namespace cosiva::planning
