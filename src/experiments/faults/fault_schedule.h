#pragma once

#include <cstdint>
#include <vector>

#include "cosiva/base/time.h"
#include "cosiva/experiments/faults/fault.h"

namespace cosiva::experiments {

/// What a schedule is drawn for.
struct FaultScheduleOptions {
  SimDuration duration{std::chrono::minutes{10}};  ///< of the time with faults, at least 10 s (checked)
  std::uint32_t aivs{4};                           ///< at least 1 (checked)
  std::vector<std::string> sections{};             ///< of the zone, for commands that close one; may be empty
  std::string zone_switch{};                       ///< the command that switches to another zone; empty: none is given
  std::string zone_back{};                         ///< the command that switches back
};

/// The faults of one seed, at the rates of the requirements for reliability: loss up to 30 %, duplication up to 50 %,
/// delay up to 2 s, partitions from 0.1 s to a minute, and for each minute about two crashes, a power cut, a broker's
/// death, a disk that refuses, two changes of a clock and eight commands. Every fifth seed has no faults of one class,
/// so that others act alone.
///
/// @return sorted by time, numbered from 1; equal for equal seeds and options
[[nodiscard]] std::vector<Fault> draw_fault_schedule(std::uint64_t seed, const FaultScheduleOptions& options);

[[nodiscard]] FaultCounts count_kinds(const std::vector<Fault>& faults);

}  // namespace cosiva::experiments
