#include "cosiva/aiv/estimation/particles.h"

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/aiv/estimation/test_tracks.h"
#include "cosiva/base/math.h"

namespace cosiva::estimation {
namespace {

/// All particles at one arc length, odometry without errors: a filter that moves exactly.
Setting exact(std::shared_ptr<const Track> track, double start_along_m) {
  Setting setting;
  setting.track = std::move(track);
  setting.start_along_m = start_along_m;
  setting.start_sigma_m = 0.0;
  setting.sensors.distance_variance_per_m = 0.0;
  setting.particles = 10;
  return setting;
}

/// Three straight sections in a row: 1 m, 2 m and 3 m.
std::shared_ptr<const Track> three_in_a_row() {
  std::vector<zone::Circuit::Part> parts;
  parts.push_back(testing::part("a", {0.0, 0.0, 0.0}, 1.0, 0.0, {1}));
  parts.push_back(testing::part("b", {1.0, 0.0, 0.0}, 2.0, 0.0, {2}));
  parts.push_back(testing::part("c", {3.0, 0.0, 0.0}, 3.0, 0.0, {}));
  return testing::track(testing::circuit(std::move(parts)), {0, 1, 2}, false);
}

TEST(Particles, move_over_joints_in_both_directions_and_stay_on_the_circuit) {
  ParticleFilter particles{exact(three_in_a_row(), 0.25)};
  double along_m = 0.25;
  // From the first section to the last one and back, over one and over several joints, and beyond both ends.
  struct Step {
    double by_m;
    double x_m;
  };
  for (const Step& step : {Step{0.5, 0.75},
                           {0.5, 1.25},
                           {3.0, 4.25},
                           {-0.5, 3.75},
                           {-1.5, 2.25},
                           {-2.0, 0.25},
                           {4.0, 4.25},
                           {9.0, 6.0},
                           {-0.5, 5.5},
                           {-9.0, 0.0},
                           {0.25, 0.25}}) {
    particles.predict({step.by_m, 0.0, 0.1});
    along_m += step.by_m;
    const Estimate estimate = particles.estimate();
    EXPECT_NEAR(estimate.pose.x_m, step.x_m, 1e-9);
    EXPECT_NEAR(estimate.pose.y_m, 0.0, 1e-9);
    EXPECT_NEAR(*estimate.along_m, along_m, 1e-9);
  }
}

TEST(Particles, covariance_holds_the_offset_from_the_line_and_its_heading) {
  Setting setting = exact(testing::straight(), 2.0);
  setting.sensors.line_sigma_m = 0.03;
  setting.sensors.line_heading_sigma_rad = 0.05;
  const Matrix3 p = ParticleFilter{setting}.estimate().covariance;
  EXPECT_LT((p - Matrix3(Vector3(9e-4, 9e-4, 25e-4).asDiagonal())).norm(), 1e-15);
}

TEST(Particles, follow_the_heading_of_their_section) {
  const auto oval = testing::oval();
  // half through the bends, and on the return, where headings are ±π.
  for (const double along_m : {3.0 + 0.4 * pi, 3.0 + 0.8 * pi + 1.0, 6.0 + 1.2 * pi}) {
    Setting setting = exact(oval, along_m);
    setting.start_sigma_m = 1e-3;
    setting.particles = 200;
    const Estimate estimate = ParticleFilter{setting}.estimate();
    const Pose2 expected = oval->pose_at(along_m);
    EXPECT_LT(distance(estimate.pose, expected), 1e-3);
    EXPECT_NEAR(wrap_angle(estimate.pose.heading_rad - expected.heading_rad), 0.0, 1e-3);
    EXPECT_LT(estimate.covariance(2, 2), 0.021 * 0.021);
  }
}

TEST(Particles, spread_as_much_as_start_and_odometry_are_uncertain) {
  Setting setting = exact(testing::straight(), 2.0);
  setting.particles = 4000;
  setting.start_sigma_m = 0.05;
  setting.sensors.distance_variance_per_m = 1e-3;
  setting.sensors.line_sigma_m = 0.0;
  ParticleFilter particles{setting};
  // Of 4000 draws the mean is known to 1.6 % of σ, the variance to 2.2 %.
  EXPECT_NEAR(*particles.estimate().along_m, 2.0, 4.0 * 0.05 / 63.0);
  EXPECT_NEAR(particles.estimate().covariance(0, 0), 25e-4, 0.09 * 25e-4);
  particles.predict({3.0, 0.0, 1.0, 5e-3});
  particles.predict({-1.0, 0.0, 1.0});
  EXPECT_NEAR(*particles.estimate().along_m, 4.0, 0.006);
  EXPECT_NEAR(particles.estimate().pose.x_m, 4.0, 0.006);
  EXPECT_NEAR(particles.estimate().covariance(0, 0), 25e-4 + 4e-3 + 5e-3, 0.09 * 115e-4);
}

TEST(Particles, without_a_known_start_are_evenly_all_over_the_circuit) {
  Setting setting = exact(testing::oval(), 0.0);
  setting.start_known = false;
  setting.particles = 2000;
  setting.sensors.line_sigma_m = 0.0;
  const Estimate estimate = ParticleFilter{setting}.estimate();
  // The integrals of x, y and their squares along two straights and two half circles.
  Vector2 mean = Vector2::Zero();
  Matrix2 squares = Matrix2::Zero();
  constexpr int count = 20000;
  for (int i = 0; i < count; ++i) {
    const Pose2 pose = setting.track->pose_at((i + 0.5) / count * setting.track->length_m());
    const Vector2 p(pose.x_m, pose.y_m);
    mean += p / count;
    squares += p * p.transpose() / count;
  }
  const Matrix2 expected = squares - mean * mean.transpose();
  EXPECT_NEAR(estimate.pose.x_m, mean(0), 2e-3);
  EXPECT_NEAR(estimate.pose.y_m, mean(1), 2e-3);
  EXPECT_NEAR(estimate.covariance(0, 0), expected(0, 0), 4e-3);
  EXPECT_NEAR(estimate.covariance(1, 1), expected(1, 1), 4e-3);
  EXPECT_FALSE(estimate.along_m);
}

/// The posterior of a Gaussian about 2 m on a line by a likelihood that is wrong in one case of a hundred.
template <typename Squared>
std::pair<double, double> posterior(double sigma_m, const Squared& squared) {
  double total = 0.0;
  double mean = 0.0;
  double second = 0.0;
  for (int i = -6000; i <= 6000; ++i) {
    const double off_m = 1e-3 * i * sigma_m;
    const double weight =
        std::exp(-0.5 * std::pow(1e-3 * i, 2)) * (0.01 + 0.99 * std::exp(-0.5 * squared(2.0 + off_m)));
    total += weight;
    mean += weight * off_m;
    second += weight * off_m * off_m;
  }
  mean /= total;
  return {2.0 + mean, second / total - mean * mean};
}

TEST(Particles, weigh_readings_and_ranges_by_their_likelihood) {
  Setting setting = exact(testing::straight(), 2.0);
  setting.particles = 20000;
  setting.start_sigma_m = 0.1;
  SensorModel& sensors = setting.sensors;
  sensors.fiducial_along_sigma_m = 0.08;
  sensors.fiducial_across_sigma_m = 0.03;
  sensors.line_sigma_m = 0.04;
  sensors.range_sigma_m = 0.2;
  const double line = 0.04 * 0.04;

  // 7 cm to the left of the expected position, where 5 cm are one standard deviation.
  for (const double before_m : {0.5, 0.2}) {
    ParticleFilter particles{setting};
    const Rectified result = particles.rectify(Reading{1, {2.1 + before_m, 0.3}, {before_m, 0.23}});
    EXPECT_TRUE(result.accepted);
    EXPECT_FALSE(result.nis);
    EXPECT_EQ(result.dimensions, 0);
    const auto [mean, variance] = posterior(
        0.1, [](double x_m) { return std::pow((x_m - 2.1) / 0.08, 2) + 0.07 * 0.07 / (0.03 * 0.03 + 0.04 * 0.04); });
    EXPECT_NEAR(particles.estimate().pose.x_m, mean, 0.003);
    EXPECT_NEAR(particles.estimate().covariance(0, 0) - line, variance, 0.05 * variance);
  }
  {
    ParticleFilter particles{setting};
    const Rectified result = particles.rectify(Range{1, {-2.0, 3.0}, 5.1});
    EXPECT_TRUE(result.accepted);
    EXPECT_EQ(result.dimensions, 0);
    const double range_m2 = range_variance(sensors, 5.1);
    const auto [mean, variance] =
        posterior(0.1, [&](double x_m) { return std::pow(norm(x_m + 2.0, 3.0) - 5.1, 2) / range_m2; });
    EXPECT_NEAR(particles.estimate().pose.x_m, mean, 0.003);
    EXPECT_NEAR(particles.estimate().covariance(0, 0) - line, variance, 0.05 * variance);
  }
  // One centimetre of certainty and one in ten particles near: drawn again, and then as many again on the next step.
  setting.sensors.fiducial_along_sigma_m = 0.01;
  ParticleFilter particles{setting};
  particles.rectify(Reading{1, {2.1, 0.0}, {}});
  const auto [mean, variance] = posterior(0.1, [](double x_m) { return std::pow((x_m - 2.1) / 0.01, 2); });
  EXPECT_NEAR(particles.estimate().pose.x_m, mean, 0.004);
  EXPECT_NEAR(particles.estimate().covariance(0, 0) - line, variance, 0.08 * variance);
  particles.predict({1.0, 0.0, 0.1});
  EXPECT_NEAR(particles.estimate().pose.x_m, mean + 1.0, 0.004);
  EXPECT_NEAR(*particles.estimate().along_m, mean + 1.0, 0.004);
}

TEST(Particles, stay_with_the_vehicle_because_they_are_drawn_again) {
  Setting setting = exact(testing::straight(), 0.0);
  setting.particles = 500;
  setting.sensors.distance_variance_per_m = 0.01;
  setting.sensors.fiducial_along_sigma_m = 0.02;
  ParticleFilter particles{setting};
  // 7 cm of uncertainty in each step: the first particles would end 30 cm apart.
  for (int step = 1; step <= 19; ++step) {
    particles.predict({0.5, 0.0, 1.0});
    particles.rectify(Reading{1, {0.5 * step, 0.0}, {}});
    EXPECT_NEAR(particles.estimate().pose.x_m, 0.5 * step, 0.01) << step;
  }
}

TEST(Particles, are_the_same_by_the_same_seed_alone) {
  Setting setting = exact(testing::straight(), 2.0);
  setting.start_sigma_m = 0.1;
  const auto start_m = [&](std::uint64_t seed) {
    setting.seed = seed;
    return *ParticleFilter{setting}.estimate().along_m;
  };
  EXPECT_EQ(start_m(3), start_m(3));
  EXPECT_NE(start_m(3), start_m(4));
}

}  // namespace
}  // namespace cosiva::estimation
