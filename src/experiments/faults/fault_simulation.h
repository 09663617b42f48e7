#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/experiments/faults/fault.h"
#include "cosiva/experiments/faults/planted.h"
#include "cosiva/experiments/faults/two_areas.h"
#include "cosiva/experiments/faults/violation.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::experiments {

struct FaultSimulationOptions {
  std::shared_ptr<const zone::Rtm> rtm;                 ///< the zone; not null (checked)
  std::optional<zone::ZoneConfiguration> other_zone{};  ///< for commands that switch the zone; nothing: none is given
  std::uint32_t aivs{4};
  SimDuration duration{std::chrono::minutes{10}};  ///< with faults; the time until all vehicles drive again follows
  Planted planted{Planted::none};
  /// Only the faults with these numbers of the seed's schedule are injected; nothing: all of them.
  std::optional<std::vector<std::uint32_t>> only{};
  /// Not nothing: two servers with these control areas on the floor `rtm`, and vehicles that are sent from one to the
  /// other (simulate_handovers()); `other_zone` is not used then.
  std::optional<TwoAreas> areas{};
};

struct FaultSimulationResult {
  std::uint64_t seed{};
  std::vector<Fault> faults;  ///< those injected
  std::string digest;         ///< of all cores, 16 hexadecimal digits
  SimDuration simulated{};
  std::uint64_t accepted{};  ///< commands
  std::uint64_t server_starts{};
  std::uint64_t handovers{};    ///< of vehicles, completed: the control area before has received the new owner
  SimDuration fresh_after{};    ///< from the end of the faults until all twins were fresh
  SimDuration driving_after{};  ///< from the last restart command until every vehicle drove
  std::optional<Violation> violation;
  SimDuration violated_at{};  ///< since the start
};

/// Runs the whole platform in virtual time under the faults of one seed, checks the invariants after each step of 20 ms
/// and each message, and then, without faults, that all twins become fresh and all vehicles drive. The same seed and
/// options give the same result. Fails where the zone cannot hold so many vehicles.
[[nodiscard]] Result<FaultSimulationResult> simulate_faults(std::uint64_t seed, const FaultSimulationOptions& options);

/// The schedule of a seed, of which `only` chooses.
[[nodiscard]] std::vector<Fault> fault_schedule_of(std::uint64_t seed, const FaultSimulationOptions& options);

}  // namespace cosiva::experiments
