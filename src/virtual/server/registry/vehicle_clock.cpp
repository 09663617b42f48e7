#include "cosiva/virtual/server/registry/vehicle_clock.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

SimTime VehicleClock::on_stamp(SimTime stamp, SimTime now) {
  const SimDuration off = now - stamp;
  const bool is_off = off > tolerance || off < -tolerance;
  off_s_ = is_off ? to_seconds(off) : 0.0;
  const SimTime at = is_off ? now : std::min(stamp, now);
  COSIVA_EXPECT(at <= now);
  return at;
}

void VehicleClock::archive(Archive& archive) { archive(off_s_); }

}  // namespace cosiva::virtual_side
