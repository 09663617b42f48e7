// How often the intervals and bounds of an autonomy test contain the true value, over simulated fleets of known ground
// truth: without and with vehicles that fail before their batteries do. Goal: nominal ± 1 percent.
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/app/cli/options.h"
#include "cosiva/base/math.h"
#include "cosiva/base/random.h"
#include "cosiva/experiments/statistics/distributions.h"
#include "cosiva/experiments/statistics/interval.h"
#include "cosiva/experiments/statistics/sample.h"
#include "cosiva/experiments/statistics/survival.h"
#include "cosiva/experiments/statistics/tolerance.h"

namespace {

using namespace cosiva;

struct Options {
  std::size_t fleets{2000};
  std::size_t size{12};
  double mean_s{3600.0};
  double sd_s{50.0};
  double failing{0.2};
  std::uint64_t seed{1};
  bool json{false};
};

struct Count {
  const char* name;
  std::size_t held{0};
  std::size_t requested{0};
  void send_request(bool holds) {
    ++requested;
    held += holds ? 1 : 0;
  }
};

bool holds(const statistics::Interval& interval, double ground_truth) {
  return interval.low <= ground_truth && ground_truth <= interval.high;
}

/// Batteries one after another until the mean is known to this ratio of it, as `--half-width` stops.
void stop_early(Random& random, const Options& options, double ratio, Count& within, Count& interval) {
  constexpr std::size_t longest = 2000;
  std::vector<double> ends;
  std::optional<std::size_t> stopped;
  while (!stopped && ends.size() < longest) {
    ends.push_back(random.gaussian(options.mean_s, options.sd_s));
    // Only the last evaluation is new: the earlier ones did not stop the test.
    stopped = statistics::stops_at(ends, ratio, std::max<std::size_t>(5, ends.size()));
  }
  if (!stopped) return;
  const double found_s = statistics::mean(ends);
  within.send_request(std::fabs(found_s - options.mean_s) <= ratio * found_s);
  interval.send_request(holds(*statistics::mean_interval(ends), options.mean_s));
}

int measure(const Options& options) {
  Random random{options.seed, "bench/autonomy"};
  const double fifth_s = options.mean_s + options.sd_s * statistics::normal_quantile(0.05);
  const double factor = statistics::tolerance_factor(options.size);
  // Failures as of radioactive atoms: this part of the fleet has failed by the time that its batteries end.
  const double hazard = std::fabs(det_log(1.0 - options.failing)) / options.mean_s;
  Count counts[] = {{"mean, t"},
                    {"mean, BCa"},
                    {"SD, chi squared"},
                    {"tolerance 95/95"},
                    {"prediction of one"},
                    {"censored: mean"},
                    {"censored: 95/95"},
                    {"censored: KM band at the mean"},
                    {"censored: counted as ends (wrong)"},
                    {"censored: KM band, 10 to 90 %"},
                    {"censored: KM log-log band, 10 to 90 %"},
                    {"sequential stop at 1 %: within 1 %"},
                    {"sequential stop at 1 %: mean, t"},
                    {"sequential stop at 0.5 %: within it"},
                    {"sequential stop at 0.5 %: mean, t"}};
  for (std::size_t fleet = 0; fleet < options.fleets; ++fleet) {
    std::vector<double> ends;
    std::vector<statistics::Duration> durations;
    std::vector<double> naive;
    for (std::size_t i = 0; i < options.size; ++i) {
      const double end_s = random.gaussian(options.mean_s, options.sd_s);
      const double failure_s = -det_log(1.0 - random.uniform()) / hazard;
      ends.push_back(end_s);
      durations.push_back({std::fmin(end_s, failure_s), end_s <= failure_s});
      naive.push_back(durations.back().value);
    }
    counts[0].send_request(holds(*statistics::mean_interval(ends), options.mean_s));
    counts[1].send_request(holds(*statistics::bca(ends, {0.95, 2000, fleet + 1}), options.mean_s));
    counts[2].send_request(holds(*statistics::deviation_interval(ends), options.sd_s));
    const double low_s = statistics::mean(ends) - factor * std::sqrt(statistics::sample_variance(ends));
    counts[3].send_request(low_s <= fifth_s);
    counts[4].send_request(
        holds(*statistics::prediction_interval(ends), random.gaussian(options.mean_s, options.sd_s)));
    if (const auto fit = statistics::censored_normal(durations)) {
      counts[5].send_request(holds(fit->mean_interval, options.mean_s));
      counts[6].send_request(fit->tolerance_low <= fifth_s);
    }
    const statistics::Survival curve = statistics::kaplan_meier(durations);
    counts[7].send_request(holds(curve.band_at(options.mean_s), 0.5));
    counts[8].send_request(holds(*statistics::mean_interval(naive), options.mean_s));
    const statistics::Survival usual = statistics::kaplan_meier(durations, 0.95, statistics::SurvivalBand::log_log);
    for (const double ratio : {0.9, 0.75, 0.5, 0.25, 0.1}) {
      const double then_s = options.mean_s + options.sd_s * statistics::normal_quantile(1.0 - ratio);
      counts[9].send_request(holds(curve.band_at(then_s), ratio));
      counts[10].send_request(holds(usual.band_at(then_s), ratio));
    }
  }
  // Another random stream, so that the rows above do not depend on these.
  Random one_by_one{options.seed, "bench/autonomy/sequential"};
  for (std::size_t test = 0; test < options.fleets; ++test) {
    stop_early(one_by_one, options, 0.01, counts[11], counts[12]);
    stop_early(one_by_one, options, 0.005, counts[13], counts[14]);
  }
  if (options.json) std::printf("{\"fleets\":%zu,\"size\":%zu,\"coverage\":{", options.fleets, options.size);
  for (const Count& count : counts) {
    const double ratio =
        count.requested == 0 ? 0.0 : static_cast<double>(count.held) / static_cast<double>(count.requested);
    const bool last = &count == counts + std::size(counts) - 1;
    if (options.json)
      std::printf("\"%s\":%.4f%s", count.name, ratio, last ? "}}\n" : ",");
    else
      std::printf("%-36s %6.2f %%  of %zu\n", count.name, 100.0 * ratio, count.requested);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  Options options;
  const cosiva::app::CommandLine line{"Counts how often the results of an autonomy test are true"};
  const cosiva::app::Command command = line.root();
  command.add_option("--fleets", options.fleets, "Simulated fleets").show_default().in_range(1, 1'000'000);
  command.add_option("--size", options.size, "Batteries in each").show_default().in_range(3, 10'000);
  command.add_option("--sd", options.sd_s, "Standard deviation of the batteries, of 3600 s").show_default();
  command.add_option("--failing", options.failing, "Ratio of vehicles that fail first")
      .show_default()
      .in_range(0.0, 0.9);
  command.add_option("--seed", options.seed, "Seed of the run").show_default();
  command.add_flag("--json", options.json, "Print the metrics as JSON");
  if (const auto status = line.parse(argc, argv)) return *status;
  return measure(options);
}
