#include "cosiva/aiv/estimation/calibrating.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <utility>
#include <vector>

#include "cosiva/aiv/estimation/calibrating_model.h"
#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/base/math.h"
#include "cosiva/base/random.h"

namespace cosiva::estimation {
namespace {

/// A vehicle that drives five laps of a circle of 20 m with the requested number of stations.
struct Rounds {
  Setting setting;
  double drift_radps{0.0};
  std::size_t stations{4};
  Pose2 ground_truth;
  int count{0};

  Rounds() {
    setting.start = {20.0, 0.0, 0.5 * pi};
    SensorModel& sensors = setting.sensors;
    sensors.range_scale_sigma = sensors.range_common_sigma_m = sensors.range_station_sigma_m = 1e-3;
    sensors.distance_scale_sigma = sensors.turn_scale_sigma = 1e-4;
    ground_truth = setting.start;
  }
  void step(CalibratingFilter& filter, Random& random) {
    const Odometry truly{0.5, 0.025, 0.5};
    ground_truth = moved(ground_truth, truly);
    const Vector2 v = step_variances(setting.sensors, truly);
    filter.predict({truly.distance_m + random.gaussian(0.0, std::sqrt(v(0))),
                    truly.turn_rad + 0.5 * drift_radps + random.gaussian(0.0, std::sqrt(v(1))), 0.5});
    const auto station = static_cast<std::uint32_t>(static_cast<std::size_t>(count++) % stations);
    const Point2 track_position{station % 2 == 0 ? -30.0 : 30.0, station < 2 ? -30.0 : 30.0};
    filter.rectify(
        Range{station, track_position,
              distance(position(ground_truth), track_position) + random.gaussian(0.0, setting.sensors.range_sigma_m)});
  }
  [[nodiscard]] double nees(const CalibratingFilter& filter) const {
    const Estimate estimate = filter.estimate();
    const Vector2 e(estimate.pose.x_m - ground_truth.x_m, estimate.pose.y_m - ground_truth.y_m);
    return e.dot(Matrix2(estimate.covariance.topLeftCorner<2, 2>()).llt().solve(e));
  }
};

TEST(Calibrating, estimates_a_gyroscope_s_offset_only_where_one_is_expected) {
  for (const double expected_radps : {0.005, 0.0}) {
    Rounds rounds;
    rounds.drift_radps = 0.008;
    rounds.setting.sensors.turn_drift_sigma_radps = expected_radps;
    CalibratingFilter filter{rounds.setting};
    Random random{3, "drift"};
    double nees = 0.0;
    for (int i = 0; i < 1000; ++i) {
      rounds.step(filter, random);
      nees += 1e-3 * rounds.nees(filter);
    }
    const double found_radps = filter.state().mean(CalibratedState::turn_drift);
    if (expected_radps > 0.0) {
      EXPECT_NEAR(found_radps, 0.008, 0.001);
      EXPECT_LT(nees, 3.0);
    } else {
      EXPECT_EQ(found_radps, 0.0);
      EXPECT_GT(nees, 3.0);
    }
  }
}

TEST(Calibrating, loses_its_heading_at_standstill_with_a_gyroscope_but_not_with_wheels) {
  Setting setting;
  setting.sensors.turn_drift_sigma_radps = 0.005;
  CalibratingFilter gyroscope{setting};
  CalibratingFilter wheels{setting};
  for (int i = 0; i < 600; ++i) {
    gyroscope.predict({0.0, i % 2 == 0 ? 1e-5 : -1e-5, 0.1});
    wheels.predict({0.0, 0.0, 0.1});
  }
  // A minute of 0.005 rad/s, and the uncertainty of the start.
  EXPECT_NEAR(std::sqrt(gyroscope.estimate().covariance(2, 2)), 0.3, 0.01);
  EXPECT_NEAR(std::sqrt(wheels.estimate().covariance(2, 2)), setting.start_heading_sigma_rad, 1e-9);
}

TEST(Calibrating, searches_all_directions_after_the_loss_of_its_heading_and_the_smoother_recovers_the_poses) {
  Rounds rounds;
  CalibratingSmoother smoother{rounds.setting};
  Random random{5, "lost"};
  for (int i = 0; i < 100; ++i) rounds.step(smoother, random);
  // No motion was counted while the vehicle turned about on the spot.
  rounds.ground_truth.heading_rad = wrap_angle(rounds.ground_truth.heading_rad + pi);
  smoother.predict({0.0, 0.0, 5.0, 1e-4, 4.0});
  EXPECT_GT(smoother.estimate().covariance(2, 2), 1.0);
  std::vector<Pose2> ground_truths;
  for (int i = 0; i < 100; ++i) {
    rounds.step(smoother, random);
    ground_truths.push_back(rounds.ground_truth);
  }
  EXPECT_NEAR(wrap_angle(smoother.estimate().pose.heading_rad - rounds.ground_truth.heading_rad), 0.0, 0.1);
  EXPECT_LT(distance(smoother.estimate().pose, rounds.ground_truth), 0.5);
  const std::vector<Estimate> revised = smoother.revised();
  ASSERT_EQ(revised.size(), 201U);
  for (std::size_t i = 0; i < ground_truths.size(); i += 9)
    EXPECT_LT(distance(revised[101 + i].pose, ground_truths[i]), 0.3) << "after " << i;
}

TEST(Planar, step_of_a_sideways_motion_is_its_arc) {
  // A quarter of a circle of 2 m about a point behind the vehicle, which faces outwards.
  const Pose2 end = moved({0.0, 0.0, 0.0}, {0.0, 0.5 * pi, 1.0, 0.0, 0.0, pi});
  EXPECT_NEAR(end.x_m, -2.0, 1e-12);
  EXPECT_NEAR(end.y_m, 2.0, 1e-12);
  EXPECT_NEAR(end.heading_rad, 0.5 * pi, 1e-12);
}

TEST(Planar, sideways_motion_is_as_uncertain_as_straight_motion_of_the_same_length) {
  // Both along x: one vehicle faces it, the other has it on its right side.
  Setting setting;
  setting.sensors.distance_variance_per_m = 1e-2;
  Setting turned = setting;
  turned.start.heading_rad = 0.5 * pi;
  Ekf ahead{setting};
  Ekf aside{turned};
  CalibratingFilter wise_ahead{setting};
  CalibratingFilter wise_aside{turned};
  for (int i = 0; i < 50; ++i) {
    for (Algorithm* one : {static_cast<Algorithm*>(&ahead), static_cast<Algorithm*>(&wise_ahead)})
      one->predict({0.1, 0.0, 0.1});
    for (Algorithm* one : {static_cast<Algorithm*>(&aside), static_cast<Algorithm*>(&wise_aside)})
      one->predict({0.0, 0.0, 0.1, 0.0, 0.0, -0.1});
  }
  for (const auto& [one, other] :
       {std::pair{ahead.estimate(), aside.estimate()}, std::pair{wise_ahead.estimate(), wise_aside.estimate()}}) {
    EXPECT_NEAR(other.pose.x_m, 5.0, 1e-9);
    EXPECT_NEAR(other.pose.y_m, 0.0, 1e-9);
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column)
        EXPECT_NEAR(one.covariance(row, column), other.covariance(row, column), 1e-9) << row << column;
    }
  }
}

TEST(Calibrating, does_not_become_certain_of_the_angle_about_its_only_station) {
  double sum = 0.0;
  std::size_t count = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Rounds rounds;
    rounds.stations = 1;
    rounds.setting.sensors.turn_variance_per_m = 1e-4;
    rounds.setting.sensors.distance_variance_per_m = 1.6e-3;
    rounds.setting.start_heading_sigma_rad = 0.1;
    CalibratingFilter filter{rounds.setting};
    Random random{seed, "round one"};
    rounds.ground_truth.heading_rad += random.gaussian(0.0, 0.1);
    for (int i = 0; i < 1000; ++i) {
      rounds.step(filter, random);
      sum += rounds.nees(filter);
      ++count;
    }
  }
  // 3.8 for a filter that corrects x, y and the heading separately; 2 would be consistent.
  EXPECT_LT(sum / static_cast<double>(count), 3.3);
}

/// The filter with its hypotheses accessible.
struct Open : CalibratingFilter {
  using CalibratingFilter::CalibratingFilter;
  using CalibratingFilter::hypotheses;
  using CalibratingFilter::Hypothesis;
  using CalibratingFilter::stations;
};

Setting without_a_heading() {
  Setting setting;
  setting.start = {1.0, 2.0, 0.5};
  setting.start_heading_sigma_rad = 1.01;
  setting.sensors.distance_variance_per_m = setting.sensors.turn_variance_per_m = 0.0;
  setting.sensors.distance_scale_sigma = setting.sensors.turn_scale_sigma = 0.0;
  return setting;
}

TEST(Calibrating, tries_directions_of_fifteen_degrees_where_the_heading_is_unknown) {
  Setting known = without_a_heading();
  known.start_heading_sigma_rad = 1.0;  // at the limit
  const Open one{known};
  ASSERT_EQ(one.hypotheses.size(), 1U);
  EXPECT_EQ(one.hypotheses[0].state.mean(2), 0.5);
  EXPECT_EQ(one.hypotheses[0].start_heading_rad, 0.5);
  EXPECT_NEAR(one.estimate().covariance(2, 2), 1.0, 1e-12);

  const Open all{without_a_heading()};
  ASSERT_EQ(all.hypotheses.size(), 24U);
  for (int i = 0; i < 24; ++i) {
    const auto& hypothesis = all.hypotheses[static_cast<std::size_t>(i)];
    const double heading_rad = i * pi / 12.0;
    EXPECT_NEAR(wrap_angle(hypothesis.state.mean(2) - heading_rad), 0.0, 1e-12);
    EXPECT_EQ(hypothesis.start_heading_rad, hypothesis.state.mean(2));
    EXPECT_NEAR(hypothesis.state.covariance(2, 2), pi * pi / 576.0, 1e-12);
    EXPECT_EQ(hypothesis.log_weight, 0.0);
  }
}

TEST(Calibrating, estimate_of_several_directions_is_their_mean_and_their_spread) {
  Open filter{without_a_heading()};
  filter.predict({3.0, 0.0, 1.0});
  const Estimate estimate = filter.estimate();
  // Into all directions: the mean is the start, and half the square of the distance is in x and half in y; the headings
  // are spread evenly about the first one, from −165° to 180°.
  EXPECT_NEAR(estimate.pose.x_m, 1.0, 1e-12);
  EXPECT_NEAR(estimate.pose.y_m, 2.0, 1e-12);
  const double own = pi * pi / 576.0;
  EXPECT_NEAR(estimate.covariance(0, 0), 1e-4 + 4.5 + 4.5 * own, 1e-9);
  EXPECT_NEAR(estimate.covariance(1, 1), 1e-4 + 4.5 + 4.5 * own, 1e-9);
  EXPECT_NEAR(estimate.covariance(0, 1), 0.0, 1e-9);
  const double step = pi / 12.0;
  EXPECT_NEAR(std::fabs(estimate.pose.heading_rad), 0.5 * step, 1e-12);
  EXPECT_NEAR(estimate.covariance(2, 2), own + step * step * (24.0 * 24.0 - 1.0) / 12.0, 1e-9);
  // Weights count: one direction of e times the weight of the others.
  filter.hypotheses[6].log_weight = 1.0;
  const double e = std::exp(1.0);
  EXPECT_NEAR(filter.estimate().pose.x_m, 1.0, 1e-12);
  EXPECT_NEAR(filter.estimate().pose.y_m, 2.0 + 3.0 * (e - 1.0) / (23.0 + e), 1e-12);
  EXPECT_NEAR(filter.state().mean(2), 0.5 * pi, 1e-12);
}

TEST(Calibrating, drops_directions_that_are_less_likely_than_one_in_160_000) {
  Open filter{without_a_heading()};
  filter.predict({3.0, 0.0, 1.0});
  // Likelihoods as the model gives them, from copies of all hypotheses.
  const Range range{5, {9.0, 2.0}, 5.0};
  std::vector<Open::Hypothesis> expected = filter.hypotheses;
  Stations stations;
  double nis = 0.0;
  double best = -1e9;
  for (auto& hypothesis : expected) {
    const auto predicted =
        model::predicted_reading(without_a_heading().sensors, stations, hypothesis.state.mean, range);
    const model::Update update = model::update(hypothesis.state, predicted.measured[0], false);
    hypothesis.log_weight += update.log_likelihood;
    if (&hypothesis == &expected.front()) nis = update.nis;
    best = std::fmax(best, hypothesis.log_weight);
  }
  expected[3].log_weight = best - 11.9 - expected[3].log_weight;  // the weight that it must have before
  expected[4].log_weight = best - 12.1 - expected[4].log_weight;
  filter.hypotheses[3].log_weight = expected[3].log_weight;
  filter.hypotheses[4].log_weight = expected[4].log_weight;
  const Rectified rectified = filter.rectify(range);
  EXPECT_TRUE(rectified.accepted);
  EXPECT_EQ(rectified.dimensions, 1);
  EXPECT_NEAR(*rectified.nis, nis, 1e-12);
  EXPECT_EQ(filter.hypotheses.size(), 23U);
  for (const auto& hypothesis : filter.hypotheses)
    EXPECT_GT(std::fabs(hypothesis.start_heading_rad - 4.0 * pi / 12.0), 0.1);
}

TEST(Calibrating, reading_corrects_both_components_one_after_the_other_and_a_range_is_carried) {
  Setting setting;
  setting.start = {1.0, 2.0, 0.5};
  setting.start_sigma_m = 0.2;
  for (const bool ranges : {false, true}) {
    Open filter{setting};
    filter.predict({1.0, 0.2, 1.0});
    CalibratedState expected = filter.state();
    const CalibratedState::Vector before = expected.mean;
    Stations stations;
    const Reading reading{1, {2.0, 3.0}, {0.2, 0.1}};
    const Range range{1, {-3.0, 3.0}, 5.2};
    const auto predicted = ranges ? model::predicted_reading(setting.sensors, stations, before, range)
                                  : model::predicted_reading(setting.sensors, stations, before, reading);
    double nis = 0.0;
    for (std::size_t k = 0; k < static_cast<std::size_t>(predicted.count); ++k) {
      Measured measured = predicted.measured[k];
      measured.residual -= measured.slope.dot(expected.mean - before);
      nis += model::update(expected, measured, false).nis;
    }
    if (ranges) model::carry(expected, before);
    const Rectified rectified = ranges ? filter.rectify(range) : filter.rectify(reading);
    EXPECT_TRUE(rectified.accepted);
    EXPECT_EQ(rectified.dimensions, ranges ? 1 : 2);
    EXPECT_NEAR(*rectified.nis, nis, 1e-12);
    EXPECT_EQ(filter.state().mean, expected.mean);
    EXPECT_EQ(filter.state().covariance, expected.covariance);
  }
}

TEST(Calibrating, starts_its_search_anew_about_the_present_estimate_once_its_heading_is_lost) {
  Setting setting;
  setting.start = {1.0, 2.0, 0.5};
  Open filter{setting};
  filter.predict({2.0, 0.0, 1.0});
  const double known = filter.estimate().covariance(2, 2);
  // One radian is the limit.
  Open kept{setting};
  kept.predict({2.0, 0.0, 1.0, 0.0, 0.99 - known});
  EXPECT_EQ(kept.hypotheses.size(), 1U);
  const Estimate before = filter.estimate();
  filter.predict({0.0, 0.0, 1.0, 0.0, 4.0});
  ASSERT_EQ(filter.hypotheses.size(), 24U);
  const double variance = known + 4.0;
  for (int i = 0; i < 24; ++i) {
    const auto& hypothesis = filter.hypotheses[static_cast<std::size_t>(i)];
    const double by_rad = (i - 12) * pi / 12.0;
    EXPECT_NEAR(hypothesis.state.mean(2), 0.5 + by_rad, 1e-12);
    EXPECT_NEAR(hypothesis.state.mean(0), before.pose.x_m, 1e-12);
    EXPECT_NEAR(hypothesis.state.mean(1), before.pose.y_m, 1e-12);
    EXPECT_NEAR(hypothesis.log_weight, -0.5 * by_rad * by_rad / variance, 1e-12);
    const auto& p = hypothesis.state.covariance;
    EXPECT_NEAR(p(2, 2), pi * pi / 576.0, 1e-12);
    EXPECT_EQ((p.row(2).cwiseAbs().sum()), p(2, 2));
    EXPECT_EQ((p.col(2).cwiseAbs().sum()), p(2, 2));
    EXPECT_LT((Matrix2(p.topLeftCorner<2, 2>()) - Matrix2(before.covariance.topLeftCorner<2, 2>())).norm(), 1e-12);
    ASSERT_EQ(hypothesis.turned.size(), 1U);
    EXPECT_EQ(hypothesis.turned[0].input, 1U);  // the second
    EXPECT_NEAR(hypothesis.turned[0].by_rad, by_rad, 1e-12);
  }
}

TEST(Calibrating, smoother_is_the_most_likely_drive_by_student_s_t) {
  // Straight ahead with a certain heading and certain scales: positions along x by the start, two steps of odometry and
  // two readings. The noise of a reading is that of Student's t at the result's residual r: R·(4 + r²/R)/5.
  Setting setting;
  setting.start_sigma_m = 0.02;
  setting.start_heading_sigma_rad = 1e-9;
  SensorModel& sensors = setting.sensors;
  sensors.turn_variance_per_m = sensors.turn_variance_per_rad = 0.0;
  sensors.distance_scale_sigma = sensors.turn_scale_sigma = 1e-9;
  CalibratingSmoother smoother{setting};
  smoother.predict({1.0, 0.0, 1.0});
  smoother.rectify(Reading{1, {1.04, 0.0}, {}});
  smoother.predict({2.0, 0.0, 1.0});
  smoother.rectify(Reading{2, {3.03, 0.0}, {0.0, 0.0}});
  const std::vector<Estimate> revised = smoother.revised();
  ASSERT_EQ(revised.size(), 2U);
  Vector2 mean(1.0, 3.0);
  Matrix2 information;
  for (int round = 0; round < 100; ++round) {
    const auto noise = [](double residual) { return 1e-4 * (4.0 + residual * residual / 1e-4) / 5.0; };
    const double first = 1.0 / noise(1.04 - mean(0));
    const double second = 1.0 / noise(3.03 - mean(1));
    const double start = 1.0 / (4e-4 + 1e-4);
    const double step = 1.0 / 2e-4;
    information << start + first + step, -step, -step, second + step;
    mean = information.llt().solve(Vector2(start * 1.0 + first * 1.04 - step * 2.0, second * 3.03 + step * 2.0));
  }
  const Matrix2 covariance = information.llt().solve(Matrix2::Identity());
  for (int i = 0; i < 2; ++i) {
    const Estimate& estimate = revised[static_cast<std::size_t>(i)];
    EXPECT_NEAR(estimate.pose.x_m, mean(i), 1e-5);
    EXPECT_NEAR(estimate.pose.y_m, 0.0, 1e-6);
    EXPECT_NEAR(estimate.covariance(0, 0), covariance(i, i), 2e-3 * covariance(i, i));
  }
}

}  // namespace
}  // namespace cosiva::estimation
