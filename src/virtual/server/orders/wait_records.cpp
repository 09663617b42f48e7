#include "cosiva/virtual/server/orders/wait_records.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void WaitRecords::begin(VehicleIndex vehicle) {
  vehicles_[vehicle].crossing.reset();
  vehicles_[vehicle].blocker = no_vehicle;
}

void WaitRecords::wait_for(VehicleIndex vehicle, VehicleIndex blocker, WaitReason why) {
  vehicles_[vehicle].blocker = blocker;
  vehicles_[vehicle].why = why;
}

void WaitRecords::wait_for(VehicleIndex vehicle, const Traffic::Response& response) {
  vehicles_[vehicle].crossing = response.waits_for;
  wait_for(vehicle, response.blocked_by, response.why);
}

void WaitRecords::record(VehicleIndex vehicle, bool blocked, SimTime now) {
  WaitRecord& record = vehicles_[vehicle];
  if (!blocked || (!record.crossing && record.blocker == no_vehicle)) {
    record.since.reset();
    return;
  }
  if (!record.since) record.since = now;
  const SimDuration waited = now - *record.since;
  longest_ = std::max(longest_, waited);
  COSIVA_EXPECT(waited <= longest_);
}

void WaitRecords::archive(Archive& archive) { archive(vehicles_, longest_); }

}  // namespace cosiva::virtual_side
