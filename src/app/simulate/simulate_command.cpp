#include "cosiva/app/simulate/simulate_command.h"

#include <algorithm>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "cosiva/adapters/thread_pool.h"
#include "cosiva/app/cli/console.h"
#include "cosiva/app/cli/progress.h"
#include "cosiva/app/cli/seed_range.h"
#include "cosiva/app/resources/zone_files.h"
#include "cosiva/app/simulate/seed_report.h"
#include "cosiva/base/expect.h"
#include "cosiva/experiments/faults/fault_schedule.h"
#include "cosiva/experiments/faults/fault_simulation.h"
#include "cosiva/experiments/faults/shrink.h"
#include "cosiva/experiments/faults/two_areas.h"

namespace cosiva::app {
namespace {

using experiments::FaultSimulationOptions;
using experiments::FaultSimulationResult;

Result<FaultSimulationOptions> options_of(const SimulateArguments& arguments) {
  FaultSimulationOptions options;
  if (arguments.handovers) options.areas = experiments::two_areas();
  auto zone = options.areas ? zone::Rtm::initialise(options.areas->floor) : open_zone(arguments.zone);
  if (!zone) return tl::unexpected<Error>(zone.error());
  options.rtm = std::make_shared<const zone::Rtm>(std::move(*zone));
  if (!arguments.other_zone.empty()) {
    const auto other = open_zone(arguments.other_zone);
    if (!other) return tl::unexpected<Error>(other.error());
    options.other_zone = other->configuration();
  }
  options.aivs = arguments.aivs;
  options.duration = from_seconds(60.0 * arguments.minutes);
  if (!arguments.plant.empty()) {
    const auto planted = experiments::parse_planted(arguments.plant);
    if (!planted)
      return fail("simulate.plant", "there is no defect '" + arguments.plant + "'; `cosiva simulate --help` lists them",
                  "--plant");
    if (experiments::concerns_handovers(*planted) && !options.areas)
      return fail("simulate.plant", "the defect '" + arguments.plant + "' needs --handovers", "--plant");
    options.planted = *planted;
  }
  if (!arguments.faults.empty()) options.only = arguments.faults;
  return options;
}

/// Runs the seeds a block at a time, and reports each block in the order of its seeds.
///
/// Invariant: seeds are reported in ascending order, each once.
class SeedRunner {
 public:
  SeedRunner(const SimulateArguments& arguments, FaultSimulationOptions options)
      : arguments_{arguments},
        options_{std::move(options)},
        pool_{arguments.jobs > 0 ? arguments.jobs : std::max(1U, std::thread::hardware_concurrency())} {}

  int run(SeedRange seeds) {
    const std::uint64_t count = seeds.count();
    for (std::uint64_t from = 0; from < count; from += block_) {
      std::vector<Result<FaultSimulationResult>> results(std::min(block_, count - from));
      pool_.for_each(results.size(), [&](std::size_t i) {
        results[i] = experiments::simulate_faults(seeds.first + from + i, options_);
      });
      for (const auto& result : results) {
        if (!result) return report_error(result.error());
        COSIVA_EXPECT(result->seed == seeds.first + totals_.seeds);
        report(*result);
      }
      if (ticker_.ticks())
        print_info(std::to_string(totals_.seeds) + " of " + std::to_string(count) + " seeds, " +
                   std::to_string(totals_.failed) + " failed");
    }
    print_info(totals_text(totals_));
    return totals_.failed == 0 ? exit_done : exit_check_failed;
  }

 private:
  void report(const FaultSimulationResult& result) {
    add(totals_, result);
    if (arguments_.json)
      print(seed_json(result, replay_command(arguments_, result, {})));
    else if (result.violation || totals_.seeds <= 20)
      print(seed_text(result));
    if (!result.violation) return;
    print_info(failure_text(result) + "\n  replay: " + replay_command(arguments_, result, {}));
    if (arguments_.shrink) shrink_seed(result);
  }

  void shrink_seed(const FaultSimulationResult& result) {
    SecondsTicker ticker;
    const auto shrunk = experiments::shrink(result, options_, [&](std::size_t left) {
      if (ticker.ticks()) print_info("  shrinking: " + std::to_string(left) + " faults left");
    });
    if (!shrunk) return print_info("  " + to_string(shrunk.error()));
    std::string text = "  shrunk to " + std::to_string(shrunk->numbers.size()) + " of " +
                       std::to_string(result.faults.size()) + " faults in " + std::to_string(shrunk->runs) + " runs:";
    for (const experiments::Fault& fault : shrunk->result.faults) text += "\n    " + to_string(fault);
    print_info(text + "\n" + failure_text(shrunk->result) +
               "\n  replay: " + replay_command(arguments_, result, shrunk->numbers));
  }

  const SimulateArguments& arguments_;
  FaultSimulationOptions options_;
  adapters::ThreadPool pool_;
  std::uint64_t block_{std::max<std::uint64_t>(8, 4 * pool_.threads())};
  SeedTotals totals_;
  SecondsTicker ticker_;
};

int list_schedules(const FaultSimulationOptions& options, SeedRange seeds) {
  for (std::uint64_t seed = seeds.first; seed <= seeds.last; ++seed) {
    print("seed " + std::to_string(seed));
    for (const experiments::Fault& fault : experiments::fault_schedule_of(seed, options))
      print("  " + to_string(fault));
  }
  return exit_done;
}

}  // namespace

int run_simulate(const SimulateArguments& arguments) {
  const auto seeds = read_seed_range(arguments.seeds, "--seeds", "simulate.seeds");
  if (!seeds) return report_error(seeds.error());
  auto options = options_of(arguments);
  if (!options) return report_error(options.error());
  if (arguments.list) return list_schedules(*options, *seeds);
  return SeedRunner{arguments, std::move(*options)}.run(*seeds);
}

}  // namespace cosiva::app
