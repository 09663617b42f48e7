#include "cosiva/aiv/order/crossing_finder.h"

#include <gtest/gtest.h>

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using Spans = std::vector<std::vector<zone::CrossingSpan>>;

/// A zone with these sections in a row, and crossings of these spans.
zone::TrafficZone with_crossings(Spans spans, const std::vector<test::Piece>& pieces, bool closed = false) {
  zone::TrafficZone zone = test::lacet4();
  zone.circuit = test::lay(pieces, closed);
  zone.crossings.clear();
  for (auto& of_one : spans)
    zone.crossings.push_back({"X" + std::to_string(zone.crossings.size()), {}, std::move(of_one)});
  return zone;
}

struct ExpectedSpan {
  std::size_t crossing;
  double entry_m;
  double exit_m;
  double chain_exit_m;
};
void expect_spans(const zone::TrafficZone& zone, const Outlook& outlook, double reach_m,
                  const std::vector<ExpectedSpan>& expected, std::size_t count_max = 8) {
  std::vector<CrossingSpan> found{{99, 0.0, 0.0, 0.0}};  // removed by the search
  CrossingFinder{zone}.ahead(outlook, reach_m, count_max, found);
  ASSERT_EQ(found.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    EXPECT_EQ(found[i].crossing, expected[i].crossing) << i;
    EXPECT_NEAR(found[i].entry_m, expected[i].entry_m, 1e-12) << i;
    EXPECT_NEAR(found[i].exit_m, expected[i].exit_m, 1e-12) << i;
    EXPECT_NEAR(found[i].chain_exit_m, expected[i].chain_exit_m, 1e-12) << i;
  }
}

// A vehicle is 0.2 m long and needs 0.3 m between crossings to stop there.

TEST(CrossingFinder, lists_crossings_in_the_order_of_their_entries_with_the_ends_of_their_chains) {
  const auto zone = with_crossings({{{0, 2.21, 2.5}}, {{0, 1.0, 1.3}}, {{0, 1.5, 1.9}}, {{0, 3.0, 3.1}}}, {{5.0}});
  // 1 and 2 are 0.2 m apart, 2 and 0 0.31 m, 0 and 3 0.5 m.
  expect_spans(zone, {0, 0.5}, 4.0, {{1, 0.5, 0.8, 1.4}, {2, 1.0, 1.4, 1.4}, {0, 1.71, 2.0, 2.0}, {3, 2.5, 2.6, 2.6}});
}

TEST(CrossingFinder, keeps_a_chain_to_the_furthest_exit_of_its_crossings) {
  const auto zone = with_crossings({{{0, 1.0, 2.0}}, {{0, 1.2, 1.4}}, {{0, 2.25, 2.4}}}, {{5.0}});
  expect_spans(zone, {0, 0.5}, 4.0, {{0, 0.5, 1.5, 1.9}, {1, 0.7, 0.9, 1.9}, {2, 1.75, 1.9, 1.9}});
}

TEST(CrossingFinder, takes_crossings_up_to_its_reach_and_those_that_a_vehicle_cannot_stop_before) {
  const auto zone = with_crossings({{{0, 1.0, 1.2}}, {{0, 1.45, 1.6}}, {{0, 1.95, 2.0}}}, {{5.0}});
  expect_spans(zone, {0, 0.5}, 0.49, {});
  // The second follows 0.25 m behind the first, the third 0.35 m behind the second.
  expect_spans(zone, {0, 0.5}, 0.51, {{0, 0.5, 0.7, 1.1}, {1, 0.95, 1.1, 1.1}});
  expect_spans(zone, {0, 0.5}, 1.46, {{0, 0.5, 0.7, 1.1}, {1, 0.95, 1.1, 1.1}, {2, 1.45, 1.5, 1.5}});
  expect_spans(zone, {0, 0.5}, 1.46, {{0, 0.5, 0.7, 1.1}, {1, 0.95, 1.1, 1.1}}, 2);
}

TEST(CrossingFinder, counts_from_the_vehicle_inside_a_crossing_and_not_behind_it) {
  const auto zone = with_crossings({{{0, 0.2, 0.6}}, {{0, 0.3, 0.5}}}, {{5.0}});
  expect_spans(zone, {0, 0.55}, 1.0, {{0, 0.0, 0.05, 0.05}});
  expect_spans(zone, {0, 0.65}, 1.0, {});
}

TEST(CrossingFinder, joins_the_parts_of_one_crossing_at_a_joint_and_no_further_ones) {
  const auto zone = with_crossings({{{0, 0.8, 1.0}, {1, 0.0, 0.3}, {1, 2.0, 2.2}}}, {{1.0}, {5.0}});
  expect_spans(zone, {0, 0.5}, 3.0, {{0, 0.3, 0.8, 0.8}, {0, 2.5, 2.7, 2.7}});
  // On a later section, within reach across the joint.
  expect_spans(zone, {1, 0.4}, 1.7, {{0, 1.6, 1.8, 1.8}});
}

TEST(CrossingFinder, ends_where_the_circuit_ends_and_after_two_rounds_of_a_loop) {
  const auto dead_end = with_crossings({{{0, 0.5, 0.6}}}, {{1.0}});
  expect_spans(dead_end, {0, 0.1}, 50.0, {{0, 0.4, 0.5, 0.5}});
  // A circle of 2 m on which each crossing follows too closely behind the one before.
  const auto loop = with_crossings({{{0, 0.1, 0.9}}, {{1, 0.1, 0.9}}}, {{1.0, pi, 0.0}, {1.0, pi, 0.0}}, true);
  expect_spans(loop, {0, 0.05}, 0.5,
               {{0, 0.05, 0.85, 3.85}, {1, 1.05, 1.85, 3.85}, {0, 2.05, 2.85, 3.85}, {1, 3.05, 3.85, 3.85}});
}

TEST(CrossingFinder, counts_a_crossing_at_its_reach_and_none_whose_exit_is_under_the_vehicle) {
  const auto zone = with_crossings({{{0, 0.25, 0.625}}, {{0, 1.0, 1.25}}}, {{5.0}});
  expect_spans(zone, {0, 0.625}, 0.375, {{1, 0.375, 0.625, 0.625}});
  // The next section begins at the reach.
  const auto joint = with_crossings({{{1, 0.0, 0.25}}}, {{1.0}, {1.0}});
  expect_spans(joint, {0, 0.5}, 0.5, {{0, 0.5, 0.75, 0.75}});
}

TEST(CrossingFinder, ends_a_chain_where_a_vehicle_has_exactly_the_room_to_stop) {
  // A vehicle of 0.15 m needs 0.25 m.
  auto zone = with_crossings({{{0, 1.0, 1.25}}, {{0, 1.5, 1.75}}, {{0, 1.9375, 2.0}}}, {{5.0}});
  zone.vehicle.length_m = 0.15;
  ASSERT_EQ(zone::stopping_room_m(zone.vehicle), 0.25);
  expect_spans(zone, {0, 0.5}, 4.0, {{0, 0.5, 0.75, 0.75}, {1, 1.0, 1.25, 1.5}, {2, 1.4375, 1.5, 1.5}});
}

TEST(CrossingFinder, joins_the_parts_of_one_crossing_over_a_micrometre) {
  const auto from_joint = [](double from_m) {
    return with_crossings({{{0, 0.5, 1.0}, {1, from_m, 0.25}}}, {{1.0}, {1.0}});
  };
  expect_spans(from_joint(5e-7), {0, 0.25}, 3.0, {{0, 0.25, 1.0, 1.0}});
  expect_spans(from_joint(2e-6), {0, 0.25}, 3.0, {{0, 0.25, 0.75, 1.0}, {0, 0.75 + 2e-6, 1.0, 1.0}});
}

}  // namespace
}  // namespace cosiva::aiv
