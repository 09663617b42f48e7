#pragma once

#include <cstddef>
#include <deque>
#include <optional>

#include "cosiva/base/time.h"
#include "cosiva/journal/store/segment_file.h"

namespace cosiva::journal {

/// How much of a store is retained.
struct Keep {
  std::optional<SimDuration> age;
  std::optional<std::size_t> bytes;
};
/// How many of the oldest segments may be removed at `now`: those that are too old or too many, and that no restart
/// needs.
[[nodiscard]] std::size_t removable(const std::deque<SegmentSummary>& verified, const Keep& keep, SimTime now);

}  // namespace cosiva::journal
