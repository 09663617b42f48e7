#include "cosiva/experiments/positioning/metrology/simulate.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <string>

#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/experiments/positioning/metrology/limit.h"
#include "cosiva/experiments/positioning/metrology/test_tracks.h"
#include "cosiva/experiments/statistics/sample.h"

namespace cosiva::experiments {
namespace {

struct Outcome {
  double rmse_m;
  double standard_error_m;
  double nees;
};

/// RMSE along the track over many runs, and its standard error from the spread of runs.
Outcome outcome_of(const std::string& name, double pitch_m, int runs = 60) {
  Simulation simulation{testing::oval()};
  simulation.pitch_m = pitch_m;
  simulation.distance_m = 400.0 * pitch_m;
  // The steps from beacon to beacon are not a whole number: all phases between two beacons occur.
  simulation.odometry_hz = 12.37 * simulation.speed_mps / pitch_m;
  simulation.sensors.line_sigma_m = 0.0;
  simulation.start_sigma_m = std::sqrt(sawtooth({1e-4, pitch_m, 1e-4}).after_m2);
  const estimation::Registry registry;
  Trial run;
  Trace trace;
  std::vector<double> squares;
  std::vector<double> nees;
  for (int seed = 1; seed <= runs; ++seed) {
    simulate(simulation, static_cast<std::uint64_t>(seed), run);
    (void)apply(**registry.make(name, run.setting), run, trace);
    const double rms = statistics::root_mean_square(trace.along_m);
    squares.push_back(rms * rms);
    double sum = 0.0;
    for (std::size_t i = 0; i < trace.along_m.size(); ++i) {
      // In one dimension, along the track: the stated variance is the larger of the two.
      const auto& c = trace.estimates[i].covariance;
      sum += trace.along_m[i] * trace.along_m[i] / (c(0, 0) + c(1, 1));
    }
    nees.push_back(sum / static_cast<double>(trace.along_m.size()));
  }
  const double mean = statistics::mean(squares);
  const double error = std::sqrt(statistics::sample_variance(squares) / static_cast<double>(squares.size()));
  return {std::sqrt(mean), 0.5 * error / std::sqrt(mean), statistics::mean(nees)};
}

constexpr std::array pitches_m{0.1, 0.25, 0.5, 1.0, 2.0, 4.0};

TEST(Simulated, arc_length_filter_reaches_the_limit_at_six_pitches_without_surpassing_it) {
  for (const double pitch_m : pitches_m) {
    const Outcome outcome = outcome_of("arc_kalman", pitch_m);
    const double limit_m = filter_limit_m({1e-4, pitch_m, 1e-4});
    EXPECT_NEAR(outcome.rmse_m / limit_m, 1.0, 0.03) << pitch_m;
    EXPECT_GT(outcome.rmse_m + 2.0 * outcome.standard_error_m, limit_m) << pitch_m;
    EXPECT_NEAR(outcome.nees, 1.0, 0.06) << pitch_m;
  }
}

TEST(Simulated, arc_length_smoother_reaches_its_limit_at_six_pitches_without_surpassing_it) {
  for (const double pitch_m : pitches_m) {
    const Outcome outcome = outcome_of("arc_smoother", pitch_m);
    const double limit_m = smoother_limit_m({1e-4, pitch_m, 1e-4});
    EXPECT_NEAR(outcome.rmse_m / limit_m, 1.0, 0.03) << pitch_m;
    EXPECT_GT(outcome.rmse_m + 2.0 * outcome.standard_error_m, limit_m) << pitch_m;
  }
}

TEST(Simulated, the_article_s_rule_equals_its_closed_form) {
  for (const double pitch_m : pitches_m) {
    const Outcome outcome = outcome_of("reset_rule", pitch_m);
    EXPECT_NEAR(outcome.rmse_m / reset_rule_m({1e-4, pitch_m, 1e-4}), 1.0, 0.03) << pitch_m;
  }
}

TEST(SimulatedStatistics, no_algorithm_that_does_not_look_back_surpasses_the_limit) {
  for (const char* name :
       {"dead_reckoning", "reset_rule", "arc_kalman_scale", "ekf", "ukf", "iekf", "particles", "ufir", "calibrating"}) {
    const Outcome outcome = outcome_of(name, 0.5, 10);
    EXPECT_GT(outcome.rmse_m + 2.0 * outcome.standard_error_m, filter_limit_m({1e-4, 0.5, 1e-4})) << name;
    // And each algorithm improves the estimate: odometry alone has an error of a decimetre at the end.
    EXPECT_LT(outcome.rmse_m, std::string(name) == "dead_reckoning" ? 0.30 : 0.02) << name;
  }
}

TEST(Simulated, runs_are_equal_for_equal_seeds_only) {
  Simulation simulation{testing::oval()};
  simulation.distance_m = 5.0;
  Trial one;
  Trial two;
  simulate(simulation, 7, one);
  simulate(simulation, 7, two);
  ASSERT_EQ(one.events.size(), two.events.size());
  const auto last = [](const Trial& run) { return run.moments.back().ground_truth.x_m + run.setting.start_along_m; };
  EXPECT_EQ(last(one), last(two));
  simulate(simulation, 8, two);
  EXPECT_NE(last(one), last(two));
}

TEST(Simulated, missed_reads_increase_the_error_at_least_as_the_bound_states) {
  Simulation simulation{testing::oval()};
  simulation.distance_m = 2000.0;
  simulation.odometry_hz = 20.0;
  simulation.turns = false;
  simulation.read_ratio = 0.7;
  simulation.sensors.line_sigma_m = 0.0;
  Trial run;
  simulate(simulation, 1, run);
  // Bound 9.39 mm by R/p, simulated by an independent program 9.97 mm.
  EXPECT_NEAR(1e3 * filter_limit_m({1e-4, 0.5, 1e-4 / 0.7}), 9.39, 0.01);
  EXPECT_NEAR(1e3 * std::sqrt(limit_of(run).filter_m2), 9.97, 0.15);
}

TEST(Simulated, a_worn_wheel_is_found_by_an_algorithm_that_estimates_it) {
  Simulation simulation{testing::oval()};
  simulation.distance_m = 100.0;
  simulation.pitch_m = 2.0;
  simulation.odometry_hz = 20.0;
  simulation.scale_sigma = 0.02;
  const estimation::Registry registry;
  Trial run;
  Trace trace;
  double plain = 0.0;
  double scaled = 0.0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    simulate(simulation, seed, run);
    (void)apply(**registry.make("arc_kalman", run.setting), run, trace);
    plain += statistics::root_mean_square(trace.along_m) / 20;
    (void)apply(**registry.make("arc_kalman_scale", run.setting), run, trace);
    scaled += statistics::root_mean_square(trace.along_m) / 20;
  }
  EXPECT_LT(scaled, 0.8 * plain);
}

TEST(Simulation, refuses_invalid_values) {
  Simulation simulation{testing::oval()};
  EXPECT_TRUE(check(simulation));
  const auto code = [&](auto change) {
    Simulation bad = simulation;
    change(bad);
    const auto result = check(bad);
    return result ? std::string() : result.error().code;
  };
  EXPECT_EQ(code([](Simulation& s) { s.pitch_m = 0.0; }), "simulation.pitch");
  EXPECT_EQ(code([](Simulation& s) { s.distance_m = -1.0; }), "simulation.distance");
  EXPECT_EQ(code([](Simulation& s) { s.distance_m = 0.001; }), "simulation.distance");
  EXPECT_EQ(code([](Simulation& s) { s.speed_mps = std::nan(""); }), "simulation.speed");
  EXPECT_EQ(code([](Simulation& s) { s.read_ratio = 1.5; }), "simulation.reads");
  EXPECT_EQ(code([](Simulation& s) { s.distance_m = 1e8; }), "simulation.length");
  EXPECT_EQ(code([](Simulation& s) { s.track = nullptr; }), "simulation.track");
}

}  // namespace
}  // namespace cosiva::experiments
