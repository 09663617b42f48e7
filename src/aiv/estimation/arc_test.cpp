#include "cosiva/aiv/estimation/arc.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/aiv/estimation/test_tracks.h"

namespace cosiva::estimation {
namespace {

Setting setting_on(std::shared_ptr<const Track> track, double start_sigma_m = 0.02) {
  Setting setting;
  setting.start = track->pose_at(0.0);
  setting.track = std::move(track);
  setting.start_sigma_m = start_sigma_m;
  setting.sensors.line_sigma_m = 0.0;
  return setting;
}

Reading at(double x_m, double y_m = 0.0, double detected_ahead_m = 0.0) {
  return {1, {x_m, y_m}, {detected_ahead_m, 0.0}};
}
double variance(const Algorithm& algorithm) { return algorithm.estimate().covariance(0, 0); }

TEST(DeadReckoning, follows_the_sections_equations_and_grows_uncertain) {
  DeadReckoning algorithm{setting_on(testing::oval(), 0.0)};
  algorithm.predict({3.0, 0.0, 1.0});
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 3.0, 1e-12);
  algorithm.predict({pi * 0.4, 0.0, 1.0});  // a quarter of the circle, equation (1)
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 3.8, 1e-9);
  EXPECT_NEAR(algorithm.estimate().pose.y_m, 0.8, 1e-9);
  EXPECT_NEAR(algorithm.estimate().pose.heading_rad, 0.5 * pi, 1e-9);
  // Along the path, which leads north there: q times the distance.
  EXPECT_NEAR(algorithm.estimate().covariance(1, 1), 1e-4 * (3.0 + pi * 0.4), 1e-12);
  algorithm.rectify(at(0.0));
  EXPECT_NEAR(algorithm.estimate().pose.y_m, 0.8, 1e-9);
}

TEST(DeadReckoning, in_the_open_follows_arcs_of_circles) {
  Setting setting;
  DeadReckoning algorithm{setting};
  for (int i = 0; i < 7; ++i) algorithm.predict({pi / 7.0, pi / 7.0, 0.1});
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 0.0, 1e-12);
  EXPECT_NEAR(algorithm.estimate().pose.y_m, 2.0, 1e-12);
}

TEST(ResetRule, is_where_the_fiducial_is) {
  ResetRule algorithm{setting_on(testing::straight())};
  algorithm.predict({1.0, 0.0, 1.0});
  const Rectified rectified = algorithm.rectify(at(1.03, 0.0, 0.01));
  EXPECT_TRUE(rectified.accepted);
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 1.02, 1e-12);
  EXPECT_NEAR(variance(algorithm), 1e-4, 1e-15);
}

TEST(ArcKalman, weighs_estimate_and_fiducial_by_their_variances) {
  ArcKalman algorithm{setting_on(testing::straight())};
  algorithm.predict({2.0, 0.0, 1.0});
  // P = 4e-4 + 2e-4, R = 1e-4: gain 6/7.
  const Rectified rectified = algorithm.rectify(at(2.035));
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 2.0 + 0.035 * 6.0 / 7.0, 1e-12);
  EXPECT_NEAR(variance(algorithm), 6e-4 / 7.0, 1e-15);
  EXPECT_NEAR(*rectified.nis, 0.035 * 0.035 / 7e-4, 1e-9);
}

TEST(ArcKalman, refuses_one_contradicting_fiducial_and_accepts_two_that_agree) {
  ArcKalman algorithm{setting_on(testing::straight())};
  algorithm.predict({2.0, 0.0, 1.0});
  EXPECT_FALSE(algorithm.rectify(at(2.6)).accepted);
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 2.0, 1e-12);
  algorithm.predict({1.0, 0.0, 1.0});
  EXPECT_TRUE(algorithm.rectify(at(3.6)).accepted);
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 3.6, 0.01);
}

TEST(ArcKalman, refuses_a_fiducial_that_is_far_away) {
  ArcKalman algorithm{setting_on(testing::straight())};
  EXPECT_FALSE(algorithm.rectify(at(9.0)).accepted);
  EXPECT_FALSE(algorithm.rectify(at(0.0, 0.5)).accepted);
  EXPECT_FALSE(algorithm.rectify(Range{1, {0.0, 0.0}, 3.0}).accepted);
}

TEST(ArcKalmanScale, finds_the_scale_of_a_worn_wheel) {
  ArcKalmanScale algorithm{setting_on(testing::oval(), 0.001)};
  for (int i = 1; i <= 200; ++i) {
    algorithm.predict({0.5 * 1.03, 0.0, 1.0});
    const Pose2 ground_truth = testing::oval()->pose_at(0.5 * i);
    algorithm.rectify(Reading{1, position(ground_truth), {}});
  }
  EXPECT_NEAR(algorithm.scale_error(), 0.03, 1e-3);
}

TEST(ArcSmoother, applies_a_reading_to_earlier_estimates) {
  ArcSmoother algorithm{setting_on(testing::straight(), 0.0)};
  algorithm.predict({1.0, 0.0, 1.0});
  algorithm.predict({1.0, 0.0, 1.0});
  algorithm.rectify(at(2.03));
  // Q = 2e-4, R = 1e-4: two thirds of 3 cm at the end, and half of that at the midpoint.
  const auto revised = algorithm.revised();
  ASSERT_EQ(revised.size(), 2U);
  EXPECT_NEAR(revised[1].pose.x_m, 2.02, 1e-12);
  EXPECT_NEAR(revised[0].pose.x_m, 1.01, 1e-12);
  // Between two fixed ends: 1e-4·(1e-4 + R)/(2e-4 + R).
  EXPECT_NEAR(revised[0].covariance(0, 0), 1e-4 * 2e-4 / 3e-4, 1e-15);
}

TEST(UnbiasedFir, is_the_mean_by_its_last_readings) {
  Setting setting = setting_on(testing::straight(), 0.05);
  setting.horizon = 2;
  UnbiasedFir algorithm{setting};
  algorithm.predict({1.0, 0.0, 1.0});
  algorithm.rectify(at(1.10));
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 1.10, 1e-12);
  algorithm.predict({1.0, 0.0, 1.0});
  algorithm.rectify(at(2.06));
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 2.08, 1e-12);
  algorithm.predict({1.0, 0.0, 1.0});
  algorithm.rectify(at(3.06));  // the first reading is dropped
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 3.06, 1e-12);
  // R/2, and the last metre in one of two.
  EXPECT_NEAR(variance(algorithm), 0.5e-4 + 0.25 * 1e-4, 1e-15);
}

TEST(Registry, has_the_built_in_algorithms_and_refuses_unknown_ones) {
  const Registry registry;
  EXPECT_GE(registry.all().size(), 10U);
  EXPECT_EQ(registry.find("kalman").error().code, "algorithm.unknown");
  EXPECT_NE(registry.find("kalman").error().message.find("arc_kalman"), std::string::npos);
  EXPECT_EQ(registry.make("arc_kalman", {}).error().code, "algorithm.track");
  Setting lost = setting_on(testing::oval());
  lost.start_known = false;
  EXPECT_EQ(registry.make("arc_kalman", lost).error().code, "algorithm.start");
  EXPECT_TRUE(registry.make("particles", lost));
  EXPECT_TRUE(registry.make("ekf", {}));
}

TEST(Registry, accepts_another_algorithm_under_a_new_name) {
  Registry registry;
  const auto make = [](const Setting& s) -> std::unique_ptr<Algorithm> { return std::make_unique<ResetRule>(s); };
  EXPECT_TRUE(registry.add({"mine", "like the article", true, false, make}));
  EXPECT_TRUE(registry.make("mine", setting_on(testing::oval())));
  EXPECT_EQ(registry.add({"ekf", "", false, false, make}).error().code, "algorithm.duplicate");
  EXPECT_EQ(registry.add({"My own", "", false, false, make}).error().code, "algorithm.name");
}

}  // namespace
}  // namespace cosiva::estimation
