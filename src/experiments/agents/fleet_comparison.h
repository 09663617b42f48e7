#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/workers.h"
#include "cosiva/experiments/agents/fleet_run.h"
#include "cosiva/experiments/statistics/interval.h"

namespace cosiva::experiments {

/// Runs of crisp rules and of other rules, in pairs with equal seeds.
struct FleetPlan {
  std::shared_ptr<const zone::Rtm> rtm;  ///< not null (checked)
  aiv::SpeedRules rules;                 ///< compared with the crisp ones
  std::vector<std::uint32_t> vehicles{4, 12, 24};
  std::vector<std::uint32_t> persons{0, 2};
  std::uint64_t first_seed{1};
  std::uint64_t last_seed{20};  ///< >= first_seed + 1 (checked): one pair has no interval
  SimDuration duration{std::chrono::minutes{10}};
};

/// A quantity in all pairs of a case: the means, and the mean difference rules − crisp with its 95 % interval
/// (Student's t over the pairs).
struct PairedMean {
  double crisp{};
  double rules{};
  double difference{};
  statistics::Interval interval;

  [[nodiscard]] bool less() const { return interval.high < 0.0; }  ///< shown at 95 %
  [[nodiscard]] bool more() const { return interval.low > 0.0; }
  /// In percent of the crisp mean; 0 where that is 0.
  [[nodiscard]] double percent() const { return crisp > 0.0 ? 100.0 * difference / crisp : 0.0; }
};

/// The pairs with one number of vehicles and one of persons.
struct FleetCase {
  std::uint32_t vehicles{};
  std::uint32_t persons{};
  std::vector<FleetRun> crisp;  ///< in the order of the seeds
  std::vector<FleetRun> rules;  ///< as many

  [[nodiscard]] PairedMean laps() const;
  [[nodiscard]] PairedMean stops() const;
  [[nodiscard]] PairedMean stopped_s() const;
  [[nodiscard]] PairedMean creeping_s() const;
  [[nodiscard]] PairedMean energy_kj() const;
  [[nodiscard]] PairedMean energy_per_lap_kj() const;
  [[nodiscard]] std::uint64_t collisions() const;
};

/// "24 AIVs, undisturbed".
[[nodiscard]] std::string name_of(const FleetCase& fleet_case);
/// All quantities of a case with their names, in the order of the reports.
[[nodiscard]] std::vector<std::pair<std::string, PairedMean>> quantities_of(const FleetCase& fleet_case);

struct FleetComparison {
  std::vector<FleetCase> cases;
  std::string digest;  ///< of all runs: the same for the same plan, on any number of threads
};

/// @param progress  called with the numbers of finished and of all runs, from time to time
/// Fails as run_fleet().
[[nodiscard]] Result<FleetComparison> compare_fleets(
    const FleetPlan& plan, Workers& workers, const std::function<void(std::size_t, std::size_t)>& progress = {});

/// What is required of the rules: in each case no fewer laps and no more stops than with the crisp rules (not shown at
/// 95 %), no collision, and in the cases with the most vehicles this many percent fewer stops.
/// Empty: the comparison meets the requirement. Else one sentence for each violation.
[[nodiscard]] std::vector<std::string> violations_of(const FleetComparison& comparison, double fewer_stops_percent);

void write_json(JsonWriter& json, const FleetPlan& plan, const FleetComparison& comparison);
[[nodiscard]] std::string to_text(const FleetPlan& plan, const FleetComparison& comparison);

}  // namespace cosiva::experiments
