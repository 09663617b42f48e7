#include "cosiva/aiv/estimation/calibrating_model.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/base/math.h"

// The calibrating filter's model against finite differences and closed forms.
namespace cosiva::estimation {
namespace {

using Calibrated = CalibratedState;

SensorModel sensors_of_the_model() {
  SensorModel sensors;
  sensors.distance_scale_sigma = 0.021;
  sensors.turn_scale_sigma = 0.023;
  sensors.range_scale_sigma = 0.027;
  sensors.range_common_sigma_m = 0.31;
  sensors.range_station_sigma_m = 0.13;
  sensors.range_station_length_m = 4.0;
  sensors.turn_drift_sigma_radps = 0.005;
  sensors.fiducial_along_sigma_m = 0.013;
  sensors.fiducial_across_sigma_m = 0.007;
  sensors.range_sigma_m = 0.11;
  return sensors;
}

Calibrated::Vector some_state() {
  Calibrated::Vector state = Calibrated::Vector::Zero();
  state(Calibrated::x) = 1.2;
  state(Calibrated::y) = -0.7;
  state(Calibrated::heading) = 0.6;
  state(Calibrated::distance_scale) = 0.03;
  state(Calibrated::turn_scale) = -0.04;
  state(Calibrated::range_scale) = 0.05;
  state(Calibrated::range_common) = 0.2;
  state(Calibrated::turn_drift) = 0.01;
  return state;
}

/// A covariance with all correlations.
Calibrated::Matrix some_covariance() {
  Calibrated::Matrix root = Calibrated::Matrix::Zero();
  for (int i = 0; i < Calibrated::size_max; ++i) {
    for (int j = 0; j <= i; ++j) root(i, j) = 0.02 * (i == j ? 4.0 : std::sin(3.0 * i + 5.0 * j));
  }
  return root * root.transpose();
}

double difference(const Calibrated::Matrix& a, const Calibrated::Matrix& b) { return (a - b).cwiseAbs().maxCoeff(); }

TEST(CalibratingModel, starts_with_the_uncertainties_that_are_set) {
  Setting setting;
  setting.sensors = sensors_of_the_model();
  setting.start = {1.5, -2.5, 9.0};
  setting.start_sigma_m = 0.4;
  const Calibrated state = model::start_state(setting, 0.3, 0.2);
  Calibrated::Vector mean = Calibrated::Vector::Zero();
  mean.head<3>() = Vector3(1.5, -2.5, 0.3);
  EXPECT_EQ(state.mean, mean);
  Calibrated::Vector sigmas = Calibrated::Vector::Constant(0.13);
  sigmas.head<7>() << 0.4, 0.4, 0.2, 0.021, 0.023, 0.027, 0.31;
  sigmas(15) = 0.005;
  EXPECT_LT(difference(state.covariance, sigmas.cwiseAbs2().asDiagonal()), 1e-15);
}

TEST(CalibratingModel, motion_is_odometry_without_its_scale_and_drift) {
  const SensorModel sensors = sensors_of_the_model();
  Calibrated::Vector about = some_state();
  about(8) = 0.5;
  for (const Odometry& odometry :
       {Odometry{1.1, 0.3, 0.5}, {-0.9, 0.2, 0.5, 1e-4, 3e-4}, {0.5, 0.0, 0.5, 0.0, 0.0, 0.4}}) {
    const double drifts_rad = odometry.turn_rad != 0.0 ? 0.5 * 0.01 : 0.0;
    const Odometry truly{odometry.distance_m * 0.97,    odometry.turn_rad * 1.04 - drifts_rad, 0.5,
                         odometry.distance_variance_m2, odometry.turn_variance_rad2,           odometry.left_m * 0.97};
    const Pose2 to = moved({1.2, -0.7, 0.6}, truly);
    const model::Motion motion = model::motion_of(sensors, about, odometry);
    EXPECT_NEAR(motion.offset(0), to.x_m, 1e-12);
    EXPECT_NEAR(motion.offset(1), to.y_m, 1e-12);
    EXPECT_NEAR(motion.offset(2), to.heading_rad, 1e-12);
    // A station's bias is forgotten over four metres, and as uncertain as before on the whole.
    const double keeps = std::exp(-norm(truly.distance_m, truly.left_m) / 4.0);
    EXPECT_NEAR(motion.offset(8), 0.5 * keeps, 1e-12);
    Calibrated::Matrix noise = Calibrated::Matrix::Zero();
    noise.topLeftCorner<3, 3>() = spread(sensors, {1.2, -0.7, 0.6}, truly, Matrix3::Zero());
    for (int i = 7; i < 15; ++i) noise(i, i) = 0.13 * 0.13 * (1.0 - keeps * keeps);
    EXPECT_LT(difference(motion.noise, noise), 1e-12);
    EXPECT_EQ(motion.offset(Calibrated::distance_scale), 0.03);
    EXPECT_EQ(motion.offset(Calibrated::turn_drift), 0.01);
  }
}

TEST(CalibratingModel, slope_of_the_motion_is_that_of_finite_differences) {
  const SensorModel sensors = sensors_of_the_model();
  const Calibrated::Vector about = some_state();
  for (const Odometry& odometry :
       {Odometry{1.1, 0.003, 0.5}, {-0.9, 0.002, 0.5}, {0.5, -0.003, 0.5, 0.0, 0.0, 0.4}, {0.7, 0.0, 0.5}}) {
    constexpr double h = 1e-6;
    Calibrated::Matrix expected;
    for (int i = 0; i < Calibrated::size_max; ++i) {
      Calibrated::Vector up = about;
      Calibrated::Vector down = about;
      up(i) += h;
      down(i) -= h;
      expected.col(i) =
          (model::motion_of(sensors, up, odometry).offset - model::motion_of(sensors, down, odometry).offset) /
          (2.0 * h);
    }
    EXPECT_LT(difference(model::motion_of(sensors, about, odometry).slope, expected), 3e-4) << odometry.distance_m;
  }
}

TEST(CalibratingModel, slope_of_a_turn_s_scale_and_drift_on_a_long_step_is_that_of_finite_differences) {
  // The turn acts over half the step; a step of 100 m makes visible what one of a metre hides.
  const SensorModel sensors = sensors_of_the_model();
  const Calibrated::Vector about = some_state();
  const Odometry odometry{100.0, 0.01, 0.7};
  for (const int i : {int{Calibrated::distance_scale}, int{Calibrated::turn_scale}, int{Calibrated::turn_drift}}) {
    constexpr double h = 1e-5;
    Calibrated::Vector up = about;
    Calibrated::Vector down = about;
    up(i) += h;
    down(i) -= h;
    const Calibrated::Vector expected =
        (model::motion_of(sensors, up, odometry).offset - model::motion_of(sensors, down, odometry).offset) / (2.0 * h);
    const Calibrated::Vector slope = model::motion_of(sensors, about, odometry).slope.col(i);
    EXPECT_LT((slope - expected).norm(), 1e-3 * expected.norm()) << i;
  }
}

TEST(CalibratingModel, covariance_moves_by_the_slope) {
  const model::Motion motion = model::motion_of(sensors_of_the_model(), some_state(), {1.1, 0.3, 0.5});
  Calibrated state{some_state(), some_covariance()};
  model::move(state, motion);
  const Calibrated::Matrix expected = motion.slope * some_covariance() * motion.slope.transpose() + motion.noise;
  EXPECT_EQ(state.mean, motion.offset);
  EXPECT_LT(difference(state.covariance, expected), 1e-14);
  for (int i = 0; i < Calibrated::size_max; ++i) {
    for (int j = 0; j < i; ++j) EXPECT_EQ(state.covariance(i, j), state.covariance(j, i));
  }
}

TEST(CalibratingModel, correction_is_carried_as_a_turn_about_the_origin) {
  Calibrated state{some_state(), some_covariance()};
  Calibrated::Vector before = some_state();
  before(Calibrated::x) -= 0.3;
  before(Calibrated::y) += 0.2;
  model::carry(state, before);
  // The error (x, y) + θ·(y, −x) stays while the position moves by (0.3, −0.2).
  Calibrated::Matrix t = Calibrated::Matrix::Identity();
  t(Calibrated::x, Calibrated::heading) = 0.2;
  t(Calibrated::y, Calibrated::heading) = 0.3;
  EXPECT_LT(difference(state.covariance, t * some_covariance() * t.transpose()), 1e-14);
}

/// The measurement's slope, by differences of the expected values.
template <typename Input>
void expect_slopes(const Input& input, Stations& stations, const Calibrated::Vector& about) {
  const SensorModel sensors = sensors_of_the_model();
  const model::PredictedReading here = model::predicted_reading(sensors, stations, about, input);
  constexpr double h = 1e-6;
  for (int i = 0; i < Calibrated::size_max; ++i) {
    Calibrated::Vector up = about;
    Calibrated::Vector down = about;
    up(i) += h;
    down(i) -= h;
    const auto high = model::predicted_reading(sensors, stations, up, input);
    const auto low = model::predicted_reading(sensors, stations, down, input);
    for (std::size_t k = 0; k < static_cast<std::size_t>(here.count); ++k)
      EXPECT_NEAR(here.measured[k].slope(i), (low.measured[k].residual - high.measured[k].residual) / (2.0 * h), 1e-7)
          << k << " by " << i;
  }
}

TEST(CalibratingModel, reading_is_expected_in_the_body_s_frame) {
  Stations stations;
  const Calibrated::Vector about = some_state();
  const Reading reading{1, {1.9, -0.1}, {0.5, 0.3}};
  const auto predicted = model::predicted_reading(sensors_of_the_model(), stations, about, reading);
  const Point2 expected_B = inverse(Pose2{1.2, -0.7, 0.6}) * reading.fiducial_M;
  ASSERT_EQ(predicted.count, 2);
  EXPECT_NEAR(predicted.measured[0].residual, 0.5 - expected_B.x_m, 1e-12);
  EXPECT_NEAR(predicted.measured[1].residual, 0.3 - expected_B.y_m, 1e-12);
  EXPECT_DOUBLE_EQ(predicted.measured[0].variance, 0.013 * 0.013);
  EXPECT_DOUBLE_EQ(predicted.measured[1].variance, 0.007 * 0.007);
  expect_slopes(reading, stations, about);
}

TEST(CalibratingModel, range_is_expected_with_its_scale_and_biases) {
  Stations stations;
  Calibrated::Vector about = some_state();
  about(7) = 0.04;
  about(8) = 0.07;
  EXPECT_EQ(stations.index(42), 7);
  const Range range{17, {4.2, -4.7}, 5.5};  // 3 m and 4 m away
  const auto predicted = model::predicted_reading(sensors_of_the_model(), stations, about, range);
  ASSERT_EQ(predicted.count, 1);
  EXPECT_NEAR(predicted.measured[0].residual, 5.5 - (1.05 * 5.0 + 0.2 + 0.07), 1e-12);
  EXPECT_DOUBLE_EQ(predicted.measured[0].variance, 0.11 * 0.11);
  expect_slopes(range, stations, about);
  expect_slopes(Range{42, {1.5, -0.3}, 0.4}, stations, about);  // half a metre away
  EXPECT_EQ(model::predicted_reading(sensors_of_the_model(), stations, about, Range{17, {1.2, -0.7}, 0.0}).count, 0);
  EXPECT_EQ(stations.count(), 2);
}

TEST(CalibratingModel, ninth_station_has_the_common_bias_alone) {
  Stations stations;
  for (std::uint32_t station = 0; station < 8; ++station)
    EXPECT_EQ(stations.index(10 * station), 7 + static_cast<int>(station));
  EXPECT_EQ(stations.index(99), -1);
  EXPECT_EQ(stations.index(70), 14);
  EXPECT_EQ(stations.count(), 8);
  expect_slopes(Range{99, {4.2, -4.7}, 5.5}, stations, some_state());
}

TEST(CalibratingModel, credit_is_that_of_student_s_t_with_four_degrees_of_freedom) {
  EXPECT_DOUBLE_EQ(model::credit(0.0, 2.0), 1.25);
  EXPECT_DOUBLE_EQ(model::credit(2.0, 2.0), 1.0);
  EXPECT_DOUBLE_EQ(model::credit(12.0, 2.0), 0.5);
}

Measured some_measurement(double residual, double variance, double phase) {
  Measured measured{Calibrated::Vector::Zero(), residual, variance};
  for (int i = 0; i < Calibrated::size_max; ++i) measured.slope(i) = std::cos(phase + 2.0 * i);
  return measured;
}

TEST(CalibratingModel, update_is_the_optimal_one_of_the_noise_that_the_innovation_makes_likely) {
  for (const bool as_set : {true, false}) {
    for (const double residual : {0.05, 1.5}) {
      const Measured measured = some_measurement(residual, 0.03, 0.4);
      Calibrated state{some_state(), some_covariance()};
      const model::Update update = model::update(state, measured, as_set);
      const Calibrated::Matrix p = some_covariance();
      const double known = measured.slope.dot(p * measured.slope);
      const double nis = residual * residual / (known + 0.03);
      // Near innovations keep the stated noise; the two cases are on both sides of one standard deviation.
      EXPECT_EQ(nis < 1.0, residual < 1.0);
      const double variance = as_set || nis < 1.0 ? 0.03 : 0.03 * (4.0 + nis) / 5.0;
      EXPECT_NEAR(update.nis, nis, 1e-12);
      EXPECT_NEAR(update.variance, variance, 1e-14);
      EXPECT_NEAR(update.log_likelihood, -2.5 * std::log(1.0 + nis / 4.0) - 0.5 * std::log(known + 0.03), 1e-12);
      const Calibrated::Vector gain = p * measured.slope / (known + variance);
      EXPECT_LT((state.mean - some_state() - gain * residual).norm(), 1e-13);
      EXPECT_LT(difference(state.covariance, p - gain * measured.slope.transpose() * p), 1e-14);
      for (int i = 0; i < Calibrated::size_max; ++i) {
        for (int j = 0; j < i; ++j) EXPECT_EQ(state.covariance(i, j), state.covariance(j, i));
      }
    }
  }
}

TEST(CalibratingModel, backward_pass_through_measurements_is_their_update_of_the_state_before) {
  // Three measurements of a constant state, two of them together: what the backward pass makes of the state before them
  // is what the updates make of the state after them.
  const std::array<Measured, 3> given{some_measurement(0.4, 0.03, 0.4), some_measurement(-0.3, 0.05, 1.1),
                                      some_measurement(0.6, 0.02, 2.5)};
  const Calibrated before{some_state(), some_covariance()};
  Calibrated after = before;
  std::array<Measured, 3> used = given;
  std::array<Calibrated::Matrix, 3> covariances;
  for (std::size_t k = 0; k < 3; ++k) {
    covariances[k] = after.covariance;
    used[k].residual -= used[k].slope.dot(after.mean - before.mean);
    model::update(after, used[k], true);
  }
  Calibrated::Vector lambda = Calibrated::Vector::Zero();
  Calibrated::Matrix big = Calibrated::Matrix::Zero();
  model::back_through(covariances[2], std::span(used).subspan(2, 1), lambda, big);
  model::back_through(covariances[0], std::span(used).first(2), lambda, big);
  EXPECT_LT((before.mean - before.covariance * lambda - after.mean).norm(), 1e-12);
  EXPECT_LT(difference(before.covariance - before.covariance * big * before.covariance, after.covariance), 1e-13);
}

TEST(CalibratingModel, range_over_a_micrometre_has_a_direction) {
  Stations stations;
  for (const double away_m : {5e-7, 2e-6}) {
    const Calibrated::Vector origin = Calibrated::Vector::Zero();
    const auto predicted =
        model::predicted_reading(sensors_of_the_model(), stations, origin, Range{17, {away_m, 0.0}, 0.0});
    EXPECT_EQ(predicted.count, away_m > 1e-6 ? 1 : 0) << away_m;
  }
}

}  // namespace
}  // namespace cosiva::estimation
