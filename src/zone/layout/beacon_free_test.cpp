// Against definitions that examine every beacon and every route.
#include "cosiva/zone/layout/beacon_free.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using testing::part;
using testing::section;

TrafficZone zone_of(Circuit circuit) { return {"z", std::move(circuit), {}, {}, {}, {}, {}, {}, {}, {}}; }

/// A grid of any pitch, position and rotation about the origin.
BeaconGrid any_grid(Random& random) {
  BeaconGrid grid{random.uniform(0.2, 1.0),
                  {random.uniform(-3.0, 0.0), random.uniform(-3.0, 0.0)},
                  static_cast<std::uint32_t>(1 + random.below(12)),
                  static_cast<std::uint32_t>(1 + random.below(12))};
  if (random.chance(0.7)) grid.rotation_rad = random.uniform(-3.0, 3.0);
  return grid;
}

double longest_gap_m(std::vector<double> reads_m, double length_m) {
  std::sort(reads_m.begin(), reads_m.end());
  double from_m = 0.0;
  double longest_m = 0.0;
  reads_m.push_back(length_m);
  for (const double s_m : reads_m) {
    longest_m = std::max(longest_m, s_m - from_m);
    from_m = s_m;
  }
  return longest_m;
}

TEST(BeaconFree, on_a_straight_is_the_longest_gap_between_the_beacons_within_reach) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "beacon_free_test"};
    const double length_m = random.uniform(0.2, 6.0);
    const Section line =
        section({random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-3.0, 3.0)}, length_m);
    TrafficZone zone = zone_of(testing::circuit({part("a", line)}));
    zone.beacons = any_grid(random);
    const double reach_m = random.uniform(0.01, 0.15);
    std::vector<double> reads_m;
    for (std::uint32_t row = 0; row < zone.beacons->rows; ++row) {
      for (std::uint32_t column = 0; column < zone.beacons->columns; ++column) {
        const auto nearest = line.nearest(zone.beacons->at(column, row));
        if (nearest.distance_m <= reach_m) reads_m.push_back(nearest.s_m);
      }
    }
    const Stretch longest = longest_beacon_free(zone, reach_m);
    RC_ASSERT(std::fabs(longest.length_m - longest_gap_m(reads_m, length_m)) < 1e-9);
    RC_ASSERT(std::fabs(longest.to.s_m - longest.from.s_m - longest.length_m) < 1e-9);
  }));
}

TEST(BeaconFree, on_a_circle_is_the_longest_arc_between_the_beacons_within_reach) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "beacon_free_test/circle"};
    const double radius_m = random.uniform(0.3, 2.5);
    const double round_m = 2.0 * pi * radius_m;
    TrafficZone zone =
        zone_of(testing::circuit({part("round", section({radius_m, 0.0, 0.5 * pi}, round_m, 1.0 / radius_m), {0})}));
    zone.beacons = any_grid(random);
    const double reach_m = random.uniform(0.02, 0.10);
    std::vector<double> reads_m;
    for (std::uint32_t row = 0; row < zone.beacons->rows; ++row) {
      for (std::uint32_t column = 0; column < zone.beacons->columns; ++column) {
        const Point2 beacon = zone.beacons->at(column, row);
        const double off_m = std::fabs(norm(beacon.x_m, beacon.y_m) - radius_m);
        // Curves are taken to 0.1 mm: a beacon at the very edge of the reach may count or not.
        if (std::fabs(off_m - reach_m) < 3e-4) return;
        const double turn_rad = std::atan2(beacon.y_m, beacon.x_m);
        if (off_m < reach_m) reads_m.push_back(radius_m * (turn_rad < 0.0 ? turn_rad + 2.0 * pi : turn_rad));
      }
    }
    const Stretch longest = longest_beacon_free(zone, reach_m);
    RC_ASSERT(longest.endless == reads_m.empty());
    if (reads_m.empty()) return;
    std::sort(reads_m.begin(), reads_m.end());
    double wanted_m = reads_m.front() + round_m - reads_m.back();
    for (std::size_t i = 1; i < reads_m.size(); ++i) wanted_m = std::max(wanted_m, reads_m[i] - reads_m[i - 1]);
    RC_ASSERT(std::fabs(longest.length_m - wanted_m) < 0.01);
  }));
}

TEST(BeaconFree, at_a_corner_reads_a_beacon_outside_it_once) {
  // Two straights at a right angle; a beacon 1 cm beyond the corner in both directions is nearest to the corner.
  auto in = part("in", section({}, 2.0), {1});
  in.pivots = true;
  TrafficZone zone = zone_of(testing::circuit({in, part("out", section({2.0, 0.0, 0.5 * pi}, 3.0))}));
  zone.beacons = BeaconGrid{50.0, {2.01, -0.01}, 1, 1};
  const Stretch longest = longest_beacon_free(zone);
  EXPECT_NEAR(longest.length_m, 3.0, 1e-9);
  EXPECT_NEAR(longest.from.s_m, longest.from.section == 0 ? 2.0 : 0.0, 1e-9);
  // Beyond an open end, too.
  zone = zone_of(testing::circuit({part("a", section({}, 2.0))}));
  for (const Point2 beyond : {Point2{-0.015, 0.01}, {2.015, 0.01}}) {
    zone.beacons = BeaconGrid{50.0, beyond, 1, 1};
    EXPECT_NEAR(longest_beacon_free(zone).length_m, 2.0, 1e-9);
    EXPECT_EQ(longest_unread(zone).length_m, 2.0);
  }
  zone.beacons = BeaconGrid{50.0, {1.0, 0.015}, 1, 1};
  EXPECT_NEAR(longest_beacon_free(zone).length_m, 1.0, 1e-9);
  EXPECT_NEAR(longest_beacon_free(zone, 0.014).length_m, 2.0, 1e-9);
}

TEST(Unread, counts_tags_and_beacons_together) {
  TrafficZone zone = zone_of(testing::circuit({part("a", section({}, 6.0))}));
  zone.tags = {{2, {0, 4.0}}, {1, {0, 1.0}}};
  zone.beacons = BeaconGrid{50.0, {2.5, 0.0}, 1, 1};
  EXPECT_NEAR(longest_tag_free(zone).length_m, 3.0, 1e-12);
  EXPECT_EQ(longest_tag_free(zone).from, (TrackPosition{0, 1.0}));
  EXPECT_EQ(longest_tag_free(zone).to, (TrackPosition{0, 4.0}));
  EXPECT_NEAR(longest_beacon_free(zone).length_m, 3.5, 1e-9);
  EXPECT_NEAR(longest_unread(zone).length_m, 2.0, 1e-9);
}

TEST(TagFree, is_the_longest_distance_between_tags_in_any_graph) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "beacon_free_test/graph"};
    // Circles through the origin: any may follow any.
    const std::size_t size = 1 + random.below(8);
    std::vector<Circuit::Part> parts;
    for (std::size_t i = 0; i < size; ++i) {
      const double radius_m = random.uniform(0.1, 1.0);
      parts.push_back(part("s" + std::to_string(i), section({}, 2.0 * pi * radius_m, 1.0 / radius_m)));
      for (SectionId to = 0; to < size; ++to)
        if (random.chance(1.2 / static_cast<double>(size))) parts.back().next.push_back(to);
    }
    TrafficZone zone = zone_of(testing::circuit(std::move(parts)));
    const Circuit& circuit = zone.circuit;
    std::vector<std::vector<double>> tags_m(size);
    for (SectionId id = 0; id < size; ++id) {
      for (std::size_t i = random.below(3); i > 0; --i) {
        tags_m[id].push_back(random.uniform(0.0, 1.0) * circuit.section(id).length_m());
        zone.tags.push_back({static_cast<TagNumber>(zone.tags.size() + 1), {id, tags_m[id].back()}});
      }
      std::sort(tags_m[id].begin(), tags_m[id].end());
    }
    // From the start of a section to the next tag; more than all sections together where there may be none for ever.
    const double forever_m = 1e6;
    std::function<double(SectionId, std::size_t)> next_read_m = [&](SectionId id, std::size_t steps) {
      if (!tags_m[id].empty()) return tags_m[id].front();
      if (steps > size) return forever_m;
      double worst_m = 0.0;
      for (const SectionId after : circuit.next(id)) worst_m = std::max(worst_m, next_read_m(after, steps + 1));
      return circuit.section(id).length_m() + worst_m;
    };
    bool endless = false;
    double wanted_m = 0.0;
    for (SectionId id = 0; id < size; ++id) {
      endless = endless || next_read_m(id, 0) >= forever_m;
      if (circuit.previous(id).empty()) wanted_m = std::max(wanted_m, next_read_m(id, 0));
      for (std::size_t i = 1; i < tags_m[id].size(); ++i)
        wanted_m = std::max(wanted_m, tags_m[id][i] - tags_m[id][i - 1]);
      if (tags_m[id].empty()) continue;
      double worst_m = 0.0;
      for (const SectionId after : circuit.next(id)) worst_m = std::max(worst_m, next_read_m(after, 0));
      wanted_m = std::max(wanted_m, circuit.section(id).length_m() - tags_m[id].back() + worst_m);
    }
    const Stretch longest = longest_tag_free(zone);
    RC_ASSERT(longest.endless == endless);
    if (!endless) RC_ASSERT(std::fabs(longest.length_m - wanted_m) < 1e-9);
  }));
}

TEST(TagFree, is_the_longest_of_several_loops_without_a_tag) {
  const auto lap = [](const char* name, double x_m, double radius_m, std::vector<SectionId> next) {
    return part(name, section({x_m, 0.0, 0.0}, 2.0 * pi * radius_m, 1.0 / radius_m), std::move(next));
  };
  const Stretch second = longest_tag_free(
      zone_of(testing::circuit({lap("a", 0.0, 0.5, {0}), lap("b", 9.0, 0.8, {1}), lap("c", 18.0, 0.6, {2})})));
  EXPECT_TRUE(second.endless);
  EXPECT_NEAR(second.length_m, 1.6 * pi, 1e-12);
  EXPECT_EQ(second.from, (TrackPosition{1, 0.0}));
  EXPECT_EQ(second.to, (TrackPosition{1, second.length_m}));
  // What leads into a loop is no part of it.
  const Section stem = section({-3.0, 0.0, 0.0}, 3.0);
  const Stretch behind_stem =
      longest_tag_free(zone_of(testing::circuit({part("stem", stem, {1}), lap("a", 0.0, 0.5, {1})})));
  EXPECT_TRUE(behind_stem.endless);
  EXPECT_NEAR(behind_stem.length_m, pi, 1e-12);
  EXPECT_EQ(behind_stem.from, (TrackPosition{1, 0.0}));
  // From the first section of a loop to the end of its last.
  const TrafficZone track = zone_of(testing::track(2.0, 0.5));
  const Stretch round = longest_tag_free(track);
  EXPECT_EQ(round.from, (TrackPosition{0, 0.0}));
  EXPECT_EQ(round.to, (TrackPosition{3, track.circuit.section(3).length_m()}));
}

TEST(TagFree, runs_over_sections_without_a_tag_to_the_next) {
  // 1 m, 2 m and 3 m in a row.
  TrafficZone zone =
      zone_of(testing::circuit({part("a", section({}, 1.0), {1}), part("b", section({1.0, 0.0, 0.0}, 2.0), {2}),
                                part("c", section({3.0, 0.0, 0.0}, 3.0))}));
  const auto expect_longest = [&](double length_m, TrackPosition from, TrackPosition to) {
    const Stretch longest = longest_tag_free(zone);
    EXPECT_NEAR(longest.length_m, length_m, 1e-12);
    EXPECT_EQ(longest.from, from);
    EXPECT_EQ(longest.to, to);
    EXPECT_FALSE(longest.endless);
  };
  expect_longest(6.0, {0, 0.0}, {2, 3.0});
  zone.tags = {{1, {2, 1.5}}};
  expect_longest(4.5, {0, 0.0}, {2, 1.5});
  zone.tags = {{1, {0, 0.5}}, {2, {2, 1.5}}};
  expect_longest(4.0, {0, 0.5}, {2, 1.5});
  zone.tags = {{1, {0, 0.5}}, {2, {1, 0.25}}};
  expect_longest(4.75, {1, 0.25}, {2, 3.0});
  zone.tags = {{1, {2, 2.75}}, {2, {2, 0.25}}, {3, {1, 1.0}}};
  expect_longest(2.5, {2, 0.25}, {2, 2.75});
}

TEST(SuggestedOrigin, lies_within_a_pitch_and_is_a_good_one) {
  // Two straights at a right angle, 0.37 and 0.71 m from the origin: each needs a row of its own under it.
  TrafficZone zone = zone_of(testing::circuit(
      {part("east", section({-2.0, 0.37, 0.0}, 4.0)), part("north", section({0.71, -2.0, 0.5 * pi}, 4.0))}));
  for (const double rotation_rad : {0.0, 0.5 * pi}) {
    zone.beacons = BeaconGrid{0.5, {-5.0, -5.0}, 100, 100};
    if (rotation_rad != 0.0) zone.beacons->origin = {5.0, -5.0};
    zone.beacons->rotation_rad = rotation_rad;
    const auto better = suggest_origin(zone);
    ASSERT_TRUE(better);
    EXPECT_NEAR(better->before_m, 4.0, 1e-9);
    EXPECT_NEAR(better->after_m, 0.5, 1e-9) << "one beacon every pitch on both";
    EXPECT_LE(std::fabs(better->origin.x_m - zone.beacons->origin.x_m), 0.5);
    EXPECT_LE(std::fabs(better->origin.y_m - zone.beacons->origin.y_m), 0.5);
    EXPECT_EQ(better->origin.x_m, std::nearbyint(better->origin.x_m * 1e4) / 1e4);
    zone.beacons->origin = better->origin;
    EXPECT_NEAR(longest_beacon_free(zone).length_m, better->after_m, 1e-9);
    // With a tenth of the reach to spare.
    EXPECT_NEAR(longest_beacon_free(zone, 0.0181).length_m, better->after_m, 1e-9);
  }
}

TEST(SuggestedOrigin, gets_beacons_onto_a_loop_that_has_none) {
  TrafficZone zone = zone_of(testing::track(2.0, 0.5));
  zone.beacons = BeaconGrid{2.0, {-3.0, -3.5}, 4, 4};  // 0.5 m from either straight
  const auto better = suggest_origin(zone);
  ASSERT_TRUE(better);
  EXPECT_TRUE(std::isinf(better->before_m));
  EXPECT_LT(better->after_m, zone.circuit.total_length_m() + 1e-6);
}

TEST(SuggestedOrigin, is_searched_on_up_to_two_hundred_thousand_pieces_of_a_pitch) {
  const auto suggested = [](double length_m) {
    TrafficZone zone = zone_of(testing::circuit({part("a", section({}, length_m))}));
    zone.beacons = BeaconGrid{0.01, {0.0, 0.5}, 2, 2};
    return suggest_origin(zone).has_value();
  };
  EXPECT_TRUE(suggested(21.0));
  EXPECT_FALSE(suggested(2000.1)) << "200 010 pieces";
}

}  // namespace
}  // namespace cosiva::zone
