#include "cosiva/experiments/faults/shrink.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::experiments {
namespace {

std::vector<std::uint32_t> numbers_of(const std::vector<Fault>& faults) {
  std::vector<std::uint32_t> numbers;
  numbers.reserve(faults.size());
  for (const Fault& fault : faults) numbers.push_back(fault.number);
  return numbers;
}

/// All numbers but those in [from, from + count).
std::vector<std::uint32_t> without(const std::vector<std::uint32_t>& numbers, std::size_t from, std::size_t count) {
  std::vector<std::uint32_t> rest;
  for (std::size_t i = 0; i < numbers.size(); ++i)
    if (i < from || i >= from + count) rest.push_back(numbers[i]);
  return rest;
}

}  // namespace

Result<ShrunkSeed> shrink(const FaultSimulationResult& failed, const FaultSimulationOptions& options,
                          const std::function<void(std::size_t)>& progress) {
  COSIVA_EXPECT(failed.violation);
  ShrunkSeed best{failed, numbers_of(failed.faults), 0};
  FaultSimulationOptions smaller = options;
  std::size_t chunk = std::max<std::size_t>(1, best.numbers.size() / 2);
  while (!best.numbers.empty()) {
    bool removed = false;
    for (std::size_t from = 0; from < best.numbers.size();) {
      if (progress) progress(best.numbers.size());
      smaller.only = without(best.numbers, from, chunk);
      auto result = simulate_faults(failed.seed, smaller);
      if (!result) return tl::unexpected<Error>(result.error());
      ++best.runs;
      if (result->violation && result->violation->invariant == failed.violation->invariant) {
        // Faults behind the violation have no part in it.
        best.numbers = numbers_of(result->faults);
        best.result = std::move(*result);
        removed = true;
      } else {
        from += chunk;
      }
    }
    if (chunk == 1 && !removed) break;
    chunk =
        removed ? std::min(chunk, std::max<std::size_t>(1, best.numbers.size())) : std::max<std::size_t>(1, chunk / 2);
  }
  return best;
}

}  // namespace cosiva::experiments
