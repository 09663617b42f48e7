#include "cosiva/experiments/positioning/metrology/qualification.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "cosiva/aiv/estimation/arc.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/experiments/positioning/metrology/result.h"
#include "cosiva/experiments/positioning/metrology/result_json.h"
#include "cosiva/experiments/positioning/metrology/simulate.h"
#include "cosiva/experiments/positioning/metrology/test_tracks.h"

namespace cosiva::experiments {
namespace {

Candidate candidate(const std::string& name) {
  static const estimation::Registry registry;
  const auto& registered = **registry.find(name);
  return {name, registered.what, registered.backtracks,
          [name](const estimation::Setting& setting) { return registry.make(name, setting); }};
}

struct Fixture {
  Simulation simulation{testing::oval()};
  QualificationOptions options;
  std::size_t runs{12};
  Trial trial;

  Fixture() {
    simulation.distance_m = 40.0;
    simulation.odometry_hz = 17.3;
  }
  Qualification of(const std::vector<Candidate>& candidates) {
    const auto source = [this](std::size_t index, Trial&) -> Result<const Trial*> {
      simulate(simulation, index + 1, trial);
      return &trial;
    };
    auto qualification = qualify(candidates, runs, source, options);
    EXPECT_TRUE(qualification) << to_string(qualification.error());
    return std::move(*qualification);
  }
};

/// Knows the ground truth, which no algorithm can.
class Cheat final : public estimation::Algorithm {
 public:
  explicit Cheat(const Trial& trial) : trial_{trial} {}
  void predict(const estimation::Odometry&) override { ++events_; }
  estimation::Rectified rectify(const estimation::Reading&) override { return {++events_ > 0, std::nullopt, 0}; }
  estimation::Rectified rectify(const estimation::Range&) override { return {++events_ > 0, std::nullopt, 0}; }
  estimation::Estimate estimate() const override {
    for (const Moment& moment : trial_.moments) {
      if (moment.events == events_) return {moment.ground_truth, estimation::Matrix3::Identity(), std::nullopt};
    }
    return {};
  }

 private:
  const Trial& trial_;
  std::size_t events_{0};
};

/// Stops responding after some time.
class Dying final : public estimation::Algorithm {
 public:
  void predict(const estimation::Odometry&) override { ++steps_; }
  estimation::Rectified rectify(const estimation::Reading&) override { return {}; }
  estimation::Rectified rectify(const estimation::Range&) override { return {}; }
  estimation::Estimate estimate() const override { return {{}, estimation::Matrix3::Identity(), std::nullopt}; }
  const Error* fault() const override { return steps_ > 50 ? &fault_ : nullptr; }

 private:
  int steps_{0};
  Error fault_{"algorithm.unresponsive", "no more responses", "dying"};
};

TEST(Qualification, gives_each_metric_with_its_interval_and_the_limit) {
  Fixture fixture;
  const Qualification q = fixture.of({candidate("arc_kalman"), candidate("reset_rule")});
  const Qualified& kalman = q.algorithms[0];
  EXPECT_EQ(kalman.runs.size(), 12U);
  ASSERT_TRUE(kalman.rmse_m.interval);
  EXPECT_LT(kalman.rmse_m.interval->low, kalman.rmse_m.value);
  EXPECT_GT(kalman.rmse_m.interval->high, kalman.rmse_m.value);
  // 8.66 mm along and 2 mm across.
  EXPECT_NEAR(*kalman.limit_m, std::hypot(8.66e-3, 2e-3), 1e-4);
  EXPECT_NEAR(*kalman.gap_percent, 0.0, 10.0);
  EXPECT_FALSE(kalman.leak);
  EXPECT_NEAR(*q.algorithms[1].gap_percent, 27.0, 12.0);
  EXPECT_GT(kalman.precision.value, q.algorithms[1].precision.value);
  EXPECT_NEAR(kalman.mean_m.value * kalman.mean_m.value + kalman.variance_m2, kalman.rmse_m.value * kalman.rmse_m.value,
              1e-12);
  EXPECT_LE(kalman.p50_m, kalman.p90_m);
  EXPECT_LE(kalman.p99_m, kalman.max_m + 1e-6);
  EXPECT_NEAR(kalman.nees, 2.0, 0.3);
  EXPECT_LT(kalman.nees_band.low, 2.0);
  EXPECT_GT(kalman.nees_band.high, 2.0);
  EXPECT_NEAR(kalman.covered[2], 0.95, 0.04);
  // Straight and bent; iterations further from the last beacon have a larger error.
  EXPECT_GT(kalman.by_section[0].iterations, 0U);
  EXPECT_GT(kalman.by_section[1].iterations, 0U);
  EXPECT_EQ(kalman.by_section[2].iterations, 0U);
  EXPECT_GT(kalman.by_distance[2].rmse_m(), kalman.by_distance[0].rmse_m());
}

TEST(Qualification, shows_an_existing_difference_and_ranks) {
  Fixture fixture;
  const Qualification q = fixture.of({candidate("reset_rule"), candidate("arc_kalman"), candidate("arc_smoother")});
  ASSERT_EQ(q.comparisons.size(), 3U);
  for (const Comparison& comparison : q.comparisons) {
    EXPECT_EQ(comparison.verdict, Verdict::different);
    EXPECT_LT(comparison.rmse_difference_m.value, 0.0);
    EXPECT_LT(comparison.rmse_difference_m.interval->high, 0.0);
    EXPECT_NEAR(comparison.p, 2.0 / 4096.0, 1e-12);  // twelve runs of twelve
    EXPECT_GE(comparison.p_holm, comparison.p);
  }
  ASSERT_TRUE(q.ranks);
  EXPECT_EQ(q.ranks->mean_ranks, (std::vector{3.0, 2.0, 1.0}));
}

TEST(Qualification, calls_differences_below_the_reference_s_uncertainty_unresolved) {
  Fixture fixture;
  fixture.options.reference = {{{"floor fit", 0.012, "a file"}, {"time stamp", 0.016, "a file"}}};
  const Qualification q = fixture.of({candidate("reset_rule"), candidate("arc_kalman")});
  EXPECT_EQ(q.comparisons[0].verdict, Verdict::unresolved);
  EXPECT_NEAR(fixture.options.reference.total_m(), 0.02, 1e-15);
  // The same difference, and a reference that resolves it.
  fixture.options.reference = {{{"floor fit", 0.0005, "a file"}}};
  EXPECT_EQ(fixture.of({candidate("reset_rule"), candidate("arc_kalman")}).comparisons[0].verdict, Verdict::different);
}

TEST(Qualification, shows_no_difference_with_five_runs_whatever_their_results) {
  Fixture fixture;
  fixture.runs = 5;
  const Qualification q = fixture.of({candidate("reset_rule"), candidate("arc_kalman")});
  EXPECT_EQ(q.comparisons[0].verdict, Verdict::not_shown_different);
  EXPECT_NEAR(q.comparisons[0].p, 2.0 / 32.0, 1e-12);
  EXPECT_GE(*q.comparisons[0].runs_to_decide, 6U);
}

TEST(Qualification, flags_an_algorithm_that_is_better_than_the_limit) {
  Fixture fixture;
  const Candidate cheat{"cheat", "", false,
                        [&](const estimation::Setting&) -> Result<std::unique_ptr<estimation::Algorithm>> {
                          return std::make_unique<Cheat>(fixture.trial);
                        }};
  const Qualification q = fixture.of({cheat, candidate("arc_kalman")});
  EXPECT_TRUE(q.algorithms[0].leak);
  EXPECT_FALSE(q.algorithms[1].leak);
}

TEST(Qualification, keeps_the_others_results_when_one_fails) {
  Fixture fixture;
  const Candidate dying{"dying", "", false,
                        [](const estimation::Setting&) -> Result<std::unique_ptr<estimation::Algorithm>> {
                          return std::make_unique<Dying>();
                        }};
  const Candidate unborn{"unborn", "", false,
                         [](const estimation::Setting&) -> Result<std::unique_ptr<estimation::Algorithm>> {
                           return fail("algorithm.start", "no");
                         }};
  const Qualification q = fixture.of({dying, candidate("arc_kalman"), unborn, candidate("reset_rule")});
  EXPECT_EQ(q.algorithms[0].failed->code, "algorithm.unresponsive");
  EXPECT_NE(q.algorithms[0].failed->message.find("in run 1"), std::string::npos);
  EXPECT_EQ(q.algorithms[2].failed->code, "algorithm.start");
  EXPECT_FALSE(q.algorithms[1].failed);
  ASSERT_EQ(q.comparisons.size(), 1U);
  EXPECT_EQ(q.comparisons[0].a, 1U);
  EXPECT_EQ(q.comparisons[0].b, 3U);
}

TEST(QualificationStatistics, is_the_same_to_the_bit_for_the_same_seeds) {
  Fixture fixture;
  fixture.runs = 3;
  const Digest one = fixture.of({candidate("ekf"), candidate("smoother"), candidate("particles")}).digest;
  EXPECT_EQ(fixture.of({candidate("ekf"), candidate("smoother"), candidate("particles")}).digest, one);
  fixture.simulation.sensors.fiducial_along_sigma_m = 0.011;
  EXPECT_NE(fixture.of({candidate("ekf"), candidate("smoother"), candidate("particles")}).digest, one);
}

/// Runs the last part first, as a machine with many threads might.
class Backwards final : public Workers {
 protected:
  void run(std::size_t count, Call call, void* context) override {
    while (count > 0) call(context, --count);
  }
};

/// Fails at once, or never.
class DyingSometimes final : public estimation::Algorithm {
 public:
  explicit DyingSometimes(bool dies) : dies_{dies} {}
  void predict(const estimation::Odometry&) override {}
  estimation::Rectified rectify(const estimation::Reading&) override { return {}; }
  estimation::Rectified rectify(const estimation::Range&) override { return {}; }
  estimation::Estimate estimate() const override { return {{}, estimation::Matrix3::Identity(), std::nullopt}; }
  const Error* fault() const override { return dies_ ? &fault_ : nullptr; }

 private:
  bool dies_;
  Error fault_{"algorithm.unresponsive", "no more responses", "dying"};
};

struct Apart {
  Simulation simulation{testing::oval()};
  std::size_t runs{};
  std::vector<std::size_t> progress;

  Result<Qualification> by(Workers& workers, const std::vector<Candidate>& candidates, std::size_t no_such_run = 1000) {
    simulation.distance_m = 4.0;
    simulation.odometry_hz = 17.3;
    progress.clear();
    const auto source = [this, no_such_run](std::size_t index, Trial& room) -> Result<const Trial*> {
      if (index >= no_such_run) return fail("run.missing", "there is no run " + std::to_string(index + 1));
      simulate(simulation, index + 1, room);
      return &room;
    };
    // Time is up after every third part.
    return qualify(
        candidates, runs, source, {}, workers, [requested = std::make_shared<int>(0)] { return ++*requested % 3 == 0; },
        [this](std::size_t done) { progress.push_back(done); });
  }
};

TEST(Qualification, does_not_depend_on_the_order_of_parts) {
  AloneWorker alone;
  Backwards backwards;
  const std::vector<Candidate> candidates{candidate("reset_rule"), candidate("arc_kalman"), candidate("arc_smoother")};
  for (const std::size_t runs : {1U, 5U, 15U, 16U, 40U, 200U}) {
    Apart apart;
    apart.runs = runs;
    const auto forwards = apart.by(alone, candidates);
    EXPECT_EQ(apart.progress.back(), runs);
    EXPECT_TRUE(std::ranges::is_sorted(apart.progress));
    EXPECT_GE(apart.progress.size(), runs > 1 ? 2U : 1U);
    const auto other = apart.by(backwards, candidates);
    ASSERT_TRUE(forwards && other);
    EXPECT_EQ(to_json(*forwards, {}), to_json(*other, {})) << runs;
    EXPECT_EQ(forwards->ground_truth, other->ground_truth) << runs;
    EXPECT_EQ(forwards->algorithms[2].path, other->algorithms[2].path) << runs;
    EXPECT_EQ(forwards->algorithms[1].runs.size(), runs);
  }
}

TEST(Qualification, names_the_first_run_in_which_a_candidate_failed_whatever_the_order_of_parts) {
  AloneWorker alone;
  Backwards backwards;
  for (const std::size_t runs : {12U, 40U}) {
    Apart apart;
    apart.runs = runs;
    // Seeds are run numbers: the candidate fails from the fifth on.
    const Candidate dying{"dying", "", false,
                          [](const estimation::Setting& setting) -> Result<std::unique_ptr<estimation::Algorithm>> {
                            return std::make_unique<DyingSometimes>(setting.seed >= 5);
                          }};
    const auto forwards = apart.by(alone, {dying, candidate("arc_kalman")});
    const auto other = apart.by(backwards, {dying, candidate("arc_kalman")});
    ASSERT_TRUE(forwards && other);
    EXPECT_NE(forwards->algorithms[0].failed->message.find("(in run 5)"), std::string::npos);
    EXPECT_EQ(to_json(*forwards, {}), to_json(*other, {}));
    EXPECT_EQ(forwards->algorithms[1].runs.size(), runs);
    EXPECT_EQ(apart.by(alone, {dying, candidate("arc_kalman")}, 7).error().message, "there is no run 8");
    EXPECT_EQ(apart.by(backwards, {dying, candidate("arc_kalman")}, 7).error().message, "there is no run 8");
  }
}

TEST(Qualification, is_the_same_to_the_bit_on_every_machine_and_at_every_optimisation_level) {
  Fixture fixture;
  fixture.runs = 2;
  fixture.simulation.distance_m = 10.0;
  std::vector<Candidate> all;
  const estimation::Registry registry;
  for (const estimation::Registered& one : registry.all()) all.push_back(candidate(one.name));
  EXPECT_EQ(fixture.of(all).digest.hex(), "a98515c403e614ca");
}

TEST(Qualification, aligned_removes_the_common_error_of_a_run_and_gives_no_limit) {
  Fixture fixture;
  fixture.runs = 6;
  const Qualified plain = fixture.of({candidate("arc_kalman")}).algorithms[0];
  fixture.options.alignment = Alignment::se2;
  const Qualification q = fixture.of({candidate("arc_kalman"), candidate("dead_reckoning")});
  const Qualified& aligned = q.algorithms[0];
  EXPECT_TRUE(plain.alignments.empty());
  ASSERT_EQ(aligned.alignments.size(), 6U);
  EXPECT_FALSE(aligned.limit_m);
  EXPECT_FALSE(aligned.leak);
  // Least squares: never worse, run by run; and aligned estimates are evaluated at their new position.
  for (std::size_t i = 0; i < 6; ++i) EXPECT_LE(aligned.runs[i].mse_m2, plain.runs[i].mse_m2);
  EXPECT_LT(aligned.rmse_m.value, plain.rmse_m.value);
  double squares = 0.0;
  for (std::size_t k = 0; k < aligned.path.size(); ++k) {
    const double error_m = distance(aligned.path[k], q.ground_truth[k]);
    squares += error_m * error_m / static_cast<double>(aligned.path.size());
    const Pose2 back = inverse(aligned.alignments[0]) * aligned.path[k];
    EXPECT_LT(distance(back, plain.path[k]), 1e-12);
  }
  EXPECT_NEAR(squares, aligned.runs[0].mse_m2, 1e-15);
  // A stated covariance is turned with its estimate: its agreement hardly changes by millimetres.
  EXPECT_NEAR(aligned.nees, plain.nees, 0.4);
}

TEST(Qualification, aligned_at_the_origin_begins_without_an_error_and_needs_a_heading) {
  Fixture fixture;
  fixture.runs = 1;
  fixture.options.alignment = Alignment::origin;
  const Qualification q = fixture.of({candidate("dead_reckoning")});
  EXPECT_LT(distance(q.algorithms[0].path[0], q.ground_truth[0]), 1e-12);
  const auto source = [&](std::size_t index, Trial& room) -> Result<const Trial*> {
    simulate(fixture.simulation, index + 1, room);
    room.heading_known = false;
    return &room;
  };
  const auto headless = qualify({candidate("dead_reckoning")}, 1, source, fixture.options);
  ASSERT_TRUE(headless);
  EXPECT_EQ(headless->algorithms[0].failed->code, "align.heading");
}

TEST(Qualification, counts_consecutive_passes_and_the_tolerance_that_all_would_pass) {
  Fixture fixture;
  fixture.options.tolerance_m = 1.0;
  const Passes all = fixture.of({candidate("arc_kalman")}).algorithms[0].passes;
  EXPECT_EQ(all.passed, 12U);
  EXPECT_EQ(all.in_a_row, 12U);
  EXPECT_EQ(all.needed, 59U);
  EXPECT_NEAR(all.reliability_shown, std::pow(0.05, 1.0 / 12.0), 1e-12);
  fixture.options.tolerance_m = 1e-4;
  EXPECT_EQ(fixture.of({candidate("arc_kalman")}).algorithms[0].passes.passed, 0U);
  EXPECT_GT(all.tolerance_passed_m, 0.01);
}

}  // namespace
}  // namespace cosiva::experiments
