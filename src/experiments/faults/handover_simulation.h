#pragma once

#include <cstdint>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/experiments/faults/fault.h"
#include "cosiva/experiments/faults/fault_simulation.h"

namespace cosiva::experiments {

/// The faults of a seed: those of draw_fault_schedule(), except crashes of the plant, which move vehicles from one
/// control area to the other; half of those of the server happen to the server of control area b. Operators send
/// vehicles from one control area to the other about five times a minute each, stop them and restart them.
/// @param options  with control areas (checked)
[[nodiscard]] std::vector<Fault> handover_schedule_of(std::uint64_t seed, const FaultSimulationOptions& options);

/// simulate_faults() with two servers, each with one control area ("a" and "b") and a store of its own, on one broker.
/// After each step of 20 ms: no two servers command one vehicle (I4, OwnershipMonitor), no vehicle touches another one
/// or a person (safety), both stores are what was written (I1). Once the faults have ended, every vehicle is in exactly
/// one table within 10 s (I4), and each can be sent to the other control area and drives there (I10).
/// @param options  with control areas (checked)
[[nodiscard]] Result<FaultSimulationResult> simulate_handovers(std::uint64_t seed,
                                                               const FaultSimulationOptions& options);

}  // namespace cosiva::experiments
