#include "cosiva/planning/assignment/least_cost.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::planning {
namespace {

constexpr std::size_t side_max = std::size_t{1} << 20U;
// More than any sum of permitted costs in which one pair replaces another one, so that a forbidden pair is chosen last;
// the sum of all potentials remains far below 2⁶³ for as many rows as one can store.
constexpr std::int64_t forbidden_price = std::int64_t{1} << 45U;

/// One search after the other, each of which adds a row to the assignment. Rows are not more than columns; row and
/// column 0 mean none.
/// Invariant: potentials are feasible (no reduced cost is negative), and zero reduced cost holds for assigned pairs.
class AugmentingPaths {
 public:
  AugmentingPaths(const CostTable& table, bool transposed)
      : table_{&table},
        transposed_{transposed},
        rows_{transposed ? table.columns : table.rows},
        columns_{transposed ? table.rows : table.columns},
        row_potential_(rows_ + 1, 0),
        column_potential_(columns_ + 1, 0),
        row_of_(columns_ + 1, 0),
        before_(columns_ + 1, 0) {}

  void solve() {
    for (std::size_t row = 1; row <= rows_; ++row) add_row(row);
  }
  [[nodiscard]] std::size_t columns() const { return columns_; }
  /// Of a column, from 1: its row, or 0.
  [[nodiscard]] std::size_t row_of(std::size_t column) const { return row_of_[column]; }

 private:
  [[nodiscard]] std::int64_t reduced_cost(std::size_t row, std::size_t column) const {
    const std::int64_t cost = transposed_ ? table_->at(column - 1, row - 1) : table_->at(row - 1, column - 1);
    return std::min(cost, forbidden_price) - row_potential_[row] - column_potential_[column];
  }
  void add_row(std::size_t row) {
    row_of_[0] = row;
    least_.assign(columns_ + 1, std::numeric_limits<std::int64_t>::max());
    is_examined_.assign(columns_ + 1, 0);
    std::size_t column = 0;
    do column = examine(column);
    while (row_of_[column] != 0);
    for (; column != 0; column = before_[column]) row_of_[column] = row_of_[before_[column]];
  }
  /// Enters the column's row into the tree of shortest paths; the nearest column that is not examined.
  std::size_t examine(std::size_t column) {
    is_examined_[column] = 1;
    const std::size_t row = row_of_[column];
    std::int64_t nearest = std::numeric_limits<std::int64_t>::max();
    std::size_t next = 0;
    for (std::size_t j = 1; j <= columns_; ++j) {
      if (is_examined_[j] != 0) continue;
      if (const std::int64_t cost = reduced_cost(row, j); cost < least_[j]) {
        least_[j] = cost;
        before_[j] = column;
      }
      if (least_[j] < nearest) {
        nearest = least_[j];
        next = j;
      }
    }
    COSIVA_EXPECT(next != 0);
    for (std::size_t j = 0; j <= columns_; ++j) {
      if (is_examined_[j] == 0) {
        least_[j] -= nearest;
        continue;
      }
      row_potential_[row_of_[j]] += nearest;
      column_potential_[j] -= nearest;
    }
    return next;
  }

  const CostTable* table_;
  bool transposed_;
  std::size_t rows_;
  std::size_t columns_;
  std::vector<std::int64_t> row_potential_;
  std::vector<std::int64_t> column_potential_;
  std::vector<std::size_t> row_of_;  // by column
  std::vector<std::size_t> before_;  // by column: the one before on the shortest path
  std::vector<std::int64_t> least_;  // by column: length of the shortest path
  std::vector<std::uint8_t> is_examined_;
};

}  // namespace

std::vector<std::size_t> least_cost_assignment(const CostTable& table) {
  COSIVA_EXPECT(table.costs.size() == table.rows * table.columns);
  COSIVA_EXPECT(table.rows <= side_max && table.columns <= side_max);
  COSIVA_EXPECT(std::ranges::all_of(table.costs, [](std::int64_t cost) {
    return cost == forbidden_cost || (cost >= -cost_max && cost <= cost_max);
  }));
  std::vector<std::size_t> assignment(table.rows, unassigned);
  const bool transposed = table.rows > table.columns;
  AugmentingPaths paths{table, transposed};
  paths.solve();
  for (std::size_t column = 1; column <= paths.columns(); ++column) {
    if (paths.row_of(column) == 0) continue;
    const std::size_t row = transposed ? column - 1 : paths.row_of(column) - 1;
    const std::size_t partner = transposed ? paths.row_of(column) - 1 : column - 1;
    if (table.at(row, partner) != forbidden_cost) assignment[row] = partner;
  }
  return assignment;
}

}  // namespace cosiva::planning
