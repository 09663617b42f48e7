#pragma once

#include <optional>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"

namespace cosiva::aiv {

/// When the vehicle checks its link to the broker (wire::LinkCheck): while no other message proves that the broker is
/// alive. The heartbeat of a server makes checks unnecessary; a third-party master control may send nothing for
/// minutes.
///
/// Invariant: two checks are at least `repeat_after` apart, however often due() is called.
class LinkCheckTimer {
 public:
  /// Two heartbeats are missing. Three checks fit into the 500 ms after which the vehicle brakes, so that two may be
  /// lost, or both ways of one may be delayed by 100 ms.
  static constexpr SimDuration quiet_max{std::chrono::milliseconds{200}};
  static constexpr SimDuration repeat_after{std::chrono::milliseconds{100}};

  /// True once for each check that is due.
  /// @param quiet_for  time since the last message from the broker; nothing: none has arrived yet
  [[nodiscard]] bool due(SimTime now, std::optional<SimDuration> quiet_for);

  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::optional<SimTime> checked_at_;
};

}  // namespace cosiva::aiv
