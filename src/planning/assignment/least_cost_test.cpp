#include "cosiva/planning/assignment/least_cost.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <numeric>
#include <set>

#include "cosiva/base/random.h"

namespace cosiva::planning {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

struct Sum {
  std::size_t pairs{0};
  std::int64_t cost{0};
  friend bool operator==(const Sum&, const Sum&) = default;
  [[nodiscard]] bool better_than(const Sum& other) const {
    return pairs != other.pairs ? pairs > other.pairs : cost < other.cost;
  }
};

Sum sum_of(const CostTable& table, const std::vector<std::size_t>& assignment) {
  Sum sum;
  for (std::size_t row = 0; row < table.rows; ++row) {
    if (assignment[row] == unassigned) continue;
    ++sum.pairs;
    sum.cost += table.at(row, assignment[row]);
  }
  return sum;
}

/// The best of all assignments, tried one after the other.
Sum best_of_all(const CostTable& table, std::size_t row, std::set<std::size_t>& used) {
  if (row == table.rows) return {};
  Sum best = best_of_all(table, row + 1, used);
  for (std::size_t column = 0; column < table.columns; ++column) {
    if (used.contains(column) || table.at(row, column) == forbidden_cost) continue;
    used.insert(column);
    Sum with = best_of_all(table, row + 1, used);
    used.erase(column);
    ++with.pairs;
    with.cost += table.at(row, column);
    if (with.better_than(best)) best = with;
  }
  return best;
}

CostTable random_table(Random& random, std::size_t rows, std::size_t columns, double forbidden) {
  CostTable table{rows, columns, {}};
  for (std::size_t i = 0; i < rows * columns; ++i)
    table.costs.push_back(random.chance(forbidden) ? forbidden_cost : static_cast<std::int64_t>(random.below(40)) - 10);
  return table;
}

TEST(LeastCostAssignment, gives_up_a_cheap_pair_for_a_cheaper_sum) {
  EXPECT_THAT(least_cost_assignment({2, 2, {1, 2, 2, 9}}), ElementsAre(1, 0));
}

TEST(LeastCostAssignment, leaves_rows_or_columns_over) {
  EXPECT_THAT(least_cost_assignment({3, 1, {5, 3, 4}}), ElementsAre(unassigned, 0, unassigned));
  EXPECT_THAT(least_cost_assignment({1, 3, {5, 3, 4}}), ElementsAre(1));
  EXPECT_THAT(least_cost_assignment({0, 3, {}}), IsEmpty());
  EXPECT_THAT(least_cost_assignment({2, 0, {}}), ElementsAre(unassigned, unassigned));
}

TEST(LeastCostAssignment, never_pairs_what_is_forbidden) {
  EXPECT_THAT(least_cost_assignment({2, 2, {forbidden_cost, 7, forbidden_cost, 1}}), ElementsAre(unassigned, 1));
  EXPECT_THAT(least_cost_assignment({1, 1, {forbidden_cost}}), ElementsAre(unassigned));
}

TEST(LeastCostAssignment, prefers_more_pairs_to_cheaper_ones) {
  EXPECT_THAT(least_cost_assignment({2, 2, {0, cost_max, forbidden_cost, cost_max}}), ElementsAre(0, 1));
  EXPECT_THAT(least_cost_assignment({2, 2, {-cost_max, cost_max, cost_max, forbidden_cost}}), ElementsAre(1, 0));
}

TEST(LeastCostAssignment, is_the_best_of_all_assignments) {
  EXPECT_TRUE(rc::check([](std::uint64_t seed) {
    Random random{seed, "test"};
    const auto table = random_table(random, 1 + random.below(6), 1 + random.below(6), random.chance(0.5) ? 0.3 : 0.0);
    const auto assignment = least_cost_assignment(table);
    std::set<std::size_t> columns;
    for (const std::size_t column : assignment)
      if (column != unassigned) RC_ASSERT(columns.insert(column).second);
    std::set<std::size_t> used;
    RC_ASSERT(sum_of(table, assignment) == best_of_all(table, 0, used));
  }));
}

TEST(LeastCostAssignment, of_a_large_table_is_proved_by_its_transposition) {
  Random random{3, "test"};
  const CostTable table = random_table(random, 150, 220, 0.1);
  CostTable transposed{220, 150, std::vector<std::int64_t>(table.costs.size())};
  for (std::size_t row = 0; row < 150; ++row)
    for (std::size_t column = 0; column < 220; ++column) transposed.costs[column * 150 + row] = table.at(row, column);
  const Sum sum = sum_of(table, least_cost_assignment(table));
  EXPECT_EQ(sum.pairs, 150U);
  EXPECT_EQ(sum, sum_of(transposed, least_cost_assignment(transposed)));
}

}  // namespace
}  // namespace cosiva::planning
