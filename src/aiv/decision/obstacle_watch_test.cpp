#include "cosiva/aiv/decision/obstacle_watch.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

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

}  // namespace
}  // namespace cosiva::aiv
