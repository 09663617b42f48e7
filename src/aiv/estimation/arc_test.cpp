#include "cosiva/aiv/estimation/arc.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/estimation/planar.h"
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

Reading at(double x_m, double y_m = 0.0, double detected_m = 0.0) { return {1, {x_m, y_m}, {detected_m, 0.0}}; }
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

TEST(DeadReckoning, in_the_open_grows_uncertain_as_the_plane_s_filter_does) {
  Setting setting;
  setting.start = {1.0, 2.0, 0.3};
  DeadReckoning algorithm{setting};
  const Odometry odometry{0.5, 0.2, 0.1};
  algorithm.predict(odometry);
  const Matrix3 expected = spread(setting.sensors, setting.start, odometry, start_covariance(setting));
  EXPECT_EQ(algorithm.estimate().covariance, expected);
  EXPECT_FALSE(algorithm.estimate().along_m);
  EXPECT_FALSE(ResetRule{setting}.rectify(at(1.0)).accepted);
}

TEST(DeadReckoning, variance_grows_backwards_too_and_by_what_a_step_states) {
  DeadReckoning algorithm{setting_on(testing::straight(), 0.03)};
  algorithm.predict({3.0, 0.0, 1.0, 2e-4});
  algorithm.predict({-1.0, 0.0, 1.0});
  EXPECT_NEAR(algorithm.estimate().pose.x_m, 2.0, 1e-12);
  EXPECT_NEAR(*algorithm.estimate().along_m, 2.0, 1e-12);
  EXPECT_NEAR(variance(algorithm), 9e-4 + 4e-4 + 2e-4, 1e-15);
}

TEST(ArcKalman, and_its_variants_state_the_innovation_s_square_over_its_variance) {
  // P = 4e-4 + 2e-4 after two metres, R = 1e-4; the scale's part, (2 m·0.02)², in the filter that estimates it.
  Setting setting = setting_on(testing::straight());
  const auto nis_of = [](Algorithm& algorithm) {
    algorithm.predict({2.0, 0.0, 1.0});
    const Rectified rectified = algorithm.rectify(at(2.235, 0.0, 0.2));
    EXPECT_TRUE(rectified.accepted);
    EXPECT_EQ(rectified.dimensions, 1);
    return rectified.nis.value();
  };
  ResetRule reset{setting};
  ArcKalman kalman{setting};
  ArcSmoother smoother{setting};
  UnbiasedFir fir{setting};
  ArcKalmanScale scale{setting};
  for (Algorithm* algorithm : {static_cast<Algorithm*>(&reset), static_cast<Algorithm*>(&kalman),
                               static_cast<Algorithm*>(&smoother), static_cast<Algorithm*>(&fir)})
    EXPECT_NEAR(nis_of(*algorithm), 0.035 * 0.035 / 7e-4, 1e-9);
  EXPECT_NEAR(nis_of(scale), 0.035 * 0.035 / (7e-4 + 16e-4), 1e-9);
}

TEST(ArcKalman, contradicts_beyond_six_standard_deviations_only) {
  for (const double sigmas : {5.99, -5.99, 6.01, -6.01}) {
    ArcKalman algorithm{setting_on(testing::straight())};
    algorithm.predict({2.0, 0.0, 1.0});
    const double off_m = sigmas * std::sqrt(7e-4);
    EXPECT_EQ(algorithm.rectify(at(2.0 + off_m)).accepted, std::fabs(sigmas) < 6.0) << sigmas;
  }
}

TEST(ArcKalman, searches_for_a_fiducial_within_a_metre_or_two_gates) {
  // A certain estimate reaches a metre: a contradiction half a metre off is stored, one of over a metre is not.
  for (const double off_m : {0.9, -0.9, 1.1, -1.1}) {
    ArcKalman algorithm{setting_on(testing::straight())};
    algorithm.predict({5.0, 0.0, 1.0});
    EXPECT_FALSE(algorithm.rectify(at(5.0 + off_m)).accepted);
    EXPECT_EQ(algorithm.rectify(at(5.0 + off_m)).accepted, std::fabs(off_m) < 1.0) << off_m;
  }
  // Of an estimate with σ = 0.2 m the gate is 1.2 m and the reach 2.4 m.
  for (const double off_m : {2.3, 2.5}) {
    ArcKalman algorithm{setting_on(testing::straight(), 0.2)};
    algorithm.predict({5.0, 0.0, 1.0});
    EXPECT_FALSE(algorithm.rectify(at(5.0 + off_m)).accepted);
    EXPECT_EQ(algorithm.rectify(at(5.0 + off_m)).accepted, off_m < 2.4) << off_m;
  }
  // The reach is counted from where the fiducial is expected, ahead of the vehicle.
  ArcKalman kalman{setting_on(testing::straight())};
  EXPECT_TRUE(kalman.rectify(at(3.0, 0.0, 3.0)).accepted);
}

TEST(ArcKalman, needs_two_contradictions_in_a_row_that_agree_within_five_centimetres) {
  struct Case {
    std::vector<double> off_m;
    std::vector<bool> accepted;
  };
  for (const Case& one : {Case{{0.5, 0.54}, {false, true}},
                          {{0.5, 0.46}, {false, true}},
                          {{0.5, 0.56}, {false, false}},
                          {{0.5, 0.44}, {false, false}},
                          {{0.5, -0.5}, {false, false}},
                          {{0.5, 0.56, 0.6}, {false, false, true}},  // the last two agree
                          {{0.5, 0.56, 0.5}, {false, false, false}},
                          {{0.5, 0.0, 0.5}, {false, true, false}}}) {  // a good one in between
    ArcKalman algorithm{setting_on(testing::straight())};
    algorithm.predict({5.0, 0.0, 1.0});
    for (std::size_t i = 0; i < one.off_m.size(); ++i) {
      const double here_m = *algorithm.estimate().along_m;
      EXPECT_EQ(algorithm.rectify(at(here_m + one.off_m[i])).accepted, one.accepted[i]) << one.off_m[1] << " " << i;
    }
  }
}

TEST(ArcKalman, takes_two_agreeing_contradictions_for_its_own_error_and_forgets_them) {
  ArcKalman algorithm{setting_on(testing::straight())};
  algorithm.predict({5.0, 0.0, 1.0});
  algorithm.rectify(at(5.5));
  const Rectified rectified = algorithm.rectify(at(5.5));
  // The variance becomes the square of the contradiction, 0.25, before the correction.
  EXPECT_NEAR(*rectified.nis, 0.25 / (0.25 + 1e-4), 1e-12);
  EXPECT_NEAR(variance(algorithm), 0.25 * 1e-4 / (0.25 + 1e-4), 1e-12);
  EXPECT_FALSE(algorithm.rectify(at(6.0)).accepted);
}

TEST(ArcKalmanScale, is_the_kalman_filter_of_arc_length_and_scale) {
  Setting setting = setting_on(testing::straight(), 0.03);
  setting.sensors.distance_scale_sigma = 0.04;
  ArcKalmanScale algorithm{setting};
  Vector2 state(0.0, 0.0);
  Matrix2 p = Vector2(9e-4, 16e-4).asDiagonal();
  for (const auto& [counted_m, read_m] : {std::pair{1.0, 0.98}, {1.5, 2.43}, {-0.5, 1.94}, {2.0, 3.87}}) {
    algorithm.predict({counted_m, 0.0, 1.0, 3e-5});
    const double d = counted_m / (1.0 + state(1));
    Matrix2 f;
    f << 1.0, -d, 0.0, 1.0;
    state(0) += d;
    p = Matrix2(f * p * f.transpose());
    p(0, 0) += 1e-4 * std::fabs(counted_m) + 3e-5;
    EXPECT_NEAR(variance(algorithm), p(0, 0), 1e-12);
    EXPECT_TRUE(algorithm.rectify(at(read_m)).accepted);
    const Vector2 gain = p.col(0) / (p(0, 0) + 1e-4);
    state += gain * (read_m - state(0));
    p -= Matrix2(gain * p.row(0));
    EXPECT_NEAR(*algorithm.estimate().along_m, state(0), 1e-12);
    EXPECT_NEAR(algorithm.scale_error(), state(1), 1e-12);
    EXPECT_NEAR(variance(algorithm), p(0, 0), 1e-12);
  }
}

TEST(ArcSmoother, is_the_weighted_mean_of_the_filters_from_both_ends) {
  // Start, a reading between and one at the end; between them odometry. All of the line: a least-squares problem
  // of four positions, solved here by its normal equations.
  ArcSmoother algorithm{setting_on(testing::straight(), 0.02)};
  algorithm.predict({1.0, 0.0, 1.0});
  algorithm.predict({0.5, 0.0, 1.0});
  algorithm.rectify(at(1.53));
  algorithm.predict({2.0, 0.0, 1.0});
  algorithm.rectify(at(3.49));
  Eigen::Matrix4d information = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  const auto position_known = [&](int i, double m, double variance_m2) {
    information(i, i) += 1.0 / variance_m2;
    right(i) += m / variance_m2;
  };
  const auto odometry_between = [&](int i, double m) {
    const double weight = 1.0 / (1e-4 * m);
    information(i, i) += weight;
    information(i + 1, i + 1) += weight;
    information(i, i + 1) -= weight;
    information(i + 1, i) -= weight;
    right(i) -= m * weight;
    right(i + 1) += m * weight;
  };
  position_known(0, 0.0, 4e-4);
  odometry_between(0, 1.0);
  odometry_between(1, 0.5);
  position_known(2, 1.53, 1e-4);
  odometry_between(2, 2.0);
  position_known(3, 3.49, 1e-4);
  const Eigen::LLT<Eigen::Matrix4d> root(information);
  const Eigen::Vector4d mean = root.solve(right);
  const Eigen::Matrix4d covariance = root.solve(Eigen::Matrix4d::Identity());
  const std::vector<Estimate> revised = algorithm.revised();
  ASSERT_EQ(revised.size(), 3U);
  for (int i = 0; i < 3; ++i) {
    EXPECT_NEAR(revised[static_cast<std::size_t>(i)].pose.x_m, mean(i + 1), 1e-12);
    EXPECT_NEAR(revised[static_cast<std::size_t>(i)].covariance(0, 0), covariance(i + 1, i + 1), 1e-14);
  }
  EXPECT_EQ(revised[2].along_m, algorithm.estimate().along_m);
}

TEST(ArcSmoother, without_any_uncertainty_leaves_the_estimates) {
  Setting setting = setting_on(testing::straight(), 0.0);
  setting.sensors.distance_variance_per_m = 0.0;
  ArcSmoother algorithm{setting};
  EXPECT_TRUE(algorithm.revised().empty());
  algorithm.predict({1.0, 0.0, 1.0});
  algorithm.predict({1.0, 0.0, 1.0});
  const auto revised = algorithm.revised();
  ASSERT_EQ(revised.size(), 2U);
  EXPECT_NEAR(revised[0].pose.x_m, 1.0, 1e-12);
  EXPECT_NEAR(revised[1].pose.x_m, 2.0, 1e-12);
}

TEST(UnbiasedFir, counts_the_distance_since_a_reading_in_all_older_ones) {
  Setting setting = setting_on(testing::straight(), 0.05);
  setting.horizon = 3;
  UnbiasedFir algorithm{setting};
  algorithm.rectify(at(0.02));
  algorithm.predict({1.0, 0.0, 1.0});
  algorithm.predict({-0.5, 0.0, 1.0});
  algorithm.predict({1.5, 0.0, 1.0});
  algorithm.rectify(at(2.05));
  algorithm.predict({0.5, 0.0, 1.0});
  algorithm.rectify(at(2.49));
  // By the three: 2.02 + 0.5, 2.05 + 0.5 and 2.49.
  EXPECT_NEAR(*algorithm.estimate().along_m, (2.52 + 2.55 + 2.49) / 3.0, 1e-12);
  // R/3; an error of the first three metres is part of one position of three, of the last half metre of two.
  EXPECT_NEAR(variance(algorithm), 1e-4 / 3.0 + 1e-4 * (3.0 + 4.0 * 0.5) / 9.0, 1e-15);
}

TEST(Registry, states_of_each_algorithm_whether_it_needs_a_track_or_the_whole_run) {
  struct Row {
    const char* name;
    bool needs_track;
    bool backtracks;
  };
  const std::vector<Row> rows{{"dead_reckoning", false, false},
                              {"reset_rule", true, false},
                              {"arc_kalman", true, false},
                              {"arc_kalman_scale", true, false},
                              {"ekf", false, false},
                              {"ukf", false, false},
                              {"iekf", false, false},
                              {"particles", true, false},
                              {"arc_smoother", true, true},
                              {"ufir", true, false},
                              {"calibrating", false, false},
                              {"smoother", false, true}};
  const Registry registry;
  ASSERT_EQ(registry.all().size(), rows.size());
  std::string names;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Registered& one = registry.all()[i];
    EXPECT_EQ(one.name, rows[i].name);
    EXPECT_EQ(one.needs_track, rows[i].needs_track) << one.name;
    EXPECT_EQ(one.backtracks, rows[i].backtracks) << one.name;
    EXPECT_FALSE(one.what.empty());
    EXPECT_EQ(registry.make(one.name, {}).has_value(), !one.needs_track) << one.name;
    EXPECT_TRUE(registry.make(one.name, setting_on(testing::oval()))) << one.name;
    names += (names.empty() ? "" : ", ") + one.name;
  }
  const Error unknown = registry.find("kalman").error();
  EXPECT_NE(unknown.message.find("there are " + names), std::string::npos) << unknown.message;
}

TEST(Registry, name_has_lower_case_digits_and_underlines) {
  const auto make = [](const Setting& s) -> std::unique_ptr<Algorithm> { return std::make_unique<ResetRule>(s); };
  for (const char* good : {"a", "z", "0", "9", "_", "my_2nd"}) {
    Registry registry;
    EXPECT_TRUE(registry.add({good, "", true, false, make})) << good;
    EXPECT_EQ(registry.all().back().name, good);
  }
  // The neighbours of the permitted characters.
  for (const char* bad : {"", "`", "{", "/", ":", "^", "a b", "A", "a-b"})
    EXPECT_EQ(Registry{}.add({bad, "", true, false, make}).error().code, "algorithm.name") << bad;
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

TEST(ArcKalman, accepts_a_reading_exactly_six_standard_deviations_off) {
  Setting setting = setting_on(testing::straight(), 0.0);
  setting.sensors.distance_variance_per_m = 0.0;
  setting.sensors.fiducial_along_sigma_m = 0.0625;
  for (const double off_m : {0.375, -0.375, 0.37501, -0.37501}) {
    ArcKalman algorithm{setting};
    algorithm.predict({5.0, 0.0, 1.0});
    EXPECT_EQ(algorithm.rectify(at(5.0 + off_m)).accepted, std::fabs(off_m) == 0.375) << off_m;
  }
}

TEST(ArcDeathTest, has_a_variance_that_is_not_negative_and_a_mean_of_at_least_one_reading) {
  DeadReckoning algorithm{setting_on(testing::straight())};
  EXPECT_DEATH(algorithm.predict({1.0, 0.0, 1.0, -1.0}), "p_m2 < 0.0");
  Setting setting = setting_on(testing::straight());
  setting.horizon = 0;
  UnbiasedFir fir{setting};
  EXPECT_DEATH(fir.rectify(at(0.02)), "snaps_.empty");
}

}  // namespace
}  // namespace cosiva::estimation
