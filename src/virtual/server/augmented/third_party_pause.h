#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// Third-party vehicles do not read the message VirtualObstacles. A vehicle that never acknowledged that message is
/// paused (startPause) while a virtual body blocks its path, and released (stopPause) when the body has left. A vehicle
/// that another party paused is never released.
///
/// Invariant: of the pause actions for a vehicle, only the last one is repeated; an earlier one would undo it.
class ThirdPartyPause {
 public:
  static constexpr double pause_within_m = 0.8;   ///< from the vehicle's front
  static constexpr double let_go_beyond_m = 1.0;  ///< hysteresis: a body at the limit does not make the vehicle stutter
  static constexpr double beside_m = 0.02;        ///< on each side of the vehicle
  static constexpr SimDuration timeout{std::chrono::seconds{5}};

  ThirdPartyPause(Registry& registry, Traffic& traffic, MessagePublisher& publisher, InstantActionSender& action_sender,
                  Simulator& simulator)
      : registry_{registry},
        traffic_{traffic},
        publisher_{publisher},
        action_sender_{action_sender},
        simulator_{simulator} {}

  void resize(std::size_t vehicles) { pauses_.resize(vehicles); }
  void set_map(const WaypointGraph* map) { map_ = map; }

  /// A body that may block a vehicle's path.
  struct Body {
    const wire::Body* body;
    bool is_aiv;  ///< traffic control keeps vehicles apart: an AIV counts only within the vehicle's base
  };
  /// For a vehicle that does not perceive virtual objects by itself. @param bodies  those near the vehicle, nearest
  /// first
  void evaluate(VehicleIndex vehicle, const Pose2& X_MB, std::span<const Body> bodies);
  /// Ends the pause: no body is near the vehicle any more, or the vehicle perceives virtual objects by itself.
  void let_go(VehicleIndex vehicle);
  /// The body for which the vehicle is paused; empty: none.
  [[nodiscard]] const std::string& paused_for(VehicleIndex vehicle) const { return pauses_[vehicle].body; }
  /// Incremented at the start and at the end of each pause.
  [[nodiscard]] std::uint64_t changes() const { return changes_; }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] bool in_path(VehicleIndex vehicle, const Pose2& X_MB, const Body& body, double within_m) const;
  void send(VehicleIndex vehicle, std::string action);

  Registry& registry_;
  Traffic& traffic_;
  MessagePublisher& publisher_;
  InstantActionSender& action_sender_;
  Simulator& simulator_;
  const WaypointGraph* map_{};
  std::uint64_t changes_{0};
  struct Pause {
    InstantActionSender::ActionHandle handle{0};  ///< of the last action for this vehicle; 0: none
    std::string body;
  };
  std::vector<Pause> pauses_;
};

}  // namespace cosiva::virtual_side
