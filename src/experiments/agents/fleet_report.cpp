#include "cosiva/experiments/agents/fleet_report.h"

#include <utility>
#include <vector>

#include "cosiva/experiments/agents/fixed_text.h"
#include "cosiva/experiments/reporting/report.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::experiments {
namespace {

std::vector<std::string> row_of(const std::string& name, const PairedMean& mean) {
  return {name,
          fixed_text(mean.crisp, 2),
          fixed_text(mean.rules, 2),
          fixed_text(mean.difference, 2),
          fixed_text(mean.interval.low, 2) + " to " + fixed_text(mean.interval.high, 2),
          fixed_text(mean.percent(), 2)};
}

}  // namespace

std::string to_html(const FleetPlan& plan, const FleetComparison& comparison, double fewer_stops_percent,
                    const std::string& command) {
  const std::vector<std::string> violations = violations_of(comparison, fewer_stops_percent);
  std::uint64_t collisions = 0;
  for (const FleetCase& fleet_case : comparison.cases) collisions += fleet_case.collisions();
  Report report{"Rules of agents against the crisp rules", plan.rtm->zone().name};
  report.metadata({{std::to_string(plan.last_seed - plan.first_seed + 1), "pairs of runs per case"},
                   {fixed_text(to_seconds(plan.duration) / 60.0, 1) + " min", "each run, at the live cycle"},
                   {std::to_string(collisions), "collisions", collisions > 0},
                   {std::to_string(violations.size()), "violations", !violations.empty()}});
  report.paragraph(
      "Means per run of whole fleets. The difference is rules minus crisp rules, with the 95 % interval of the paired "
      "differences. A stop is a change from at least 5 cm/s to less than 1 cm/s; creeping is the time between these "
      "speeds.");
  for (const std::string& violation : violations) report.paragraph(violation);
  for (const FleetCase& fleet_case : comparison.cases) {
    report.heading(name_of(fleet_case) + ", " + std::to_string(fleet_case.collisions()) + " collisions");
    std::vector<std::vector<std::string>> rows;
    for (const auto& [name, mean] : quantities_of(fleet_case)) rows.push_back(row_of(name, mean));
    report.table({"quantity", "crisp", "rules", "difference", "95 % interval", "%"}, rows);
  }
  report.heading("Repeat");
  report.verbatim(command + "\n\ndigest of all runs " + comparison.digest);
  return report.html();
}

}  // namespace cosiva::experiments
