#pragma once

#include <cstdint>
#include <functional>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/experiments/faults/fault_simulation.h"

namespace cosiva::experiments {

struct ShrunkSeed {
  FaultSimulationResult result;        ///< with the faults that remain
  std::vector<std::uint32_t> numbers;  ///< of these faults, in the seed's schedule
  std::uint64_t runs{};                ///< how many simulations this took
};

/// Removes the faults without which a failed seed still violates the same invariant: halves, quarters and so on, and in
/// the end single faults (delta debugging, Zeller 1999). The result is minimal: it needs each of its faults.
///
/// @param failed    of this seed and these options, with a violation (checked)
/// @param progress  called before each run with the number of faults that remain; may be empty
[[nodiscard]] Result<ShrunkSeed> shrink(const FaultSimulationResult& failed, const FaultSimulationOptions& options,
                                        const std::function<void(std::size_t)>& progress = {});

}  // namespace cosiva::experiments
