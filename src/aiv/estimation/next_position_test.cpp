#include "cosiva/aiv/estimation/next_position.h"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <numbers>

#include "cosiva/aiv/estimation/test_tracks.h"

namespace cosiva::estimation {
namespace {

TEST(NextPosition, is_straight_on_without_a_track) {
  const Estimate estimate{{1.0, 2.0, 0.5 * std::numbers::pi}, {}, {}};
  const Pose2 next = next_position(estimate, nullptr, 0.0, 0.25);
  EXPECT_NEAR(next.x_m, 1.0, 1e-12);
  EXPECT_NEAR(next.y_m, 2.25, 1e-12);
}

TEST(NextPosition, is_the_track_s_pose_after_the_distance_over_any_number_of_joints) {
  const auto shared = testing::oval();
  const Track& track = *shared;
  for (double along_m = 0.0; along_m < track.length_m(); along_m += 0.37) {
    const Estimate stated{track.pose_at(along_m), {}, along_m};
    const Estimate planar{track.pose_at(along_m), {}, {}};
    for (const double move_m : {0.0, 0.1, 1.0, 3.0}) {
      const Pose2 expected = track.pose_at(along_m + move_m);
      EXPECT_LT(distance(next_position(stated, &track, 0.0, move_m), expected), 1e-9) << along_m;
      EXPECT_LT(distance(next_position(planar, &track, along_m + 0.05, move_m), expected), 1e-6) << along_m;
    }
  }
}

// 0.10 m before the half circle of 0.8 m a move of 0.50 m ends 0.40 m, half a radian, into it.
TEST(NextPosition, follows_the_arc_s_closed_form) {
  const Pose2 next = next_position({{2.9, 0.0, 0.0}, {}, 2.9}, testing::oval().get(), 0.0, 0.5);
  EXPECT_NEAR(next.x_m, 3.0 + 0.8 * std::sin(0.5), 1e-12);
  EXPECT_NEAR(next.y_m, 0.8 * (1.0 - std::cos(0.5)), 1e-12);
  EXPECT_NEAR(next.heading_rad, 0.5, 1e-12);
}

TEST(NextPosition, keeps_the_offset_of_the_estimate_from_the_track) {
  const auto shared = testing::oval();
  const Track& track = *shared;
  const double along_m = 0.4;
  const Estimate estimate{track.pose_at(along_m) * Pose2{0.0, 0.02, 0.01}, {}, {}};
  const Pose2 X_PB = inverse(track.pose_at(along_m + 0.5)) * next_position(estimate, &track, along_m, 0.5);
  EXPECT_NEAR(X_PB.x_m, 0.0, 1e-6);
  EXPECT_NEAR(X_PB.y_m, 0.02, 1e-6);
  EXPECT_NEAR(X_PB.heading_rad, 0.01, 1e-9);
}

TEST(NextPosition, is_straight_on_where_the_estimate_is_far_from_the_track) {
  const auto shared = testing::oval();
  const Track& track = *shared;
  const Estimate estimate{{50.0, 50.0, 0.0}, {}, {}};
  EXPECT_NEAR(next_position(estimate, &track, 0.0, 0.5).x_m, 50.5, 1e-12);
}

}  // namespace
}  // namespace cosiva::estimation
