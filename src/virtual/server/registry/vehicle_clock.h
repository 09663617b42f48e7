#pragma once

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"

namespace cosiva::virtual_side {

/// How far a vehicle's own clock is off the server's.
///
/// Invariant: the offset is 0, or larger than the tolerance; a time on the server's clock that comes from a vehicle's
/// time stamp is never later than now.
class VehicleClock {
 public:
  static constexpr SimDuration tolerance{std::chrono::seconds{2}};

  /// A message with this time stamp has been received.
  /// @return  the time of the stamp on the server's clock; now where the vehicle's clock is off
  [[nodiscard]] SimTime on_stamp(SimTime stamp, SimTime now);

  [[nodiscard]] double off_s() const { return off_s_; }  ///< positive: slow; 0: correct within the tolerance
  [[nodiscard]] bool is_off() const { return off_s_ != 0.0; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  double off_s_{0.0};
};

}  // namespace cosiva::virtual_side
