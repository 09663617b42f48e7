#include "cosiva/experiments/agents/fleet_comparison.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <utility>

#include "cosiva/base/digest.h"
#include "cosiva/base/expect.h"
#include "cosiva/experiments/agents/fixed_text.h"
#include "cosiva/experiments/statistics/tolerance.h"

namespace cosiva::experiments {
namespace {

/// Runs between two reports of the progress; a multiple of usual numbers of processors.
constexpr std::size_t block = 16;

template <typename Of>
PairedMean paired(const FleetCase& fleet_case, const Of& of) {
  const std::size_t pairs = fleet_case.crisp.size();
  COSIVA_EXPECT(pairs >= 2 && fleet_case.rules.size() == pairs);
  PairedMean mean;
  std::vector<double> differences;
  for (std::size_t i = 0; i < pairs; ++i) {
    const double crisp = of(fleet_case.crisp[i]);
    const double rules = of(fleet_case.rules[i]);
    mean.crisp += crisp / static_cast<double>(pairs);
    mean.rules += rules / static_cast<double>(pairs);
    differences.push_back(rules - crisp);
  }
  mean.difference = std::accumulate(differences.begin(), differences.end(), 0.0) / static_cast<double>(pairs);
  mean.interval = statistics::mean_interval(differences).value_or(statistics::Interval{});
  return mean;
}

using Column = std::pair<const char*, PairedMean (FleetCase::*)() const>;
constexpr std::array<Column, 6> all_columns{{{"laps", &FleetCase::laps},
                                             {"stops", &FleetCase::stops},
                                             {"stopped_s", &FleetCase::stopped_s},
                                             {"creeping_s", &FleetCase::creeping_s},
                                             {"energy_kj", &FleetCase::energy_kj},
                                             {"energy_per_lap_kj", &FleetCase::energy_per_lap_kj}}};

}  // namespace

std::string name_of(const FleetCase& fleet_case) {
  return std::to_string(fleet_case.vehicles) + " AIVs, " +
         (fleet_case.persons == 0 ? std::string{"undisturbed"} : std::to_string(fleet_case.persons) + " persons");
}

std::vector<std::pair<std::string, PairedMean>> quantities_of(const FleetCase& fleet_case) {
  std::vector<std::pair<std::string, PairedMean>> quantities;
  quantities.reserve(all_columns.size());
  for (const auto& [name, of] : all_columns) quantities.emplace_back(name, (fleet_case.*of)());
  return quantities;
}

PairedMean FleetCase::laps() const {
  return paired(*this, [](const FleetRun& run) { return run.laps; });
}
PairedMean FleetCase::stops() const {
  return paired(*this, [](const FleetRun& run) { return static_cast<double>(run.stops); });
}
PairedMean FleetCase::stopped_s() const {
  return paired(*this, [](const FleetRun& run) { return run.stopped_s; });
}
PairedMean FleetCase::creeping_s() const {
  return paired(*this, [](const FleetRun& run) { return run.creeping_s; });
}
PairedMean FleetCase::energy_kj() const {
  return paired(*this, [](const FleetRun& run) { return run.energy_kj; });
}
PairedMean FleetCase::energy_per_lap_kj() const {
  return paired(*this, [](const FleetRun& run) { return run.laps > 0.0 ? run.energy_kj / run.laps : 0.0; });
}

std::uint64_t FleetCase::collisions() const {
  std::uint64_t sum = 0;
  for (const auto* runs : {&crisp, &rules})
    for (const FleetRun& run : *runs) sum += run.collisions;
  return sum;
}

Result<FleetComparison> compare_fleets(const FleetPlan& plan, Workers& workers,
                                       const std::function<void(std::size_t, std::size_t)>& progress) {
  COSIVA_EXPECT(plan.rtm && plan.last_seed > plan.first_seed);
  const std::size_t seeds = plan.last_seed - plan.first_seed + 1;
  FleetComparison comparison;
  std::vector<FleetRunOptions> all;
  for (const std::uint32_t persons : plan.persons)
    for (const std::uint32_t vehicles : plan.vehicles) {
      comparison.cases.push_back({vehicles, persons, {}, {}});
      for (const auto& rules : {aiv::SpeedRules{}, plan.rules})
        for (std::size_t i = 0; i < seeds; ++i)
          all.push_back({plan.rtm, rules, vehicles, persons, plan.first_seed + i, plan.duration});
    }
  std::vector<Result<FleetRun>> runs(all.size());
  for (std::size_t from = 0; from < all.size(); from += block) {
    const std::size_t count = std::min(block, all.size() - from);
    workers.for_each(count, [&](std::size_t i) { runs[from + i] = run_fleet(all[from + i]); });
    if (progress) progress(from + count, all.size());
  }

  Digest digest;
  auto next = runs.begin();
  for (FleetCase& fleet_case : comparison.cases)
    for (auto* of : {&fleet_case.crisp, &fleet_case.rules})
      for (std::size_t i = 0; i < seeds; ++i, ++next) {
        if (!*next) return tl::unexpected<Error>(next->error());
        digest.add(std::string_view{(*next)->digest});
        of->push_back(std::move(**next));
      }
  comparison.digest = digest.hex();
  return comparison;
}

std::vector<std::string> violations_of(const FleetComparison& comparison, double fewer_stops_percent) {
  std::vector<std::string> violations;
  std::uint32_t vehicles_max = 0;
  for (const FleetCase& fleet_case : comparison.cases) vehicles_max = std::max(vehicles_max, fleet_case.vehicles);
  for (const FleetCase& fleet_case : comparison.cases) {
    const std::string name = name_of(fleet_case) + ": ";
    const PairedMean laps = fleet_case.laps();
    const PairedMean stops = fleet_case.stops();
    if (laps.less()) violations.push_back(name + "fewer laps by " + fixed_text(-laps.percent(), 2) + " %");
    if (stops.more()) violations.push_back(name + "more stops by " + fixed_text(stops.percent(), 1) + " %");
    if (fleet_case.vehicles == vehicles_max && -stops.percent() < fewer_stops_percent)
      violations.push_back(name + fixed_text(-stops.percent(), 1) + " % fewer stops, not " +
                           fixed_text(fewer_stops_percent, 1) + " %");
    if (fleet_case.collisions() > 0)
      violations.push_back(name + std::to_string(fleet_case.collisions()) + " collisions");
  }
  return violations;
}

void write_json(JsonWriter& json, const FleetPlan& plan, const FleetComparison& comparison) {
  json.begin_object().field("zone", plan.rtm->zone().name).field("minutes", to_seconds(plan.duration) / 60.0);
  json.field("first_seed", plan.first_seed).field("last_seed", plan.last_seed);
  aiv::write_json(json.key("rules"), plan.rules);
  json.field("digest", comparison.digest).key("cases").begin_array();
  for (const FleetCase& fleet_case : comparison.cases) {
    json.begin_object().field("vehicles", fleet_case.vehicles).field("persons", fleet_case.persons);
    json.field("collisions", fleet_case.collisions());
    for (const auto& [name, mean] : quantities_of(fleet_case)) {
      json.key(name).begin_object().field("crisp", mean.crisp).field("rules", mean.rules);
      json.field("difference", mean.difference).key("interval").begin_array();
      json.value(mean.interval.low).value(mean.interval.high).end_array().end_object();
    }
    json.end_object();
  }
  json.end_array().end_object();
}

std::string to_text(const FleetPlan& plan, const FleetComparison& comparison) {
  const auto right = [](std::string cell, std::size_t width) {
    return std::string(width > cell.size() ? width - cell.size() : 1, ' ') + std::move(cell);
  };
  std::string text = "Rules against crisp rules on " + plan.rtm->zone().name + ", seeds " +
                     std::to_string(plan.first_seed) + " to " + std::to_string(plan.last_seed) + ", " +
                     fixed_text(to_seconds(plan.duration) / 60.0, 1) +
                     " min each; mean per run, difference with its paired 95 % interval:\n";
  for (const FleetCase& fleet_case : comparison.cases) {
    text += name_of(fleet_case) + ", " + std::to_string(fleet_case.collisions()) + " collisions\n";
    for (const auto& [name, mean] : quantities_of(fleet_case)) {
      text += "  " + name + right(fixed_text(mean.crisp, 2), 34 - name.size()) + right(fixed_text(mean.rules, 2), 12) +
              right(fixed_text(mean.difference, 2), 12) + "  [" + fixed_text(mean.interval.low, 2) + ", " +
              fixed_text(mean.interval.high, 2) + "]" + right(fixed_text(mean.percent(), 2), 10) + " %\n";
    }
  }
  return text + "digest " + comparison.digest + "\n";
}

}  // namespace cosiva::experiments
