#pragma once

#include <chrono>

#include "cosiva/base/time.h"

namespace cosiva::adapters {

/// Wall-clock time (UTC) for stamping inputs. The wall clock is read once, then the steady clock carries the time on:
/// the time never goes back and never jumps within a process, whatever is done to the machine's clock (a step shows
/// after the next start only). Slewing by NTP reaches both clocks.
class WallClock {
 public:
  WallClock();
  [[nodiscard]] SimTime now() const;

 private:
  std::chrono::steady_clock::time_point steady_start_;
  SimTime wall_start_;
};

}  // namespace cosiva::adapters
