#include "cosiva/aiv/decision/obstacle_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "cosiva/aiv/testing/test_graphs.h"
#include "cosiva/aiv/testing/test_senses.h"
#include "cosiva/aiv/testing/test_zone.h"

namespace cosiva::aiv {
namespace {

using test::at;
using test::lacet4;
using test::ranges_to;

constexpr double infinite = std::numeric_limits<double>::infinity();

/// A vehicle that is stopped on the straight `east`, and its ranges.
struct Scene {
  PositionEstimator position{lacet4()};
  ObstacleWatch watch;
  explicit Scene(bool one_way = true) : watch{lacet4(), one_way} { position.position_at(at(lacet4(), "east", 0.3)); }

  void see(const std::vector<Point2>& obstacles_B, int frames = 1) {
    std::vector<Point2> obstacles;
    for (const Point2& p_B : obstacles_B) obstacles.push_back(position.pose() * p_B);
    for (int k = 0; k < frames; ++k) watch.on_ranges(position, ranges_to(obstacles, position.pose()));
  }
};

TEST(ObstacleWatch, measures_from_the_vehicle_s_front) {
  Scene scene;
  EXPECT_EQ(scene.watch.ahead_m(scene.position), infinite);
  scene.see({{0.50, 0.0}}, 3);
  EXPECT_NEAR(scene.watch.ahead_m(scene.position), 0.50 - 0.5 * lacet4().vehicle.length_m, 0.01);
  EXPECT_NEAR(scene.watch.scan().ahead_m, 0.50 - 0.5 * lacet4().vehicle.length_m, 0.01);
}

TEST(ObstacleWatch, does_not_accept_one_frame_alone) {
  Scene scene;
  scene.see({}, 3);
  scene.see({{0.50, 0.0}});
  EXPECT_EQ(scene.watch.ahead_m(scene.position), infinite);
  EXPECT_LT(scene.watch.scan().ahead_m, infinite) << "the unfiltered detection contains the obstacle";
  scene.see({{0.50, 0.0}});
  EXPECT_LT(scene.watch.ahead_m(scene.position), infinite);
}

TEST(ObstacleWatch, discards_earlier_frames_after_a_jump_of_the_position) {
  Scene scene;
  scene.see({{0.50, 0.0}}, 3);
  scene.watch.clear_ahead();
  EXPECT_EQ(scene.watch.ahead_m(scene.position), infinite);
}

TEST(ObstacleWatch, forbids_a_turn_on_the_spot_next_to_a_body_unless_no_bend_is_near) {
  Scene scene{false};
  const double corner_m = 0.5 * std::hypot(lacet4().vehicle.length_m, lacet4().vehicle.width_m);
  scene.see({{corner_m + 0.03, 0.0}}, 3);
  EXPECT_FALSE(scene.watch.may_sweep(scene.position, 0.0));
  EXPECT_TRUE(scene.watch.may_sweep(scene.position, 1.0));
  scene.see({{corner_m + 0.10, 0.0}}, 3);
  EXPECT_TRUE(scene.watch.may_sweep(scene.position, 0.0));
}

TEST(ObstacleWatch, keeps_five_centimetres_round_a_turn_and_expects_it_within_three_of_the_bend) {
  const double corner_m = 0.5 * std::hypot(lacet4().vehicle.length_m, lacet4().vehicle.width_m);
  Scene near{false};
  near.see({{corner_m + 0.049, 0.0}}, 3);
  EXPECT_FALSE(near.watch.may_sweep(near.position, 0.0));
  EXPECT_FALSE(near.watch.may_sweep(near.position, 0.03));
  EXPECT_TRUE(near.watch.may_sweep(near.position, 0.031));
  Scene far{false};
  far.see({{corner_m + 0.051, 0.0}}, 3);
  EXPECT_TRUE(far.watch.may_sweep(far.position, 0.0));
}

TEST(ObstacleWatch, permits_any_motion_on_the_path_of_a_zone_without_turns) {
  Scene scene{true};
  scene.see({{0.12, 0.0}}, 3);
  EXPECT_TRUE(scene.watch.may_sweep(scene.position, 0.0));
}

TEST(ObstacleWatch, permits_no_entry_to_a_path_over_a_body_until_another_goal_is_given) {
  const zone::TrafficZone zone = test::graph("lane", {{"lane", {}, 2.0, 0.0, {}}}, {});
  PositionEstimator position{zone};
  position.set_off_path({1.0, -0.2, 0.5 * pi});  // facing the path
  ASSERT_TRUE(position.near_path());
  ObstacleWatch watch{zone, true};
  const auto may_sweep_with = [&](Point2 body) {
    for (int k = 0; k < 3; ++k) watch.on_ranges(position, ranges_to({body}, position.pose()));
    return watch.may_sweep(position, infinite);
  };
  EXPECT_FALSE(may_sweep_with({1.0, -0.05}));
  watch.clear_entry();
  EXPECT_TRUE(watch.may_sweep(position, infinite));
  EXPECT_TRUE(may_sweep_with({1.0, 0.2})) << "beyond the path";
}

TEST(ObstacleWatchDeathTest, takes_ranges_at_a_known_position_only) {
  PositionEstimator unknown{lacet4()};
  ObstacleWatch watch{lacet4(), true};
  EXPECT_DEATH(watch.on_ranges(unknown, wire::Ranges{0, 0, 14, {500}}), "known");
}

}  // namespace
}  // namespace cosiva::aiv
