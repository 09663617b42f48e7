#include "cosiva/physical/plant/collisions.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <array>
#include <cmath>

#include "cosiva/base/random.h"

namespace cosiva::physical {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;

constexpr zone::VehicleShape shape{0.20, 0.12};

BodyPose at(double x, double y, double heading = 0.0) { return BodyPose::at({x, y, heading}); }

/// The slow reference: some point of a fine grid over one body lies in the other.
bool overlap_sampled(const BodyPose& a, const BodyPose& b) {
  constexpr int n = 100;
  for (int i = 0; i <= n; ++i) {
    for (int j = 0; j <= n; ++j) {
      const Point2 p =
          b.to_body(a.to_map({0.2 * (static_cast<double>(i) / n - 0.5), 0.12 * (static_cast<double>(j) / n - 0.5)}));
      if (std::fabs(p.x_m) <= 0.1 && std::fabs(p.y_m) <= 0.06) return true;
    }
  }
  return false;
}

TEST(Touch, begins_where_two_bodies_meet) {
  EXPECT_TRUE(touch(at(0, 0), at(0.1999, 0), shape));
  EXPECT_FALSE(touch(at(0, 0), at(0.2001, 0), shape));
  EXPECT_TRUE(touch(at(0, 0), at(0, 0.1199), shape));
  EXPECT_FALSE(touch(at(0, 0), at(0, 0.1201), shape));
  EXPECT_TRUE(touch(at(0, 0), at(0.1599, 0, pi / 2), shape));  // half a length and half a width
  EXPECT_FALSE(touch(at(0, 0), at(0.1601, 0, pi / 2), shape));
}

TEST(Touch, needs_more_than_overlapping_shadows) {
  // Turned by 45°, corner to corner: both overlap along x and along y, but not along the diagonal.
  EXPECT_FALSE(touch(at(0, 0), at(0.19, 0.15, pi / 4), shape));
}

TEST(Touch, agrees_with_sampling_for_any_two_poses) {
  EXPECT_TRUE(rc::check("separating axes", [] {
    const auto draw = [](int high) { return *rc::gen::inRange(-high, high) * 0.001; };
    const BodyPose a = at(draw(100), draw(100), draw(3141));
    const BodyPose b = at(draw(250), draw(250), draw(3141));
    RC_ASSERT(touch(a, b, shape) == touch(b, a, shape));
    if (overlap_sampled(a, b)) {
      RC_ASSERT(touch(a, b, shape));
    } else {
      // The grid is 2 mm coarse: a contact that it misses must vanish when the bodies are that much smaller.
      constexpr zone::VehicleShape smaller{0.196, 0.116};
      RC_ASSERT(!touch(a, b, smaller));
    }
  }));
}

TEST(Touch, detects_a_disc_at_a_side_and_at_a_corner) {
  const BodyPose body = at(1, 1, pi / 2);
  EXPECT_TRUE(touch(body, Disc{{1.0, 1.1 + 0.0499}, 0.05}, shape));
  EXPECT_FALSE(touch(body, Disc{{1.0, 1.1 + 0.0501}, 0.05}, shape));
  EXPECT_TRUE(touch(body, Disc{{1.0 + 0.06 + 0.03, 1.1 + 0.0399}, 0.05}, shape));  // 3-4-5 off the corner
  EXPECT_FALSE(touch(body, Disc{{1.0 + 0.06 + 0.03, 1.1 + 0.0401}, 0.05}, shape));
  EXPECT_TRUE(touch(body, Disc{{1.0, 1.0}, 0.001}, shape));
}

TEST(CollisionWatch, reports_a_contact_once_until_the_bodies_part) {
  CollisionWatch watch{shape};
  std::vector<CollisionWatch::Pair> began;
  const auto detect_contacts = [&](double x) {
    const std::array bodies{at(x, 0), at(0, 0)};
    began.clear();
    watch.detect_contacts(bodies, {}, began);
    return began;
  };
  EXPECT_THAT(detect_contacts(0.3), IsEmpty());
  EXPECT_THAT(detect_contacts(0.19), ElementsAre(CollisionWatch::Pair{0, 1}));
  EXPECT_THAT(detect_contacts(0.18), IsEmpty());
  EXPECT_THAT(detect_contacts(0.21), IsEmpty());
  EXPECT_THAT(detect_contacts(0.19), ElementsAre(CollisionWatch::Pair{0, 1}));
}

TEST(CollisionWatch, reports_an_obstacle_by_its_key) {
  CollisionWatch watch{shape};
  std::vector<CollisionWatch::Pair> began;
  const std::array bodies{at(5, 0), at(0, 0)};
  const CollisionWatch::BodyKey key = CollisionWatch::obstacle_bit + 3;
  const std::array<CollisionWatch::Obstacle, 1> obstacles{{{key, {{0.12, 0.0}, 0.05}}}};
  watch.detect_contacts(bodies, obstacles, began);
  watch.detect_contacts(bodies, obstacles, began);
  EXPECT_THAT(began, ElementsAre(CollisionWatch::Pair{1, key}));
}

TEST(CollisionWatch, finds_the_same_pairs_as_an_exhaustive_search) {
  Random random{9, "bodies"};
  std::vector<BodyPose> bodies(40);
  for (int round = 0; round < 50; ++round) {
    CollisionWatch watch{shape};
    for (auto& body : bodies) body = at(random.uniform(0, 2), random.uniform(0, 2), random.uniform(-3, 3));
    std::vector<CollisionWatch::Pair> began;
    watch.detect_contacts(bodies, {}, began);
    std::sort(began.begin(), began.end());
    std::vector<CollisionWatch::Pair> all;
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      for (std::size_t j = i + 1; j < bodies.size(); ++j) {
        if (touch(bodies[i], bodies[j], shape)) all.push_back({i, j});
      }
    }
    ASSERT_EQ(began, all);
    ASSERT_FALSE(all.empty());
  }
}

}  // namespace
}  // namespace cosiva::physical
