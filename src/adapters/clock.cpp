#include "cosiva/adapters/clock.h"

namespace cosiva::adapters {

WallClock::WallClock()
    : steady_start_{std::chrono::steady_clock::now()},
      wall_start_{std::chrono::duration_cast<SimDuration>(std::chrono::system_clock::now().time_since_epoch())} {}

SimTime WallClock::now() const {
  return wall_start_ + std::chrono::duration_cast<SimDuration>(std::chrono::steady_clock::now() - steady_start_);
}

}  // namespace cosiva::adapters
