#include "cosiva/aiv/estimation/planar.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>
#include <string>

#include "cosiva/aiv/estimation/calibrating.h"
#include "cosiva/aiv/estimation/particles.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/aiv/estimation/test_tracks.h"
#include "cosiva/base/random.h"

namespace cosiva::estimation {
namespace {

/// A vehicle that drives round a circle of 2 m with Gaussian noise, and measures ranges to four stations in the
/// corners.
struct Round {
  Setting setting;
  double bias_m{0.0};
  double scale{1.0};
  Pose2 ground_truth;

  template <typename Algo>
  double rmse(Algo& algorithm, std::uint64_t seed, int steps = 600, bool ranges = true,
              std::vector<double>* nees = {}) {
    Random random{seed, "round"};
    ground_truth = {2.0, 0.0, 0.5 * pi};
    double squares = 0.0;
    for (int i = 0; i < steps; ++i) {
      const Odometry truly{0.05, 0.025, 0.1};
      ground_truth = moved(ground_truth, truly);
      const Vector2 v = step_variances(setting.sensors, truly);
      algorithm.predict({truly.distance_m + random.gaussian(0.0, std::sqrt(v(0))),
                         truly.turn_rad + random.gaussian(0.0, std::sqrt(v(1))), 0.1});
      if (ranges) {
        const auto station = static_cast<std::uint32_t>(i % 4);
        const Point2 track_position{station % 2 == 0 ? -4.0 : 4.0, station < 2 ? -4.0 : 4.0};
        algorithm.rectify(Range{station, track_position,
                                scale * distance(position(ground_truth), track_position) + bias_m +
                                    random.gaussian(0.0, setting.sensors.range_sigma_m)});
      } else if (i % 10 == 9) {
        const Point2 fiducial = ground_truth * Point2{0.0, 0.01};
        algorithm.rectify(Reading{1, fiducial, {random.gaussian(0.0, 0.01), 0.01 + random.gaussian(0.0, 0.01)}});
      }
      const Estimate estimate = algorithm.estimate();
      squares += std::pow(distance(estimate.pose, ground_truth), 2);
      const Vector2 e(estimate.pose.x_m - ground_truth.x_m, estimate.pose.y_m - ground_truth.y_m);
      const Matrix2 c = estimate.covariance.template topLeftCorner<2, 2>();
      if (nees != nullptr) nees->push_back(e.dot(c.llt().solve(e)));
    }
    return std::sqrt(squares / steps);
  }
};

Round round_at_its_start() {
  Round round;
  round.setting.start = {2.0, 0.0, 0.5 * pi};
  return round;
}

/// Ranges without common errors, and a sensor model that states so.
Round round_without_biases() {
  Round round = round_at_its_start();
  estimation::SensorModel& sensors = round.setting.sensors;
  sensors.range_scale_sigma = sensors.range_common_sigma_m = sensors.range_station_sigma_m = 0.0;
  return round;
}

double mean(const std::vector<double>& v) {
  return std::accumulate(v.begin(), v.end(), 0.0) / static_cast<double>(v.size());
}

TEST(Planar, filters_of_the_pose_are_consistent_where_the_noise_is_as_modelled) {
  const Registry registry;
  for (const char* name : {"ekf", "ukf", "iekf"}) {
    for (const bool ranges : {true, false}) {
      std::vector<double> nees;
      double worst = 0.0;
      for (std::uint64_t seed = 1; seed <= 10; ++seed) {
        Round round = round_without_biases();
        const auto algorithm = *registry.make(name, round.setting);
        worst = std::fmax(worst, round.rmse(*algorithm, seed, 600, ranges, &nees));
      }
      EXPECT_LT(worst, 0.06) << name;
      EXPECT_NEAR(mean(nees), 2.0, 0.5) << name << (ranges ? " by ranges" : " by fiducials");
    }
  }
}

TEST(Planar, filters_agree_where_everything_is_nearly_linear) {
  Round round = round_without_biases();
  Ekf ekf{round.setting};
  Ukf ukf{round.setting};
  InvariantEkf iekf{round.setting};
  round.rmse(ekf, 3, 200);
  round.rmse(ukf, 3, 200);
  round.rmse(iekf, 3, 200);
  EXPECT_LT(distance(ekf.estimate().pose, ukf.estimate().pose), 0.01);
  EXPECT_LT(distance(ekf.estimate().pose, iekf.estimate().pose), 0.01);
  EXPECT_NEAR(ekf.estimate().covariance(0, 0) / iekf.estimate().covariance(0, 0), 1.0, 0.1);
}

TEST(InvariantEkf, does_not_become_certain_of_an_unobserved_heading) {
  // One fiducial, read again and again without motion: the readings give the position relative to the fiducial, never
  // the whole pose.
  Setting setting;
  setting.start_sigma_m = 1.0;
  setting.start_heading_sigma_rad = 0.5;
  InvariantEkf iekf{setting};
  const double before = iekf.estimate().covariance(2, 2);
  // Directly below the reader, so that no turn of the body is observable.
  for (int i = 0; i < 50; ++i) iekf.rectify(Reading{1, {0.0, 0.0}, {0.0, 0.0}});
  EXPECT_NEAR(iekf.estimate().covariance(2, 2), before, 1e-9);
}

TEST(Ekf, refuses_measurements_outside_its_gate) {
  Ekf ekf{round_at_its_start().setting};
  const Rectified rectified = ekf.rectify(Range{1, {-4.0, 0.0}, 9.0});
  EXPECT_FALSE(rectified.accepted);
  EXPECT_GT(*rectified.nis, gate_1);
  EXPECT_EQ(ekf.estimate().pose.x_m, 2.0);
}

TEST(Calibrating, estimates_the_errors_common_to_all_ranges) {
  Round round = round_at_its_start();
  round.bias_m = 0.3;
  round.setting.sensors.range_common_sigma_m = 0.3;
  CalibratingFilter calibrating{round.setting};
  EXPECT_LT(round.rmse(calibrating, 5), 0.08);
  // Bias and scale can hardly be separated where all stations are about 5 m away; their common effect is observable.
  const auto& mean = calibrating.state().mean;
  EXPECT_NEAR(mean(CalibratedState::range_common) + 5.0 * mean(CalibratedState::range_scale), 0.3, 0.12);
}

TEST(Calibrating, smoother_with_an_unknown_heading_adds_nothing_to_the_filter) {
  Setting setting;
  setting.start_heading_sigma_rad = 3.0;
  CalibratingSmoother smoother{setting};
  for (int i = 0; i < 100; ++i) smoother.predict({0.1, 0.01, 0.1});
  // Ten metres into an unknown direction: anywhere on a circle, as the covariance states.
  EXPECT_TRUE(smoother.revised().empty());
  EXPECT_GT(smoother.estimate().covariance(0, 0), 10.0);
  EXPECT_GT(smoother.estimate().covariance(1, 1), 10.0);
}

TEST(CalibratingStatistics, smoother_is_better_than_the_filter_and_consistent) {
  double filter = 0.0;
  double smoothed = 0.0;
  std::vector<double> nees;
  for (std::uint64_t seed = 1; seed <= 12; ++seed) {
    Round round = round_at_its_start();
    // Biases as the model expects them: present, with mean zero; and none where the model expects none.
    Random biases{seed, "biases"};
    round.bias_m = biases.gaussian(0.0, round.setting.sensors.range_common_sigma_m);
    round.scale = 1.0 + biases.gaussian(0.0, round.setting.sensors.range_scale_sigma);
    round.setting.sensors.range_station_sigma_m = 1e-3;
    round.setting.sensors.distance_scale_sigma = round.setting.sensors.turn_scale_sigma = 1e-4;
    CalibratingSmoother smoother{round.setting};
    filter += round.rmse(smoother, seed, 300);
    const auto revised = smoother.revised();
    ASSERT_EQ(revised.size(), 300U);
    Pose2 ground_truth{2.0, 0.0, 0.5 * pi};
    double squares = 0.0;
    for (const Estimate& estimate : revised) {
      ground_truth = moved(ground_truth, {0.05, 0.025, 0.1});
      const Vector2 e(estimate.pose.x_m - ground_truth.x_m, estimate.pose.y_m - ground_truth.y_m);
      squares += e.squaredNorm();
      nees.push_back(e.dot(Matrix2(estimate.covariance.topLeftCorner<2, 2>()).llt().solve(e)));
    }
    smoothed += std::sqrt(squares / 300.0);
  }
  EXPECT_LT(smoothed, 0.9 * filter);
  EXPECT_NEAR(mean(nees), 2.0, 0.7);
}

TEST(Calibrating, finds_an_unknown_heading) {
  Round round = round_at_its_start();
  round.setting.start_heading_sigma_rad = pi;
  round.setting.start.heading_rad = 0.0;  // ignored
  CalibratingSmoother algorithm{round.setting};
  EXPECT_GT(algorithm.estimate().covariance(2, 2), 1.0);
  round.rmse(algorithm, 2, 200);
  EXPECT_NEAR(wrap_angle(algorithm.estimate().pose.heading_rad - round.ground_truth.heading_rad), 0.0, 0.1);
  EXPECT_LT(distance(algorithm.estimate().pose, round.ground_truth), 0.1);
  // The smoother knows the heading from the beginning.
  EXPECT_NEAR(wrap_angle(algorithm.revised()[1].pose.heading_rad - 0.5 * pi - 0.05), 0.0, 0.1);
}

TEST(Calibrating, is_robust_against_one_outlier_range) {
  Round round = round_at_its_start();
  CalibratingFilter calm{round.setting};
  round.rmse(calm, 4, 200);
  const Pose2 before = calm.estimate().pose;
  calm.rectify(Range{0, {-4.0, -4.0}, 20.0});
  EXPECT_LT(distance(calm.estimate().pose, before), 0.02);
}

TEST(Particles, find_the_position_on_a_known_circuit) {
  Setting setting;
  setting.track = testing::oval();
  setting.start_known = false;
  setting.particles = 2000;
  ParticleFilter particles{setting};
  EXPECT_GT(particles.estimate().covariance(0, 0), 0.5);  // anywhere
  Random random{1, "drive"};
  double along_m = 4.3;
  for (int i = 0; i < 300; ++i) {
    along_m += 0.02;
    particles.predict({0.02 + random.gaussian(0.0, std::sqrt(1e-4 * 0.02)), 0.0, 0.04});
    if (i % 25 == 24) {
      const Pose2 ground_truth = setting.track->pose_at(along_m);
      particles.rectify(Reading{1, position(ground_truth), {random.gaussian(0.0, 0.01), 0.0}});
    }
  }
  EXPECT_LT(distance(particles.estimate().pose, setting.track->pose_at(along_m)), 0.04);
}

TEST(Particles, take_both_branches_until_a_fiducial_decides) {
  std::vector<zone::Circuit::Part> parts;
  parts.push_back(testing::part("stem", {0.0, 0.0, 0.0}, 1.0, 0.0, {1, 2}));
  parts.push_back(testing::part("on", {1.0, 0.0, 0.0}, 3.0, 0.0, {}));
  parts.push_back(testing::part("left", {1.0, 0.0, 0.0}, 3.0, 0.5, {}));
  Setting setting;
  setting.track = testing::track(testing::circuit(std::move(parts)), {0, 1}, false);
  ParticleFilter particles{setting};
  for (int i = 0; i < 25; ++i) particles.predict({0.1, 0.0, 0.1});
  EXPECT_GT(particles.estimate().covariance(1, 1), 0.05);
  const Pose2 left = setting.track->circuit().pose_at({2, 1.5});
  particles.rectify(Reading{1, position(left), {}});
  EXPECT_LT(distance(particles.estimate().pose, left), 0.05);
}

}  // namespace
}  // namespace cosiva::estimation
