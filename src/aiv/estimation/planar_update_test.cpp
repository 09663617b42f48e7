#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/aiv/estimation/test_tracks.h"
#include "cosiva/base/math.h"

// Motion, covariance and each correction of the plane's estimators against finite differences and closed forms.
namespace cosiva::estimation {
namespace {

Vector3 as_vector(const Pose2& pose) { return {pose.x_m, pose.y_m, pose.heading_rad}; }
Pose2 as_pose(const Vector3& v) { return {v(0), v(1), v(2)}; }

/// The slope of a function of a pose, by central differences.
template <int Rows>
Eigen::Matrix<double, Rows, 3> slope_at(const Pose2& pose,
                                        const std::function<Eigen::Matrix<double, Rows, 1>(const Pose2&)>& f) {
  constexpr double h = 1e-5;
  Eigen::Matrix<double, Rows, 3> slope;
  for (int i = 0; i < 3; ++i) {
    Vector3 up = as_vector(pose);
    Vector3 down = up;
    up(i) += h;
    down(i) -= h;
    slope.col(i) = (f(as_pose(up)) - f(as_pose(down))) / (2.0 * h);
  }
  return slope;
}

/// Each element is equal to a fraction of the standard deviations of its row and column.
void expect_covariance(const Matrix3& actual, const Matrix3& expected, double fraction, const std::string& what) {
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j)
      EXPECT_NEAR(actual(i, j), expected(i, j), fraction * std::sqrt(expected(i, i) * expected(j, j)))
          << what << " " << i << j;
  }
}

bool is_symmetric(const Matrix3& m) { return m(0, 1) == m(1, 0) && m(0, 2) == m(2, 0) && m(1, 2) == m(2, 1); }

SensorModel distinct_sensors() {
  SensorModel sensors;
  sensors.distance_variance_per_m = 3e-4;
  sensors.turn_variance_per_m = 7e-5;
  sensors.turn_variance_per_rad = 2e-4;
  sensors.fiducial_along_sigma_m = 0.013;
  sensors.fiducial_across_sigma_m = 0.007;
  sensors.line_sigma_m = 0.003;
  sensors.line_heading_sigma_rad = 0.017;
  sensors.range_sigma_m = 0.11;
  sensors.range_scale_sigma = 0.03;
  sensors.range_common_sigma_m = 0.05;
  sensors.range_station_sigma_m = 0.02;
  return sensors;
}

TEST(Planar, step_is_the_integral_of_the_motion) {
  for (const double turn : {0.0, 5e-5, -5e-5, 9e-5, 2e-4, 0.01, 0.3, -0.3, 1.2, -2.5}) {
    for (const auto& [distance_m, left_m] : {std::pair{1.5, 0.0}, {-0.7, 0.0}, {0.9, 0.4}, {0.0, -0.6}}) {
      // sin(x)/x and 2·sin²(x/2)/x, each without cancellation.
      const double along = turn == 0.0 ? 1.0 : std::sin(turn) / turn;
      const double aside = turn == 0.0 ? 0.0 : 2.0 * std::pow(std::sin(0.5 * turn), 2) / turn;
      const Pose2 step = step_of({distance_m, turn, 0.1, 0.0, 0.0, left_m});
      EXPECT_NEAR(step.x_m, distance_m * along - left_m * aside, 1e-11) << turn;
      EXPECT_NEAR(step.y_m, distance_m * aside + left_m * along, 1e-11) << turn;
      EXPECT_DOUBLE_EQ(step.heading_rad, turn);
    }
  }
}

TEST(Planar, course_of_a_step_has_a_length_and_a_direction) {
  EXPECT_EQ(course_of({-0.7, 0.1, 0.1}).distance_m, -0.7);
  EXPECT_EQ(course_of({-0.7, 0.1, 0.1}).aside_rad, 0.0);
  const StepCourse aside = course_of({0.3, 0.0, 0.1, 0.0, 0.0, -0.4});
  EXPECT_NEAR(aside.distance_m, 0.5, 1e-15);
  EXPECT_NEAR(aside.aside_rad, std::atan2(-0.4, 0.3), 1e-15);
}

TEST(Planar, variances_of_a_step_are_those_per_metre_per_radian_and_of_the_step) {
  const SensorModel sensors = distinct_sensors();
  const Vector2 v = step_variances(sensors, {-2.0, -0.5, 0.1, 5e-4, 6e-4});
  EXPECT_NEAR(v(0), 3e-4 * 2.0 + 5e-4, 1e-15);
  EXPECT_NEAR(v(1), 7e-5 * 2.0 + 2e-4 * 0.5 + 6e-4, 1e-15);
}

TEST(Planar, covariances_of_start_reading_and_range_are_the_squares_of_what_is_set) {
  Setting setting;
  setting.start_sigma_m = 0.3;
  setting.start_heading_sigma_rad = 0.2;
  EXPECT_LT((start_covariance(setting) - Matrix3(Vector3(0.09, 0.09, 0.04).asDiagonal())).norm(), 1e-15);
  const SensorModel sensors = distinct_sensors();
  EXPECT_LT((fiducial_covariance(sensors) - Matrix2(Vector2(0.013 * 0.013, 0.007 * 0.007).asDiagonal())).norm(), 1e-15);
  EXPECT_NEAR(range_variance(sensors, 4.0), 0.11 * 0.11 + 0.05 * 0.05 + 0.02 * 0.02 + 0.12 * 0.12, 1e-15);
}

TEST(Planar, spread_is_the_first_order_of_the_motion) {
  const SensorModel sensors = distinct_sensors();
  Matrix3 before;
  before << 4e-4, 1e-4, 2e-5, 1e-4, 9e-4, -3e-5, 2e-5, -3e-5, 1e-4;
  for (const Odometry& odometry :
       {Odometry{1.3, 0.02, 0.1}, {-0.8, 0.03, 0.1, 1e-4, 2e-4}, {0.6, -0.02, 0.1, 0.0, 0.0, 0.5}}) {
    const Pose2 pose{0.4, -1.1, 0.7};
    const Matrix3 f = slope_at<3>(pose, [&](const Pose2& at) { return as_vector(moved(at, odometry)); });
    // The noise acts along the course and on the turn.
    constexpr double h = 1e-5;
    const auto with = [&](double longer, double turned) {
      Odometry other = odometry;
      const double factor = 1.0 + longer / course_of(odometry).distance_m;
      other.distance_m *= factor;
      other.left_m *= factor;
      other.turn_rad += turned;
      return as_vector(moved(pose, other));
    };
    Eigen::Matrix<double, 3, 2> g;
    g.col(0) = (with(h, 0.0) - with(-h, 0.0)) / (2.0 * h);
    g.col(1) = (with(0.0, h) - with(0.0, -h)) / (2.0 * h);
    const Matrix2 noise = step_variances(sensors, odometry).asDiagonal();
    const Matrix3 expected = f * before * f.transpose() + g * noise * g.transpose();
    const Matrix3 after = spread(sensors, pose, odometry, before);
    expect_covariance(after, expected, 1e-3, "spread");
    EXPECT_TRUE(is_symmetric(after));
  }
}

TEST(Planar, covariance_on_a_track_follows_its_direction_and_curvature) {
  const auto track = testing::oval();
  const SensorModel sensors = distinct_sensors();
  for (const double along_m : {1.0, 3.4, 4.6, 6.5, 9.2, 12.0}) {
    const Estimate estimate = on_track(*track, sensors, along_m, 2e-3);
    constexpr double h = 1e-5;
    const Pose2 here = track->pose_at(along_m);
    Vector3 slope = as_vector(track->pose_at(along_m + h)) - as_vector(track->pose_at(along_m - h));
    slope(2) = wrap_angle(slope(2));
    slope /= 2.0 * h;
    const Vector3 normal(-std::sin(here.heading_rad), std::cos(here.heading_rad), 0.0);
    Matrix3 expected = 2e-3 * slope * slope.transpose() + 0.003 * 0.003 * normal * normal.transpose();
    expected(2, 2) += 0.017 * 0.017;
    EXPECT_LT((estimate.covariance - expected).cwiseAbs().maxCoeff(), 1e-9) << along_m;
    EXPECT_EQ(estimate.pose, here);
    EXPECT_EQ(estimate.along_m, along_m);
  }
}

/// What a Kalman filter makes of a linear measurement, in the information form.
struct Corrected {
  Vector3 by;
  Matrix3 covariance;
  double nis;
};
template <int Rows>
Corrected corrected(const Matrix3& p, const Eigen::Matrix<double, Rows, 3>& h,
                    const Eigen::Matrix<double, Rows, Rows>& r, const Eigen::Matrix<double, Rows, 1>& innovation) {
  const Matrix3 after = Matrix3(p.inverse() + h.transpose() * r.inverse() * h).inverse();
  const Eigen::Matrix<double, Rows, Rows> s = h * p * h.transpose() + r;
  return {after * h.transpose() * r.inverse() * innovation, after, innovation.dot(s.inverse() * innovation)};
}

Point2 in_body(const Pose2& pose, Point2 fiducial_M) { return inverse(pose) * fiducial_M; }

/// With odometry so exact that terms of second order do not matter.
SensorModel quiet_sensors() {
  SensorModel sensors = distinct_sensors();
  sensors.distance_variance_per_m = sensors.turn_variance_per_m = sensors.turn_variance_per_rad = 1e-6;
  return sensors;
}

/// A filter after a drive that correlates all components, certain enough for the first order to suffice.
std::unique_ptr<Algorithm> driven(const char* name, const SensorModel& sensors) {
  Setting setting;
  setting.sensors = sensors;
  setting.start = {1.0, -2.0, 0.6};
  setting.start_sigma_m = 0.004;
  setting.start_heading_sigma_rad = 0.003;
  auto filter = *Registry{}.make(name, setting);
  for (int i = 0; i < 4; ++i) filter->predict({0.3, 0.05, 0.1});
  return filter;
}

TEST(Planar, filters_take_the_same_first_step_towards_a_reading) {
  const SensorModel sensors = quiet_sensors();
  for (const char* name : {"ekf", "ukf", "iekf"}) {
    for (const Point2 at_B : {Point2{0.4, 0.1}, Point2{-0.2, -0.5}}) {
      const auto filter = driven(name, sensors);
      const Estimate before = filter->estimate();
      const Point2 fiducial_M = before.pose * at_B;
      const Vector2 innovation(0.004, -0.003);
      const auto h = slope_at<2>(before.pose, [&](const Pose2& pose) {
        const Point2 p = in_body(pose, fiducial_M);
        return Vector2(p.x_m, p.y_m);
      });
      const Corrected expected = corrected<2>(before.covariance, h, fiducial_covariance(sensors), innovation);
      const Rectified result =
          filter->rectify(Reading{1, fiducial_M, {at_B.x_m + innovation(0), at_B.y_m + innovation(1)}});
      const Estimate after = filter->estimate();
      EXPECT_TRUE(result.accepted);
      EXPECT_EQ(result.dimensions, 2);
      EXPECT_NEAR(*result.nis, expected.nis, 0.01 * expected.nis) << name;
      EXPECT_LT((as_vector(after.pose) - as_vector(before.pose) - expected.by).norm(), 0.01 * expected.by.norm())
          << name;
      expect_covariance(after.covariance, expected.covariance, 0.01, name);
    }
  }
}

TEST(Planar, filters_take_the_same_first_step_towards_a_range) {
  SensorModel sensors = quiet_sensors();
  sensors.range_sigma_m = 0.004;
  sensors.range_common_sigma_m = sensors.range_station_sigma_m = 0.001;
  sensors.range_scale_sigma = 0.0003;
  for (const char* name : {"ekf", "ukf", "iekf"}) {
    // The nearest station is half a metre away.
    for (const Point2 at_B : {Point2{0.3, 0.4}, Point2{-5.0, 3.0}}) {
      const auto filter = driven(name, sensors);
      const Estimate before = filter->estimate();
      const Point2 station_M = before.pose * at_B;
      using One = Eigen::Matrix<double, 1, 1>;
      const auto h =
          slope_at<1>(before.pose, [&](const Pose2& pose) { return One(distance(position(pose), station_M)); });
      const double range_m = norm(at_B.x_m, at_B.y_m);
      const One innovation(0.005);
      const Corrected expected = corrected<1>(before.covariance, h, One(range_variance(sensors, range_m)), innovation);
      const Rectified result = filter->rectify(Range{1, station_M, range_m + innovation(0)});
      const Estimate after = filter->estimate();
      EXPECT_TRUE(result.accepted);
      EXPECT_EQ(result.dimensions, 1);
      EXPECT_NEAR(*result.nis, expected.nis, 0.02 * expected.nis) << name;
      EXPECT_LT((as_vector(after.pose) - as_vector(before.pose) - expected.by).norm(), 0.02 * expected.by.norm())
          << name;
      expect_covariance(after.covariance, expected.covariance, 0.01, name);
    }
  }
}

TEST(Planar, filters_refuse_what_only_one_in_a_thousand_would_exceed) {
  const SensorModel sensors = quiet_sensors();
  for (const char* name : {"ekf", "ukf", "iekf"}) {
    for (const bool inside : {true, false}) {
      // The square root of the fraction of the gate.
      const double sigmas = inside ? 0.99 : 1.01;
      const auto by_range = driven(name, sensors);
      const Pose2 pose = by_range->estimate().pose;
      const Point2 station_M = pose * Point2{3.0, 4.0};
      // With an innovation of one metre; NIS is quadratic in the innovation.
      const double of_metre = *driven(name, sensors)->rectify(Range{1, station_M, 6.0}).nis;
      const Rectified range = by_range->rectify(Range{1, station_M, 5.0 + sigmas * std::sqrt(gate_1 / of_metre)});
      EXPECT_EQ(range.accepted, inside) << name;
      EXPECT_EQ(range.dimensions, 1);
      EXPECT_NEAR(*range.nis, sigmas * sigmas * gate_1, 0.01) << name;
      EXPECT_EQ(by_range->estimate().pose == pose, !inside);

      const auto by_reading = driven(name, sensors);
      const Point2 fiducial_M = pose * Point2{0.2, 0.1};
      // The invariant filter transforms the measured position, so that a small innovation gives the unit.
      const double of_centimetre = *driven(name, sensors)->rectify(Reading{1, fiducial_M, {0.21, 0.1}}).nis;
      const double along_m = 0.01 * sigmas * std::sqrt(gate_2 / of_centimetre);
      const Rectified reading = by_reading->rectify(Reading{1, fiducial_M, {0.2 + along_m, 0.1}});
      EXPECT_EQ(reading.accepted, inside) << name;
      EXPECT_EQ(reading.dimensions, 2);
      EXPECT_NEAR(*reading.nis, sigmas * sigmas * gate_2, 0.05) << name;
      EXPECT_EQ(by_reading->estimate().pose == pose, !inside);
    }
  }
}

TEST(Planar, filters_learn_nothing_from_a_range_to_a_station_under_the_vehicle) {
  for (const char* name : {"ekf", "iekf"}) {
    const auto filter = driven(name, distinct_sensors());
    const Estimate before = filter->estimate();
    const Rectified result = filter->rectify(Range{1, position(before.pose), 0.0});
    EXPECT_FALSE(result.accepted);
    EXPECT_FALSE(result.nis);
    EXPECT_EQ(filter->estimate().covariance, before.covariance);
  }
}

TEST(Planar, covariances_stay_exactly_symmetric) {
  for (const char* name : {"ekf", "ukf"}) {
    const auto filter = driven(name, distinct_sensors());
    const Point2 station_M{-2.0, 3.0};
    for (int i = 0; i < 20; ++i) {
      const Pose2 pose = filter->estimate().pose;
      const auto symmetric = [&] { return is_symmetric(filter->estimate().covariance); };
      filter->predict({0.13, 0.07, 0.1});
      EXPECT_TRUE(symmetric()) << name;
      filter->rectify(Range{1, station_M, distance(position(pose), station_M)});
      EXPECT_TRUE(symmetric()) << name;
      filter->rectify(Reading{1, pose * Point2{0.3, 0.1}, {0.17, 0.1}});
      EXPECT_TRUE(symmetric()) << name;
    }
  }
}

Setting uncertain(double sigma_m, double heading_sigma_rad) {
  Setting setting;
  setting.start_sigma_m = sigma_m;
  setting.start_heading_sigma_rad = heading_sigma_rad;
  setting.sensors.distance_variance_per_m = 1e-3;
  setting.sensors.turn_variance_per_m = setting.sensors.turn_variance_per_rad = 0.0;
  return setting;
}

TEST(Ukf, moves_by_the_mean_of_six_points_at_root_three_sigmas) {
  Ukf ukf{uncertain(0.1, 0.4)};
  constexpr double d = 2.0;
  ukf.predict({d, 0.0, 1.0});
  // Four points have the mean heading, two are turned by ±√3·σ.
  const double a = std::sqrt(3.0) * 0.4;
  const double mean = (4.0 + 2.0 * std::cos(a)) / 6.0;
  const Matrix3 p = ukf.estimate().covariance;
  EXPECT_NEAR(ukf.estimate().pose.x_m, d * mean, 1e-9);
  EXPECT_NEAR(ukf.estimate().pose.y_m, 0.0, 1e-9);
  EXPECT_NEAR(p(0, 0),
              0.01 + d * 1e-3 + d * d * (4.0 * std::pow(1.0 - mean, 2) + 2.0 * std::pow(std::cos(a) - mean, 2)) / 6.0,
              1e-9);
  EXPECT_NEAR(p(1, 1), 0.01 + d * d * std::pow(std::sin(a), 2) / 3.0, 1e-9);
  EXPECT_NEAR(p(1, 2), d * std::sin(a) * a / 3.0, 1e-9);
  EXPECT_NEAR(p(2, 2), 0.16, 1e-9);
  EXPECT_NEAR(p(0, 1), 0.0, 1e-9);
}

TEST(Ukf, expects_the_mean_range_and_the_mean_reading_of_its_points) {
  const Setting setting = uncertain(0.3, 0.5);
  const double a = std::sqrt(3.0) * 0.3;
  // A station 2 m ahead: three points at 2 m (the turned ones, of no effect, count twice), one nearer, one further, and
  // two at its sides.
  Ukf by_range{setting};
  const double aslant = norm(2.0, a);
  const double range_m = (2.0 * 2.0 + (2.0 - a) + (2.0 + a) + 2.0 * aslant) / 6.0;
  const double variance = (2.0 * std::pow(2.0 - range_m, 2) + std::pow(2.0 - a - range_m, 2) +
                           std::pow(2.0 + a - range_m, 2) + 2.0 * std::pow(aslant - range_m, 2)) /
                              6.0 +
                          range_variance(setting.sensors, range_m);
  EXPECT_NEAR(*Ukf{setting}.rectify(Range{1, {2.0, 0.0}, range_m + 0.2}).nis, 0.04 / variance, 1e-9);
  by_range.rectify(Range{1, {2.0, 0.0}, range_m});
  EXPECT_NEAR(by_range.estimate().pose.x_m, 0.0, 1e-12);
  // Cov(x, range) = −σ², as both points along x give.
  EXPECT_NEAR(by_range.estimate().covariance(0, 0), 0.09 - 0.09 * 0.09 / variance, 1e-9);
  EXPECT_NEAR(by_range.estimate().covariance(1, 1), 0.09, 1e-9);

  Ukf by_reading{setting};
  const double b = std::sqrt(3.0) * 0.5;
  const double along_m = 2.0 * (4.0 + 2.0 * std::cos(b)) / 6.0;
  const double along_variance =
      0.09 + (4.0 * std::pow(2.0 - along_m, 2) + 2.0 * std::pow(2.0 * std::cos(b) - along_m, 2)) / 6.0 + 1e-4;
  EXPECT_NEAR(*Ukf{setting}.rectify(Reading{1, {2.0, 0.0}, {along_m + 0.1, 0.0}}).nis, 0.01 / along_variance, 1e-9);
  by_reading.rectify(Reading{1, {2.0, 0.0}, {along_m, 0.0}});
  EXPECT_NEAR(by_reading.estimate().pose.x_m, 0.0, 1e-12);
  EXPECT_NEAR(by_reading.estimate().covariance(0, 0), 0.09 - 0.09 * 0.09 / along_variance, 1e-9);
}

TEST(InvariantEkf, corrects_along_arcs) {
  // The heading alone is uncertain, three metres from the map's origin: the error is a turn about the vehicle, along an
  // arc about the origin.
  Setting setting;
  setting.start = {3.0, 0.0, 0.0};
  setting.start_sigma_m = 0.0;
  setting.start_heading_sigma_rad = 0.5;
  setting.sensors.fiducial_along_sigma_m = 1.0;
  setting.sensors.fiducial_across_sigma_m = 1e-8;
  for (const double turn_rad : {0.3, -0.6, 5e-5}) {
    InvariantEkf iekf{setting};
    iekf.rectify(Reading{1, {5.0, 0.0}, {2.0 * std::cos(turn_rad), -2.0 * std::sin(turn_rad)}});
    // The innovation across, two metres times the sine, is taken as an arc of two metres.
    EXPECT_NEAR(iekf.estimate().pose.heading_rad, std::sin(turn_rad), 1e-9);
    EXPECT_NEAR(iekf.estimate().pose.x_m, 3.0, 1e-12);
    EXPECT_NEAR(iekf.estimate().pose.y_m, 0.0, 1e-12);
  }
}

TEST(Planar, filters_use_a_range_to_a_station_over_a_micrometre_away) {
  for (const char* name : {"ekf", "iekf"}) {
    for (const double away_m : {5e-7, 2e-6}) {
      const auto filter = *Registry{}.make(name, Setting{});
      EXPECT_EQ(filter->rectify(Range{1, {away_m, 0.0}, 0.0}).nis.has_value(), away_m > 1e-6) << name << away_m;
    }
  }
}

TEST(PlanarDeathTest, has_no_negative_variances) {
  // A step of odometry that states a negative variance of its distance, along x.
  const Odometry impossible{0.0, 0.0, 1.0, -1.0};
  Setting setting;
  setting.start_sigma_m = 0.0;
  InvariantEkf iekf{setting};
  EXPECT_DEATH(iekf.predict(impossible), "has_variances");
  Ekf ekf{setting};
  ekf.predict(impossible);
  EXPECT_DEATH(ekf.rectify(Range{1, {0.0, 5.0}, 5.0}), "has_variances");
}

}  // namespace
}  // namespace cosiva::estimation
