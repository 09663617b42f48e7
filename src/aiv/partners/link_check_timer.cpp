#include "cosiva/aiv/partners/link_check_timer.h"

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

bool LinkCheckTimer::due(SimTime now, std::optional<SimDuration> quiet_for) {
  if (!quiet_for || *quiet_for < quiet_max) return false;
  // A clock that was set back does not suspend the checks.
  if (checked_at_ && now >= *checked_at_ && now - *checked_at_ < repeat_after) return false;
  checked_at_ = now;
  COSIVA_EXPECT(*quiet_for >= quiet_max);
  return true;
}

void LinkCheckTimer::archive(Archive& archive) { archive(checked_at_); }

}  // namespace cosiva::aiv
