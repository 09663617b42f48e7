#pragma once

#include <cstdint>

#include "cosiva/base/time.h"

namespace cosiva::aiv {

/// A vehicle's request for a crossing, as far as it matters for the right of way.
struct Claim {
  std::int32_t priority;
  SimDuration waited;
};

/// Whether `a` goes before `b`, which has come later or at the same time: by priority, and among equals in the order of
/// their requests; but no vehicle overtakes one that has waited `overtaken_at_most`.
[[nodiscard]] constexpr bool keeps_its_turn(const Claim& a, const Claim& b, SimDuration overtaken_at_most) {
  const bool a_waited = a.waited >= overtaken_at_most;
  const bool b_waited = b.waited >= overtaken_at_most;
  if (a_waited != b_waited) return a_waited;
  if (!a_waited && a.priority != b.priority) return a.priority > b.priority;
  return true;
}

}  // namespace cosiva::aiv
