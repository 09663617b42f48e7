#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "cosiva/aiv/decision/speed_rules.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/zone/rtm/rtm.h"

/// How well fleets drive by their agents' rules: measurements, comparisons and the search for better rules.
namespace cosiva::experiments {

/// One run of the whole platform in virtual time, at the live platform's cycle.
struct FleetRunOptions {
  std::shared_ptr<const zone::Rtm> rtm;  ///< the zone; not null (checked)
  aiv::SpeedRules rules;                 ///< of all vehicles
  std::uint32_t vehicles{4};
  std::uint32_t persons{0};  ///< virtual ones, who walk to and fro across the path, where there is no crossing
  std::uint64_t seed{1};     ///< of noise and persons; runs with the same seed can be compared in pairs
  SimDuration duration{std::chrono::minutes{10}};
};

/// The ground truth of a run, as the emulated plant knows it, summed over the fleet; stops and energy while all persons
/// are there.
struct FleetRun {
  double distance_m{};
  double laps{};  ///< the distance in lengths of all sections, which on a zone that is one loop are laps
  /// Transitions from moving (at least 5 cm/s) to standstill (less than 1 cm/s).
  std::uint64_t stops{};
  double stopped_s{};   ///< time at standstill
  double creeping_s{};  ///< time at less than 5 cm/s, but not at standstill
  double energy_kj{};   ///< drawn from the batteries: drives, and electronics while driving and stopped
  std::uint64_t collisions{};
  std::string digest{};  ///< of all cores
};

/// Fails where the zone cannot hold so many vehicles or persons, and on custom rules that cannot be used.
[[nodiscard]] Result<FleetRun> run_fleet(const FleetRunOptions& options);

}  // namespace cosiva::experiments
