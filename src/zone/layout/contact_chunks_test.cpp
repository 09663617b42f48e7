#include "cosiva/zone/layout/contact_chunks.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <set>
#include <string>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/zone/testing/test_zones.h"

namespace cosiva::zone {
namespace {

using testing::part;
using testing::section;

/// Distance of p from the chord of a chunk.
double from_chord_m(const Chunk& chunk, Point2 p) {
  const double x = chunk.end.x_m - chunk.start.x_m;
  const double y = chunk.end.y_m - chunk.start.y_m;
  const double square = x * x + y * y;
  const double t = std::clamp(((p.x_m - chunk.start.x_m) * x + (p.y_m - chunk.start.y_m) * y) / square, 0.0, 1.0);
  return norm(p.x_m - chunk.start.x_m - t * x, p.y_m - chunk.start.y_m - t * y);
}

TEST(Chunks, are_at_most_a_quarter_of_a_metre_long_or_half_a_vehicle) {
  const Circuit circuit = testing::circuit({part("a", section({}, 1.0)), part("b", section({0.0, 5.0, 0.0}, 1.01))});
  const Chunks small{circuit, ContactRules{{0.20, 0.12}, 0.04}};
  EXPECT_EQ(small.size(), 4U + 5U);
  EXPECT_EQ(small.first_of(0), 0U);
  EXPECT_EQ(small.first_of(1), 4U);
  EXPECT_EQ(small.first_of(2), 9U);
  EXPECT_EQ(small[1].from_m, 0.25);
  EXPECT_EQ(small[1].to_m, 0.5);
  const Chunks large{circuit, ContactRules{{1.0, 0.5}, 0.04}};
  EXPECT_EQ(large.size(), 2U + 3U);
}

TEST(Chunks, have_the_overhang_of_half_a_vehicle_at_open_ends_alone) {
  const Section first = section({}, 0.5);
  const Circuit circuit = testing::circuit({part("a", first, {1}), part("b", section(first.end(), 0.5))});
  const Chunks chunks{circuit, ContactRules{{0.20, 0.12}, 0.04}};
  ASSERT_EQ(chunks.size(), 4U);
  const double before_m[] = {0.10, 0.0, 0.0, 0.0};
  const double after_m[] = {0.0, 0.0, 0.0, 0.10};
  for (std::uint32_t i = 0; i < 4; ++i) {
    EXPECT_EQ(chunks[i].before_m, before_m[i]);
    EXPECT_EQ(chunks[i].after_m, after_m[i]);
    EXPECT_EQ(chunks[i].section, i / 2);
  }
  EXPECT_NEAR(chunks[0].start.x_m, -0.10, 1e-12);
  EXPECT_NEAR(chunks[3].end.x_m, 1.10, 1e-12);
  EXPECT_NEAR(chunks[3].radius_m(), 0.225, 1e-12);
}

TEST(Chunks, hold_their_stretch_and_a_body_on_it) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "contact_chunks_test"};
    const VehicleShape vehicle{random.uniform(0.1, 1.0), 0.12};
    const Section curve = section({random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)},
                                  random.uniform(0.1, 3.0), random.uniform(-3.0, 3.0));
    const Circuit circuit = testing::circuit({part("a", curve)});
    const ContactRules rules{vehicle, 0.04};
    const Chunks chunks{circuit, rules};
    for (std::uint32_t i = 0; i < chunks.size(); ++i) {
      const Chunk& chunk = chunks[i];
      for (double ratio = 0.0; ratio <= 1.0; ratio += 0.125) {
        const Pose2 X_MP = curve.pose_at(chunk.from_m + ratio * (chunk.to_m - chunk.from_m));
        RC_ASSERT(from_chord_m(chunk, position(X_MP)) <= chunk.bulge_m);
        RC_ASSERT(distance(chunk.centre, position(X_MP)) <= chunk.radius_m() + 1e-9);
      }
      const Point2 behind = curve.pose_at(chunk.from_m) * Point2{-chunk.before_m, 0.0};
      const Point2 before = curve.pose_at(chunk.to_m) * Point2{chunk.after_m, 0.0};
      RC_ASSERT(distance(behind, chunk.start) < 1e-12);
      RC_ASSERT(distance(before, chunk.end) < 1e-12);
      RC_ASSERT(distance(chunk.centre, behind) <= chunk.radius_m() + 1e-9);
      RC_ASSERT(distance(chunk.centre, before) <= chunk.radius_m() + 1e-9);
      // The bounds are those of the geometry and no larger: ⅛·h²·κ, the turned overhang, half a body turned as far.
      const double length_m = chunk.to_m - chunk.from_m;
      const double turn_rad = std::min(curve.curvature_max_per_m() * length_m, pi);
      RC_ASSERT(chunk.bulge_m <= 0.125 * curve.curvature_max_per_m() * length_m * length_m +
                                     (chunk.before_m + chunk.after_m) * turn_rad + 1e-8);
      RC_ASSERT(std::fabs(chunk.sideways_m - 0.5 * vehicle.length_m * turn_rad) < 1e-12);
    }
  }));
}

TEST(Chunks, near_a_position_are_all_visited_until_the_visitor_stops) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "contact_chunks_test/around"};
    std::vector<Circuit::Part> parts;
    for (int i = 0; i < 20; ++i) {
      const Pose2 start{random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)};
      parts.push_back(part("s" + std::to_string(i), section(start, random.uniform(0.1, 1.5))));
    }
    const Circuit circuit = testing::circuit(std::move(parts));
    const ContactRules rules{{0.20, 0.12}, 0.04};
    Chunks chunks{circuit, rules};
    double radius_max_m = 0.0;
    for (std::uint32_t i = 0; i < chunks.size(); ++i) radius_max_m = std::max(radius_max_m, chunks[i].radius_m());
    for (int query = 0; query < 10; ++query) {
      const Point2 p{random.uniform(-3.0, 3.0), random.uniform(-3.0, 3.0)};
      std::set<std::uint32_t> visited;
      chunks.visit_around(p, [&](std::uint32_t i) {
        RC_ASSERT(visited.insert(i).second);
        return true;
      });
      for (std::uint32_t i = 0; i < chunks.size(); ++i) {
        const double apart_m = distance(chunks[i].centre, p);
        if (apart_m <= 2.0 * radius_max_m + rules.reach_m) RC_ASSERT(visited.count(i) == 1U);
        // Nine cells around p, each as wide as two chunks and their reach.
        if (apart_m > 3.0 * (2.0 * radius_max_m + 1.5 * rules.reach_m)) RC_ASSERT(visited.count(i) == 0U);
      }
      std::size_t steps = 0;
      chunks.visit_around(p, [&](std::uint32_t) { return ++steps < 2; });
      RC_ASSERT(steps == std::min<std::size_t>(2, visited.size()));
    }
  }));
}

}  // namespace
}  // namespace cosiva::zone
