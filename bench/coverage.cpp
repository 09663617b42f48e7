// Coverage of the statistics: campaigns of simulated qualifications with known ground truth. Counts how often a
// run-level interval contains the true value, how often identical algorithms are reported as different, and how often a
// real difference is found with as many runs as were announced for it.
#include <cmath>
#include <cstdio>
#include <vector>

#include "bench/zones.h"
#include "cosiva/aiv/estimation/registry.h"
#include "cosiva/app/cli/options.h"
#include "cosiva/experiments/positioning/metrology/metrics.h"
#include "cosiva/experiments/positioning/metrology/simulate.h"
#include "cosiva/experiments/statistics/interval.h"
#include "cosiva/experiments/statistics/paired.h"
#include "cosiva/experiments/statistics/sample.h"

namespace {

using namespace cosiva;
using experiments::RunMetrics;

/// Metrics of one algorithm on one run; only the run number differs.
class Laboratory {
 public:
  Laboratory() {
    simulation_.distance_m = 20.0;
    simulation_.odometry_hz = 11.0;
    simulation_.turns = false;
  }
  RunMetrics run(const char* algorithm, std::uint64_t number) {
    experiments::simulate(simulation_, number, trial_);
    auto made = registry_.make(algorithm, trial_.setting);
    (void)experiments::apply(**made, trial_, trace_);
    return experiments::metrics_of(trial_, trace_, 0.01);
  }

 private:
  experiments::Simulation simulation_{fixture::lacet4_track()};
  estimation::Registry registry_;
  experiments::Trial trial_;
  experiments::Trace trace_;
};

struct GroundTruth {
  double rmse_m, mean_m, precision;
};

GroundTruth ground_truth_of(Laboratory& laboratory, std::size_t runs) {
  double squares = 0.0;
  GroundTruth ground_truth{};
  for (std::size_t i = 0; i < runs; ++i) {
    const RunMetrics f = laboratory.run("arc_kalman", 1'000'000'000 + i);
    squares += f.mse_m2;
    ground_truth.mean_m += f.mean_m / static_cast<double>(runs);
    ground_truth.precision += f.precision / static_cast<double>(runs);
  }
  ground_truth.rmse_m = std::sqrt(squares / static_cast<double>(runs));
  return ground_truth;
}

bool holds(const std::vector<double>& runs, double ground_truth, std::uint64_t seed) {
  const auto interval = statistics::bca(runs, {0.95, 2000, seed});
  return interval && interval->low <= ground_truth && ground_truth <= interval->high;
}

}  // namespace

int main(int argc, char** argv) {
  const cosiva::app::CommandLine line{
      "Counts how often intervals contain the true value and tests raise a false alarm"};
  const cosiva::app::Command command = line.root();
  std::size_t campaigns = 1000;
  std::size_t runs = 20;
  std::size_t ground_truth_runs = 20'000;
  command.add_option("--campaigns", campaigns);
  command.add_option("--runs", runs, "in each");
  command.add_option("--ground-truth-runs", ground_truth_runs, "that the ground truth is taken from");
  if (const auto status = line.parse(argc, argv)) return *status;

  Laboratory laboratory;
  const GroundTruth ground_truth = ground_truth_of(laboratory, ground_truth_runs);
  std::size_t rmse = 0;
  std::size_t mean = 0;
  std::size_t precision = 0;
  std::size_t alarms = 0;
  std::size_t outside = 0;
  std::size_t decided = 0;
  // A pilot study determines how many runs a real difference takes.
  std::vector<double> pilot;
  for (std::uint64_t i = 0; i < 400; ++i)
    pilot.push_back(std::sqrt(laboratory.run("ufir", 2'000'000'000 + i).mse_m2) -
                    std::sqrt(laboratory.run("arc_kalman", 2'000'000'000 + i).mse_m2));
  const std::size_t needed = statistics::runs_to_decide(pilot).value_or(6);
  std::uint64_t number = 1;
  std::uint64_t other = 3'000'000'000;
  for (std::size_t campaign = 1; campaign <= campaigns; ++campaign) {
    std::vector<double> mses;
    std::vector<double> means;
    std::vector<double> precisions;
    std::vector<double> differences;
    std::vector<double> real;
    for (std::size_t i = 0; i < runs; ++i) {
      const RunMetrics f = laboratory.run("arc_kalman", number++);
      mses.push_back(f.mse_m2);
      means.push_back(f.mean_m);
      precisions.push_back(f.precision);
      // The same algorithm under another name, with noise of its own.
      differences.push_back(std::sqrt(laboratory.run("arc_kalman", number++).mse_m2) - std::sqrt(f.mse_m2));
    }
    for (std::size_t i = 0; i < needed; ++i, ++other)
      real.push_back(std::sqrt(laboratory.run("ufir", other).mse_m2) -
                     std::sqrt(laboratory.run("arc_kalman", other).mse_m2));
    rmse += holds(mses, ground_truth.rmse_m * ground_truth.rmse_m, campaign) ? 1U : 0U;
    mean += holds(means, ground_truth.mean_m, campaign) ? 1U : 0U;
    precision += holds(precisions, ground_truth.precision, campaign) ? 1U : 0U;
    outside += holds(differences, 0.0, campaign) ? 0U : 1U;
    alarms += statistics::wilcoxon(differences) < 0.05 ? 1U : 0U;
    decided += statistics::wilcoxon(real) < 0.05 ? 1U : 0U;
  }
  const auto percent = [&](std::size_t n) { return 100.0 * static_cast<double>(n) / static_cast<double>(campaigns); };
  std::printf(
      "%zu campaigns of %zu runs; 95 %% intervals contain the true value: rmse %.1f %%, mean %.1f %%, precision %.1f "
      "%%\n",
      campaigns, runs, percent(rmse), percent(mean), percent(precision));
  std::printf("identical algorithms: reported as different %.1f %%, interval of the difference excluding 0 %.1f %%\n",
              percent(alarms), percent(outside));
  std::printf("arc_kalman against ufir: %zu runs announced for 80 %%, shown different in %.1f %%\n", needed,
              percent(decided));
  return 0;
}
