#include "cosiva/virtual/server/orders/wait_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "cosiva/base/random.h"

namespace cosiva::virtual_side {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;
using testing::SizeIs;

std::vector<Knot> knots_of(std::size_t count, const std::vector<Wait>& waits) {
  WaitGraph graph;
  graph.begin(count);
  for (const Wait& wait : waits) graph.add(wait);
  return graph.find_knots();
}

Wait wait(VehicleIndex waiter, VehicleIndex blocker, WaitReason why = {}) { return {waiter, blocker, why}; }

TEST(WaitGraph, has_no_knot_where_a_vehicle_can_continue) {
  EXPECT_THAT(knots_of(0, {}), IsEmpty());
  EXPECT_THAT(knots_of(4, {wait(0, 1), wait(1, 2), wait(2, 3)}), IsEmpty());
  EXPECT_THAT(knots_of(3, {wait(0, 2), wait(1, 2)}), IsEmpty());
  EXPECT_THAT(knots_of(2, {wait(0, 0), wait(1, 7)}), IsEmpty())
      << "no vehicle waits for itself or for an unknown vehicle";
}

TEST(WaitGraph, returns_two_vehicles_that_wait_for_each_other_and_the_reasons) {
  const auto knots = knots_of(5, {{3, 1, WaitReason::sensors}, {1, 3, WaitReason::crossing, 7}, {4, 1}});
  ASSERT_THAT(knots, SizeIs(1));
  EXPECT_THAT(knots[0].members, ElementsAre(1U, 3U)) << "a vehicle that only waits for them is not a member";
  EXPECT_THAT(knots[0].cycle, ElementsAre(Wait{1, 3, WaitReason::crossing, 7}, Wait{3, 1, WaitReason::sensors}));
}

TEST(WaitGraph, finds_several_knots_independent_of_the_order_of_the_waits) {
  std::vector<Wait> waits{wait(0, 4), wait(4, 2), wait(2, 0), wait(5, 6), wait(6, 5), wait(1, 0), wait(3, 6)};
  const auto knots = knots_of(7, waits);
  ASSERT_THAT(knots, SizeIs(2));
  EXPECT_THAT(knots[0].members, ElementsAre(0U, 2U, 4U));
  EXPECT_THAT(knots[0].cycle, ElementsAre(wait(0, 4), wait(4, 2), wait(2, 0)));
  EXPECT_THAT(knots[1].members, ElementsAre(5U, 6U));
  std::ranges::reverse(waits);
  const auto again = knots_of(7, waits);
  ASSERT_THAT(again, SizeIs(2));
  for (std::size_t i = 0; i < 2; ++i) EXPECT_EQ(again[i].cycle, knots[i].cycle);
}

TEST(WaitGraph, returns_the_shortest_cycle_where_a_vehicle_waits_for_several) {
  const auto knots = knots_of(4, {wait(0, 1), wait(1, 2), wait(2, 3), wait(3, 0), wait(1, 0)});
  ASSERT_THAT(knots, SizeIs(1));
  EXPECT_THAT(knots[0].members, ElementsAre(0U, 1U, 2U, 3U));
  EXPECT_THAT(knots[0].cycle, ElementsAre(wait(0, 1), wait(1, 0)));
}

TEST(WaitGraph, is_reused_without_previous_waits) {
  WaitGraph graph;
  graph.begin(4);
  graph.add(wait(0, 1));
  graph.add(wait(1, 0));
  EXPECT_THAT(graph.find_knots(), SizeIs(1));
  graph.begin(3);
  graph.add(wait(2, 1));
  EXPECT_THAT(graph.find_knots(), IsEmpty());
  EXPECT_THAT(graph.waits(), ElementsAre(wait(2, 1)));
}

TEST(WaitGraph, handles_a_cycle_of_a_hundred_thousand) {
  constexpr VehicleIndex count = 100'000;
  std::vector<Wait> waits;
  for (VehicleIndex v = 0; v < count; ++v) waits.push_back(wait(v, (v + 1) % count));
  const auto knots = knots_of(count, waits);
  ASSERT_THAT(knots, SizeIs(1));
  EXPECT_THAT(knots[0].cycle, SizeIs(count));
}

/// The vehicles that each vehicle waits for, directly or indirectly, by exhaustive search.
std::vector<std::vector<bool>> reach_of(std::size_t count, const std::vector<Wait>& waits) {
  std::vector<std::vector<bool>> reach(count, std::vector<bool>(count, false));
  for (const Wait& w : waits) reach[w.waiter][w.blocker] = true;
  for (std::size_t k = 0; k < count; ++k)
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t j = 0; j < count; ++j)
        if (reach[i][k] && reach[k][j]) reach[i][j] = true;
  return reach;
}

TEST(WaitGraph, agrees_with_exhaustive_search) {
  Random random{11, "wait graph"};
  std::size_t found = 0;
  for (int round = 0; round < 2000; ++round) {
    const auto count = static_cast<std::size_t>(random.uniform(2.0, 13.0));
    std::vector<Wait> waits;
    const auto some = static_cast<std::size_t>(random.uniform(0.0, 1.5 * static_cast<double>(count)));
    const auto any_vehicle = [&] { return static_cast<VehicleIndex>(random.uniform(0.0, static_cast<double>(count))); };
    for (std::size_t i = 0; i < some; ++i) {
      const VehicleIndex waiter = any_vehicle();
      if (const VehicleIndex blocker = any_vehicle(); waiter != blocker) waits.push_back(wait(waiter, blocker));
    }
    const auto reach = reach_of(count, waits);
    const auto knots = knots_of(count, waits);
    std::vector<int> knot_of(count, -1);
    for (std::size_t k = 0; k < knots.size(); ++k) {
      for (const VehicleIndex v : knots[k].members) knot_of[v] = static_cast<int>(k);
      const auto& cycle = knots[k].cycle;
      ASSERT_GE(cycle.size(), 2U);
      EXPECT_EQ(cycle.front().waiter, knots[k].members.front());
      for (std::size_t i = 0; i < cycle.size(); ++i) {
        EXPECT_EQ(cycle[i].blocker, cycle[(i + 1) % cycle.size()].waiter);
        EXPECT_EQ(std::ranges::count(cycle, cycle[i].waiter, &Wait::waiter), 1);
        EXPECT_TRUE(std::ranges::find(waits, cycle[i]) != waits.end());
      }
      ++found;
    }
    for (std::size_t i = 0; i < count; ++i) {
      EXPECT_EQ(knot_of[i] >= 0, reach[i][i]);
      for (std::size_t j = 0; j < count; ++j)
        EXPECT_EQ(i == j || (reach[i][j] && reach[j][i]), i == j || (knot_of[i] >= 0 && knot_of[i] == knot_of[j]));
    }
  }
  EXPECT_GT(found, 300U);
}

}  // namespace
}  // namespace cosiva::virtual_side
