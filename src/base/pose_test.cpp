#include "cosiva/base/pose.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <cmath>

#include "cosiva/base/random.h"

namespace cosiva {
namespace {

Pose2 any_pose(Random& random) {
  return {random.uniform(-10.0, 10.0), random.uniform(-10.0, 10.0), random.uniform(-3.14, 3.14)};
}

bool near(const Pose2& a, const Pose2& b) {
  return distance(a, b) < 1e-13 && std::fabs(wrap_angle(a.heading_rad - b.heading_rad)) < 1e-14;
}

TEST(Pose, maps_a_point_of_the_body_to_the_map) {
  const Pose2 X_MB{1.0, 2.0, pi / 2.0};
  const Point2 p_M = X_MB * Point2{3.0, 1.0};  // 3 forward (north), 1 to the left (west)
  EXPECT_NEAR(p_M.x_m, 0.0, 1e-15);
  EXPECT_NEAR(p_M.y_m, 5.0, 1e-15);
}

TEST(Pose, of_a_turn_after_a_turn_is_their_sum_wrapped) {
  const Pose2 X_AC = Pose2{0.0, 0.0, 3.0} * Pose2{0.0, 0.0, 1.0};
  EXPECT_NEAR(X_AC.heading_rad, 4.0 - 2.0 * pi, 1e-15);
}

TEST(Pose, times_its_inverse_is_the_identity) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "pose_test"};
    const Pose2 X_AB = any_pose(random);
    RC_ASSERT(near(X_AB * inverse(X_AB), Pose2{}));
    RC_ASSERT(near(inverse(X_AB) * X_AB, Pose2{}));
  }));
}

TEST(Pose, products_are_associative) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "pose_test"};
    const Pose2 X_AB = any_pose(random);
    const Pose2 X_BC = any_pose(random);
    const Pose2 X_CD = any_pose(random);
    RC_ASSERT(near((X_AB * X_BC) * X_CD, X_AB * (X_BC * X_CD)));
    const Point2 p_D{random.uniform(-1.0, 1.0), random.uniform(-1.0, 1.0)};
    RC_ASSERT(distance((X_AB * X_BC) * p_D, X_AB * (X_BC * p_D)) < 1e-13);
  }));
}

TEST(Pose, preserves_distances) {
  EXPECT_TRUE(rc::check([] {
    Random random{*rc::gen::arbitrary<std::uint64_t>(), "pose_test"};
    const Pose2 X_AB = any_pose(random);
    const Pose2 one = any_pose(random);
    const Pose2 other = any_pose(random);
    RC_ASSERT(std::fabs(distance(X_AB * one, X_AB * other) - distance(one, other)) < 1e-13);
  }));
}

}  // namespace
}  // namespace cosiva
