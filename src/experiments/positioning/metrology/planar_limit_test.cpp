#include "cosiva/experiments/positioning/metrology/planar_limit.h"

#include <gtest/gtest.h>

#include <cmath>

#include "cosiva/aiv/estimation/planar.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/positioning/metrology/qualification.h"

namespace cosiva::experiments {
namespace {

using estimation::Odometry;
using estimation::Range;
using estimation::Reading;

/// Sensors without common errors, with noise only.
estimation::SensorModel plain_sensors() {
  estimation::SensorModel sensors;
  sensors.distance_scale_sigma = sensors.turn_scale_sigma = 0.0;
  sensors.range_scale_sigma = sensors.range_common_sigma_m = sensors.range_station_sigma_m = 0.0;
  sensors.line_sigma_m = 0.0;
  return sensors;
}

void record_moment(Trial& run, const Pose2& ground_truth) {
  run.moments.push_back(
      {run.events.size(), static_cast<double>(run.moments.size()), ground_truth, 0.0, 0.0, std::nullopt});
}

constexpr std::array<Point2, 3> stations{{{10.0, 0.0}, {0.0, 20.0}, {-7.0, -7.0}}};

/// The vehicle is stopped at the origin and receives this number of ranges of three stations; a moment before and one
/// after.
Trial stopped(const estimation::SensorModel& sensors, int rounds) {
  Trial run;
  run.setting.sensors = sensors;
  run.setting.start_sigma_m = 0.5;
  record_moment(run, {});
  for (int i = 0; i < rounds; ++i) {
    for (std::uint32_t k = 0; k < stations.size(); ++k)
      run.events.emplace_back(Range{k, stations[k], norm(stations[k].x_m, stations[k].y_m)});
  }
  record_moment(run, {});
  return run;
}

/// The start is known to 0.5 m, three ranges have this variance each, and a common error of that variance: trace of
/// (I/0.25 + Hᵀ·(v·I + c·11ᵀ)⁻¹·H)⁻¹ by Sherman and Morrison.
double steady_m2(double v, double c) {
  const std::array<Point2, 3> h{{{-1.0, 0.0}, {0.0, -1.0}, {std::sqrt(0.5), std::sqrt(0.5)}}};
  double xx = 4.0;
  double xy = 0.0;
  double yy = 4.0;
  Point2 sum;
  for (const Point2 u : h) {
    xx += u.x_m * u.x_m / v;
    xy += u.x_m * u.y_m / v;
    yy += u.y_m * u.y_m / v;
    sum = {sum.x_m + u.x_m, sum.y_m + u.y_m};
  }
  const double common = c / (v * (v + 3.0 * c));
  xx -= common * sum.x_m * sum.x_m;
  xy -= common * sum.x_m * sum.y_m;
  yy -= common * sum.y_m * sum.y_m;
  return (xx + yy) / (xx * yy - xy * xy);
}

TEST(PlanarLimit, of_a_stopped_vehicle_between_stations_is_the_inverse_of_their_joint_information) {
  estimation::SensorModel sensors = plain_sensors();
  sensors.range_sigma_m = 0.2;
  for (const int rounds : {1, 4, 25}) {
    const RunLimit limit = planar_limit_of(stopped(sensors, rounds));
    const double after_m2 = steady_m2(0.04 / rounds, 0.0);
    // A moment before and one after; a smoother knows at the first what the filter knows at the second.
    EXPECT_NEAR(limit.filter_m2, 0.5 * (0.5 + after_m2), 1e-12) << rounds;
    EXPECT_NEAR(limit.smoother_m2, after_m2, 1e-12) << rounds;
  }
}

TEST(PlanarLimit, treats_common_errors_of_ranges_as_unknown) {
  estimation::SensorModel sensors = plain_sensors();
  sensors.range_sigma_m = 0.2;
  sensors.range_common_sigma_m = 0.3;
  EXPECT_NEAR(planar_limit_of(stopped(sensors, 1)).smoother_m2, steady_m2(0.04, 0.09), 1e-12);
  // More ranges reduce noise, but not the common error.
  EXPECT_NEAR(planar_limit_of(stopped(sensors, 400)).smoother_m2, steady_m2(0.04 / 400, 0.09), 1e-10);
  EXPECT_GT(steady_m2(0.04 / 400, 0.09), 1.005 * steady_m2(0.04 / 400, 0.0));
  // A station's own bias equals noise that does not change while the vehicle is stopped.
  sensors = plain_sensors();
  sensors.range_sigma_m = 0.2;
  sensors.range_station_sigma_m = 0.4;
  EXPECT_NEAR(planar_limit_of(stopped(sensors, 9)).smoother_m2, steady_m2(0.04 / 9 + 0.16, 0.0), 1e-10);
}

/// Straight along an angle, step by step.
struct Straight {
  Trial run;
  double step_m{0.02};
  double heading_rad{0.7};
  double traversed_m{0.0};

  void go(std::size_t steps, bool requested = true) {
    for (std::size_t i = 0; i < steps; ++i) {
      run.events.emplace_back(Odometry{step_m, 0.0, 0.05});
      traversed_m += step_m;
      if (requested) record_moment(run, here());
    }
  }
  [[nodiscard]] Pose2 here() const { return Pose2{1.0, -2.0, heading_rad} * Pose2{traversed_m, 0.0, 0.0}; }
};

TEST(PlanarLimit, of_odometry_alone_on_a_straight_is_its_random_walk_and_the_effect_of_the_heading) {
  for (const std::size_t steps : {1U, 10U, 500U}) {
    Straight drive;
    drive.run.setting.sensors = plain_sensors();
    drive.run.setting.start_sigma_m = 0.03;
    drive.run.setting.start_heading_sigma_rad = 0.01;
    drive.go(steps, false);
    record_moment(drive.run, drive.here());
    const double q = drive.run.setting.sensors.distance_variance_per_m * drive.step_m;
    const double t = drive.run.setting.sensors.turn_variance_per_m * drive.step_m;
    double across_m2 = 9e-4 + drive.traversed_m * drive.traversed_m * 1e-4;
    for (std::size_t k = 0; k < steps; ++k) across_m2 += t * std::pow((static_cast<double>(k) + 0.5) * drive.step_m, 2);
    const double along_m2 = 9e-4 + q * static_cast<double>(steps);
    const RunLimit limit = planar_limit_of(drive.run);
    EXPECT_NEAR(limit.filter_m2 / (along_m2 + across_m2), 1.0, 1e-9) << steps;
    // No later measurement adds information.
    EXPECT_EQ(limit.smoother_m2, limit.filter_m2);
  }
}

TEST(PlanarLimit, of_a_gyroscope_with_an_offset_grows_with_the_square_of_time_but_not_of_straight_wheels) {
  for (const double turn_rad : {1e-12, 0.0}) {
    Straight drive;
    drive.run.setting.sensors = plain_sensors();
    drive.run.setting.sensors.distance_variance_per_m = drive.run.setting.sensors.turn_variance_per_m = 0.0;
    drive.run.setting.sensors.turn_drift_sigma_radps = 0.004;
    drive.run.setting.start_sigma_m = drive.run.setting.start_heading_sigma_rad = 0.0;
    drive.go(800, false);
    for (Event& event : drive.run.events) std::get<Odometry>(event).turn_rad = turn_rad;
    record_moment(drive.run, drive.here());
    // 40 s at 0.4 m/s: the offset times v·t²/2.
    const double aside_m = turn_rad != 0.0 ? 0.004 * 0.4 * 40.0 * 40.0 / 2.0 : 0.0;
    EXPECT_NEAR(std::sqrt(planar_limit_of(drive.run).filter_m2), aside_m, 1e-6);
    EXPECT_NEAR(std::sqrt(planar_limit_of(drive.run).smoother_m2), aside_m, 1e-6);
  }
}

TEST(PlanarLimit, of_sideways_motion_equals_that_of_straight_motion) {
  Straight ahead;
  ahead.run.setting.sensors.distance_variance_per_m = 1e-2;
  Straight aside = ahead;
  ahead.go(100);
  aside.go(100);
  for (Event& event : aside.run.events) event = Odometry{0.0, 0.0, 0.05, 0.0, 0.0, -aside.step_m};
  for (Moment& moment : aside.run.moments) moment.ground_truth.heading_rad += 0.5 * pi;
  const RunLimit one = planar_limit_of(ahead.run);
  const RunLimit other = planar_limit_of(aside.run);
  EXPECT_NEAR(one.filter_m2, other.filter_m2, 1e-9 * one.filter_m2);
  EXPECT_NEAR(one.smoother_m2, other.smoother_m2, 1e-9 * one.smoother_m2);
}

TEST(PlanarLimit, of_an_unknown_heading_is_at_most_a_circle) {
  Straight drive;
  drive.run.setting.sensors = plain_sensors();
  drive.run.setting.sensors.distance_variance_per_m = drive.run.setting.sensors.turn_variance_per_m = 0.0;
  drive.run.setting.start_sigma_m = 0.0;
  drive.run.setting.start_heading_sigma_rad = pi;
  drive.go(100, false);
  record_moment(drive.run, drive.here());
  EXPECT_NEAR(planar_limit_of(drive.run).filter_m2, drive.traversed_m * drive.traversed_m, 1e-9);
}

/// With a known heading and beacons read along the path the problem is one-dimensional and linear: Kalman's own
/// variance.
Trial beacons_on_a_straight(double pitch_m, bool heading_known) {
  Straight drive;
  drive.run.heading_known = heading_known;
  auto& sensors = drive.run.setting.sensors = plain_sensors();
  sensors.turn_variance_per_m = sensors.turn_variance_per_rad = 0.0;
  sensors.fiducial_across_sigma_m = 1e9;
  drive.run.setting.start_heading_sigma_rad = 0.0;
  drive.run.setting.start_sigma_m = std::sqrt(sawtooth({1e-4, pitch_m, 1e-4}).after_m2);
  const auto steps = static_cast<std::size_t>(std::lround(pitch_m / drive.step_m));
  for (std::uint32_t i = 0; i < 400; ++i) {
    drive.go(steps - 1);
    drive.go(1, false);
    drive.run.events.emplace_back(Reading{i, position(drive.here() * Pose2{0.1, 0.05, 0.0}), {0.1, 0.05}});
    record_moment(drive.run, drive.here());
  }
  return drive.run;
}

TEST(PlanarLimit, of_a_linear_problem_is_the_kalman_filter_s_and_the_smoother_s_own_variance) {
  for (const double pitch_m : {0.2, 1.0, 4.0}) {
    const Trial run = beacons_on_a_straight(pitch_m, true);
    const double across_m2 = run.setting.start_sigma_m * run.setting.start_sigma_m;
    const RunLimit on_the_line = limit_of(run);
    const RunLimit on_the_plane = planar_limit_of(run);
    EXPECT_NEAR(on_the_plane.filter_m2, on_the_line.filter_m2 + across_m2, 1e-12);
    EXPECT_NEAR(on_the_plane.smoother_m2, on_the_line.smoother_m2 + across_m2, 1e-12);
    const Regime regime{1e-4, pitch_m, 1e-4};
    EXPECT_NEAR(std::sqrt(on_the_plane.filter_m2 - across_m2) / filter_limit_m(regime), 1.0, 0.03) << pitch_m;
    EXPECT_NEAR(std::sqrt(on_the_plane.smoother_m2 - across_m2) / smoother_limit_m(regime), 1.0, 0.03) << pitch_m;
  }
}

TEST(PlanarLimit, takes_the_course_where_the_ground_truth_has_no_heading) {
  Trial headless = beacons_on_a_straight(1.0, false);
  for (Moment& moment : headless.moments) moment.ground_truth.heading_rad = 0.0;
  const RunLimit limit = planar_limit_of(headless);
  const RunLimit known = planar_limit_of(beacons_on_a_straight(1.0, true));
  EXPECT_NEAR(limit.filter_m2 / known.filter_m2, 1.0, 1e-6);
  EXPECT_NEAR(limit.smoother_m2 / known.smoother_m2, 1.0, 1e-6);
}

/// Along a circle between four stations, with noise of exactly the size stated for the sensors.
void lap(std::uint64_t seed, Trial& run) {
  run = {};
  run.name = "lap " + std::to_string(seed);
  estimation::SensorModel& sensors = run.setting.sensors = plain_sensors();
  sensors.range_sigma_m = 0.05;
  run.setting.start_sigma_m = 0.02;
  Random random{seed, "test/lap"};
  Pose2 ground_truth{6.0, 0.0, 0.5 * pi};
  run.setting.start = {ground_truth.x_m + random.gaussian(0.0, 0.02), ground_truth.y_m + random.gaussian(0.0, 0.02),
                       ground_truth.heading_rad + random.gaussian(0.0, run.setting.start_heading_sigma_rad)};
  constexpr std::array<Point2, 4> corners{{{10.0, 10.0}, {-10.0, 10.0}, {-10.0, -10.0}, {10.0, -10.0}}};
  for (std::uint32_t i = 0; i < 600; ++i) {
    const Odometry counted{0.05, 0.05 / 6.0, 0.1};
    const auto variances = estimation::step_variances(sensors, counted);
    ground_truth =
        estimation::moved(ground_truth, {counted.distance_m + random.gaussian(0.0, std::sqrt(variances(0))),
                                         counted.turn_rad + random.gaussian(0.0, std::sqrt(variances(1))), 0.1});
    run.events.emplace_back(counted);
    if (i % 5 == 4) {
      const Point2 corner = corners[i / 5 % 4];
      run.events.emplace_back(
          Range{i / 5 % 4, corner, distance(position(ground_truth), corner) + random.gaussian(0.0, 0.05)});
    }
    run.moments.push_back({run.events.size(), 0.1 * (i + 1), ground_truth, 0.05 * (i + 1), 0.0, std::nullopt});
  }
}

/// Knows the ground truth up to a few millimetres.
class Cheat final : public estimation::Algorithm {
 public:
  explicit Cheat(std::uint64_t seed) { lap(seed, run_); }
  void predict(const Odometry&) override { ++events_; }
  estimation::Rectified rectify(const Reading&) override { return {++events_ > 0, std::nullopt, 0}; }
  estimation::Rectified rectify(const Range&) override { return {++events_ > 0, std::nullopt, 0}; }
  estimation::Estimate estimate() const override {
    for (const Moment& moment : run_.moments) {
      if (moment.events == events_)
        return {moment.ground_truth * Pose2{0.003, 0.0, 0.0}, estimation::Matrix3::Identity(), std::nullopt};
    }
    return {};
  }

 private:
  Trial run_;
  std::size_t events_{0};
};

Qualification laps(std::size_t runs) {
  static const estimation::Registry registry;
  std::vector<Candidate> candidates;
  for (const std::string name : {"ekf", "iekf", "smoother"})
    candidates.push_back({name, "", (*registry.find(name))->backtracks,
                          [name](const estimation::Setting& setting) { return registry.make(name, setting); }});
  candidates.push_back(
      {"cheat", "", false, [](const estimation::Setting& setting) -> Result<std::unique_ptr<estimation::Algorithm>> {
         return std::make_unique<Cheat>(setting.seed);
       }});
  const auto source = [](std::size_t index, Trial& room) -> Result<const Trial*> {
    lap(index + 1, room);
    room.setting.seed = index + 1;
    return &room;
  };
  return *qualify(candidates, runs, source, {});
}

TEST(PlanarLimitStatistics, is_reached_by_filter_and_smoother_with_noise_as_stated_and_surpassed_by_none) {
  const Qualification q = laps(60);
  for (const std::size_t i : {0U, 1U, 2U}) {
    const Qualified& one = q.algorithms[i];
    ASSERT_TRUE(one.limit_m) << one.name;
    EXPECT_FALSE(one.leak) << one.name;
    EXPECT_GT(*one.gap_percent, -4.0) << one.name;
    EXPECT_LT(*one.gap_percent, 8.0) << one.name;
  }
  EXPECT_LT(*q.algorithms[2].limit_m, 0.85 * *q.algorithms[0].limit_m);
}

TEST(PlanarLimit, of_undescribed_sensors_calls_no_algorithm_a_leak) {
  const auto source = [](std::size_t index, Trial& room) -> Result<const Trial*> {
    lap(index + 1, room);
    room.sensors_assumed = true;
    return &room;
  };
  const Candidate cheat{"cheat", "", false,
                        [](const estimation::Setting&) -> Result<std::unique_ptr<estimation::Algorithm>> {
                          return std::make_unique<Cheat>(1);
                        }};
  const auto q = qualify({cheat}, 1, source, {});
  ASSERT_TRUE(q);
  EXPECT_LT(*q->algorithms[0].gap_percent, -50.0);
  EXPECT_TRUE(q->algorithms[0].limit_assumed);
  EXPECT_FALSE(q->algorithms[0].leak);
}

TEST(PlanarLimitStatistics, flags_an_algorithm_that_knows_the_ground_truth_in_many_runs_and_in_one) {
  for (const std::size_t runs : {1U, 8U}) {
    const Qualification q = laps(runs);
    EXPECT_TRUE(q.algorithms[3].leak) << runs;
    EXPECT_LT(*q.algorithms[3].gap_percent, -50.0) << runs;
    EXPECT_FALSE(q.algorithms[0].leak) << runs;
    EXPECT_FALSE(q.algorithms[2].leak) << runs;
  }
}

}  // namespace
}  // namespace cosiva::experiments
