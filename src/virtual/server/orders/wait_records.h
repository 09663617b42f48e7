#pragma once

#include <cstddef>
#include <optional>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"

namespace cosiva::virtual_side {

/// What stopped the extension of a vehicle's base in the last tick.
struct WaitRecord {
  std::optional<CrossingIndex> crossing;
  VehicleIndex blocker{no_vehicle};
  WaitReason why{WaitReason::ahead};
  std::optional<SimTime> since;  ///< nothing: the vehicle is not blocked yet, or not any more
};

/// What each vehicle waits for, and how long the vehicles have waited.
///
/// Invariant: no recorded wait is longer than the longest wait, which never becomes shorter.
class WaitRecords {
 public:
  void resize(std::size_t vehicles) { vehicles_.resize(vehicles); }
  void forget(VehicleIndex vehicle) { vehicles_[vehicle] = {}; }
  [[nodiscard]] const WaitRecord& operator[](VehicleIndex vehicle) const { return vehicles_[vehicle]; }
  /// The longest wait so far.
  [[nodiscard]] SimDuration longest() const { return longest_; }

  /// Discards what the vehicle waits for, not since when: the tick records that anew.
  void begin(VehicleIndex vehicle);
  void wait_for(VehicleIndex vehicle, VehicleIndex blocker, WaitReason why);
  void wait_for(VehicleIndex vehicle, const Traffic::Response& response);
  /// Ends the tick for the vehicle.
  /// @param blocked  the vehicle got no base; otherwise it is merely informed early that it will be blocked
  void record(VehicleIndex vehicle, bool blocked, SimTime now);
  void end(VehicleIndex vehicle) { vehicles_[vehicle].since.reset(); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::vector<WaitRecord> vehicles_;
  SimDuration longest_{};
};

}  // namespace cosiva::virtual_side
