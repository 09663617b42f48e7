#include "cosiva/app/simulate/seed_report.h"

#include <algorithm>

#include "cosiva/app/cli/console.h"
#include "cosiva/base/expect.h"
#include "cosiva/base/json_writer.h"
#include "cosiva/experiments/faults/fault_schedule.h"

namespace cosiva::app {
namespace {

using experiments::FaultCounts;
using experiments::FaultKind;
using experiments::FaultSimulationResult;

std::string counts_text(const FaultCounts& counts) {
  std::string text;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts.at(i) == 0) continue;
    text += (text.empty() ? "" : ", ") + std::string(to_string(static_cast<FaultKind>(i))) + " " +
            std::to_string(counts.at(i));
  }
  return text.empty() ? "no faults" : text;
}

/// Nothing where there is one control area.
std::string handovers_text(std::uint64_t handovers) {
  return handovers == 0 ? std::string{} : ", " + std::to_string(handovers) + " hand-overs";
}

std::string number_text(double number) {
  JsonWriter json;
  json.value(number);
  return json.take();
}

}  // namespace

void add(SeedTotals& totals, const FaultSimulationResult& result) {
  ++totals.seeds;
  if (result.violation) ++totals.failed;
  const FaultCounts counts = experiments::count_kinds(result.faults);
  for (std::size_t i = 0; i < counts.size(); ++i) totals.faults.at(i) += counts.at(i);
  totals.accepted += result.accepted;
  totals.handovers += result.handovers;
  totals.simulated_s += to_seconds(result.simulated);
  totals.fresh_after_s_max = std::max(totals.fresh_after_s_max, to_seconds(result.fresh_after));
  totals.driving_after_s_max = std::max(totals.driving_after_s_max, to_seconds(result.driving_after));
}

std::string seed_text(const FaultSimulationResult& result) {
  return "seed " + std::to_string(result.seed) + ": " +
         (result.violation ? result.violation->invariant + " violated" : std::string{"holds"}) + ", digest " +
         result.digest + ", " + decimals(to_seconds(result.simulated), 1) + " s, " + std::to_string(result.accepted) +
         " commands accepted, server started " + std::to_string(result.server_starts) + " times" +
         handovers_text(result.handovers) + "; " + counts_text(experiments::count_kinds(result.faults));
}

std::string seed_json(const FaultSimulationResult& result, const std::string& replay) {
  JsonWriter json;
  json.begin_object()
      .field("seed", std::to_string(result.seed))
      .field("digest", result.digest)
      .field("simulated_s", to_seconds(result.simulated))
      .field("commands", result.accepted)
      .field("serverStarts", result.server_starts)
      .field("handovers", result.handovers)
      .field("fresh_s", to_seconds(result.fresh_after))
      .field("driving_s", to_seconds(result.driving_after));
  json.key("faults").begin_object();
  const FaultCounts counts = experiments::count_kinds(result.faults);
  for (std::size_t i = 0; i < counts.size(); ++i) json.field(to_string(static_cast<FaultKind>(i)), counts.at(i));
  json.end_object().key("violation");
  if (result.violation)
    json.begin_object()
        .field("invariant", result.violation->invariant)
        .field("t_s", to_seconds(result.violated_at))
        .field("text", result.violation->text)
        .field("replay", replay)
        .end_object();
  else
    json.null();
  json.end_object();
  return json.take();
}

std::string failure_text(const FaultSimulationResult& result) {
  COSIVA_EXPECT(result.violation);
  return "  version " COSIVA_VERSION ", seed " + std::to_string(result.seed) + ", " +
         decimals(to_seconds(result.violated_at), 3) + " s: " + result.violation->invariant + ": " +
         result.violation->text;
}

std::string totals_text(const SeedTotals& totals) {
  return std::to_string(totals.seeds) + " seeds, " + std::to_string(totals.failed) + " failed; " +
         decimals(totals.simulated_s / 60.0, 1) + " virtual minutes, " + std::to_string(totals.accepted) +
         " commands accepted" + handovers_text(totals.handovers) + "; injected: " + counts_text(totals.faults) +
         "; all twins fresh " + decimals(totals.fresh_after_s_max, 2) +
         " s after the faults at most, all vehicles driving after " + decimals(totals.driving_after_s_max, 1) + " s";
}

std::string replay_command(const SimulateArguments& arguments, const FaultSimulationResult& result,
                           const std::vector<std::uint32_t>& faults) {
  std::string line = "cosiva simulate --seeds " + std::to_string(result.seed) + " --minutes " +
                     number_text(arguments.minutes) +
                     (arguments.handovers ? " --handovers" : " --zone " + arguments.zone) + " --aivs " +
                     std::to_string(arguments.aivs);
  if (!arguments.other_zone.empty()) line += " --other-zone " + arguments.other_zone;
  if (!arguments.plant.empty()) line += " --plant " + arguments.plant;
  const std::vector<std::uint32_t>& numbers = faults.empty() ? arguments.faults : faults;
  for (std::size_t i = 0; i < numbers.size(); ++i) line += (i == 0 ? " --faults " : ",") + std::to_string(numbers[i]);
  return line;
}

}  // namespace cosiva::app
