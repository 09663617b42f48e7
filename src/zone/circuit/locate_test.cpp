// Circuit::locate and near: whatever index they use, their results are those of a search over every section.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/zone/circuit/circuit.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using ::testing::IsEmpty;
using testing::part;
using testing::section;
using testing::track;

/// Sections of all kinds, at random positions, some on one another.
Circuit scattered(Random& random, std::size_t size, double extent_m) {
  std::vector<Circuit::Part> parts;
  for (std::size_t i = 0; i < size; ++i) {
    const Pose2 start{random.uniform(-extent_m, extent_m), random.uniform(-extent_m, extent_m),
                      random.uniform(-3.1, 3.1)};
    const double length_m = random.chance(0.1) ? random.uniform(5.0, 30.0) : random.uniform(0.01, 3.0);
    const double bend_per_m = random.chance(0.5) ? 0.0 : random.uniform(-2.0, 2.0);
    const double rate_per_m2 = random.chance(0.7) ? 0.0 : random.uniform(-0.5, 0.5);
    auto made = Section::make(start, length_m, bend_per_m, rate_per_m2);
    parts.push_back(part("s" + std::to_string(2 * i), *made));
    if (random.chance(0.2)) parts.push_back(part("s" + std::to_string(2 * i + 1), *made));  // its twin, equally near
  }
  return testing::circuit(std::move(parts));
}

/// By a search over every section.
Circuit::Located brute_force(const Circuit& circuit, Point2 p, std::optional<double> heading_rad) {
  Circuit::Located any{{}, 0.0, 1e300};
  Circuit::Located aligned = any;
  for (SectionId id = 0; id < circuit.size(); ++id) {
    const auto nearest = circuit.section(id).nearest(p);
    const Circuit::Located here{{id, nearest.s_m}, nearest.left_m, nearest.distance_m};
    if (here.distance_m < any.distance_m) any = here;
    if (!heading_rad || !(here.distance_m < aligned.distance_m)) continue;
    if (std::fabs(wrap_angle(circuit.pose_at(here.position).heading_rad - *heading_rad)) <= pi / 3.0) aligned = here;
  }
  return aligned.position.section == no_section ? any : aligned;
}

std::vector<Circuit::Located> brute_force_near(const Circuit& circuit, Point2 p, double within_m) {
  std::vector<Circuit::Located> all;
  for (SectionId id = 0; id < circuit.size(); ++id) {
    const auto nearest = circuit.section(id).nearest(p);
    if (nearest.distance_m <= within_m) all.push_back({{id, nearest.s_m}, nearest.left_m, nearest.distance_m});
  }
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.distance_m < b.distance_m; });
  return all;
}

bool same(const Circuit::Located& a, const Circuit::Located& b) {
  return a.position == b.position && a.left_m == b.left_m && a.distance_m == b.distance_m;
}

bool locates_exactly(const Circuit& circuit, Point2 p, double heading_rad, double within_m) {
  std::vector<Circuit::Located> near;
  circuit.near(p, within_m, near);
  const auto all = brute_force_near(circuit, p, within_m);
  return same(circuit.locate(p), brute_force(circuit, p, std::nullopt)) &&
         same(circuit.locate(p, heading_rad), brute_force(circuit, p, heading_rad)) &&
         std::equal(near.begin(), near.end(), all.begin(), all.end(), same);
}

TEST(Locate, equals_a_search_over_every_section) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "locate_test"};
    const double extent_m = random.chance(0.5) ? 3.0 : 100.0;
    const Circuit circuit = scattered(random, 1 + random.below(40), extent_m);
    for (int i = 0; i < 20; ++i) {
      const Point2 p{random.uniform(-2.0, 2.0) * extent_m, random.uniform(-2.0, 2.0) * extent_m};
      RC_ASSERT(locates_exactly(circuit, p, random.uniform(-10.0, 10.0), random.uniform(0.0, 3.0)));
    }
  }));
}

TEST(Locate, is_exact_on_the_sections_at_their_ends_and_far_outside) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "locate_test/places"};
    const double extent_m = random.chance(0.5) ? 10.0 : 300.0;
    const Circuit circuit = scattered(random, 1 + random.below(300), extent_m);
    for (int i = 0; i < 12; ++i) {
      const Section& section = circuit.section(static_cast<SectionId>(random.below(circuit.size())));
      const Pose2 on = section.pose_at(random.uniform(0.0, section.length_m()));
      const double beside_m = random.chance(0.5) ? 0.0 : random.uniform(-0.2, 0.2);
      for (const Pose2& pose : {on * Pose2{0.0, beside_m, 0.1}, section.start(), section.end()})
        RC_ASSERT(locates_exactly(circuit, position(pose), pose.heading_rad, random.uniform(-0.1, 20.0)));
      const Point2 outside{random.uniform(-1e5, 1e5), random.uniform(-1e5, 1e5)};
      RC_ASSERT(locates_exactly(circuit, outside, random.uniform(-4.0, 4.0), 1e5));
    }
  }));
}

TEST(Locate, is_exact_where_many_sections_lie_in_one_corner_of_a_huge_zone) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "locate_test/crowd"};
    const double far_m = random.chance(0.5) ? 1e4 : 1e8;
    std::vector<Circuit::Part> parts;
    for (int i = 0; i < 150; ++i) {
      const Pose2 start{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0), random.uniform(-3.1, 3.1)};
      parts.push_back(part("s" + std::to_string(i), section(start, random.uniform(1e-5, 0.3), 0.5)));
    }
    parts.push_back(part("far", section({far_m, -far_m, 0.3}, 5.0)));
    if (random.chance(0.5)) parts.push_back(part("across", section({0.0, 0.0, -pi / 4.0}, 9e4)));
    const Circuit circuit = testing::circuit(std::move(parts));
    for (int i = 0; i < 10; ++i) {
      const Point2 p{random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0)};
      const Point2 between{random.uniform(0.0, far_m), random.uniform(-far_m, 0.0)};
      RC_ASSERT(locates_exactly(circuit, p, random.uniform(-4.0, 4.0), 0.2));
      RC_ASSERT(locates_exactly(circuit, between, random.uniform(-4.0, 4.0), 0.2));
    }
  }));
}

TEST(Locate, gives_the_lowest_id_of_equally_near_sections) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 30; ++i)  // two lanes, each fifteen times
    parts.push_back(part("s" + std::to_string(i), section({0.0, i % 2 == 0 ? 1.0 : -1.0, 0.0}, 4.0)));
  const Circuit circuit = testing::circuit(std::move(parts));
  EXPECT_EQ(circuit.locate({2.0, 0.5}).position, (TrackPosition{0, 2.0}));
  EXPECT_EQ(circuit.locate({2.0, -0.5}).position, (TrackPosition{1, 2.0}));
  EXPECT_EQ(circuit.locate({2.0, 0.0}).position, (TrackPosition{0, 2.0}));
  EXPECT_EQ(circuit.locate({-1.0, 0.0}, 0.5).position, (TrackPosition{0, 0.0}));
}

TEST(Locate, ignores_all_sections_that_head_elsewhere_however_near) {
  std::vector<Circuit::Part> parts;
  for (int i = 0; i < 200; ++i)
    parts.push_back(part("north" + std::to_string(i), section({1.0 * i, 0.0, pi / 2.0}, 10.0)));
  parts.push_back(part("south", section({-500.0, 10.0, -pi / 2.0}, 10.0)));
  const Circuit circuit = testing::circuit(std::move(parts));
  EXPECT_EQ(circuit.locate({150.2, 5.0}, 1.5).position.section, 150U);
  EXPECT_EQ(circuit.locate({150.2, 5.0}, -1.5).position.section, 200U);
  EXPECT_EQ(circuit.locate({150.2, 5.0}, 0.0).position.section, 150U);  // none heads east: then any will do
}

TEST(Locate, is_near_nothing_that_is_not_a_number) {
  const Circuit circuit = track();
  std::vector<Circuit::Located> near{{}};
  circuit.near({std::nan(""), 0.0}, 1e6, near);
  EXPECT_THAT(near, IsEmpty());
  EXPECT_EQ(circuit.locate({std::nan(""), 0.0}).position.section, no_section);
  EXPECT_EQ(circuit.locate({1.0, 0.1}, std::nan("")).position.section, 0U);
}

TEST(Locate, locates_from_far_away_and_far_from_the_origin) {
  const Section far = section({1e6, -1e6, 0.3}, 5.0);
  const Circuit circuit = testing::circuit({part("near", section({}, 5.0)), part("far", far)});
  EXPECT_EQ(circuit.locate({1e9, -1e9}).position.section, 1U);
  const auto located = circuit.locate(position(far.pose_at(2.5)), 0.3);
  EXPECT_EQ(located.position.section, 1U);
  EXPECT_LT(located.distance_m, 1e-9);
}

TEST(Locate, takes_a_section_that_heads_exactly_sixty_degrees_elsewhere_for_aligned) {
  for (const double side : {1.0, -1.0}) {
    const Circuit circuit = testing::circuit({part("aslant", section({0.0, 0.0, side * pi / 3.0}, 2.0)),
                                              part("along", section({0.0, -side * 5.0, 0.0}, 2.0))});
    EXPECT_EQ(circuit.locate({0.5, side * 0.8}, 0.0).position.section, 0U);
    EXPECT_EQ(circuit.locate({0.5, side * 0.8}, side * -1e-9).position.section, 1U);
  }
}

}  // namespace
}  // namespace cosiva::zone
