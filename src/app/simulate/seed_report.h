#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "cosiva/app/simulate/simulate_arguments.h"
#include "cosiva/experiments/faults/fault_simulation.h"

namespace cosiva::app {

/// Sums over the seeds so far.
struct SeedTotals {
  std::uint64_t seeds{};
  std::uint64_t failed{};
  experiments::FaultCounts faults{};
  std::uint64_t accepted{};
  std::uint64_t handovers{};
  double simulated_s{};
  double fresh_after_s_max{};
  double driving_after_s_max{};
};
void add(SeedTotals& totals, const experiments::FaultSimulationResult& result);

/// "seed 7: holds, digest 0123…, 68.3 s, 18 commands accepted; F1 weather 2, F3 crash 4, …".
[[nodiscard]] std::string seed_text(const experiments::FaultSimulationResult& result);
[[nodiscard]] std::string seed_json(const experiments::FaultSimulationResult& result, const std::string& replay);
/// What was violated, when, in which version; of a result with a violation (checked).
[[nodiscard]] std::string failure_text(const experiments::FaultSimulationResult& result);
[[nodiscard]] std::string totals_text(const SeedTotals& totals);
/// The command line that runs one seed again, with these faults only where there are any.
[[nodiscard]] std::string replay_command(const SimulateArguments& arguments,
                                         const experiments::FaultSimulationResult& result,
                                         const std::vector<std::uint32_t>& faults);

}  // namespace cosiva::app
