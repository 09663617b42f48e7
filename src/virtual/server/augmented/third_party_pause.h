#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/proxy.h"
#include "cosiva/virtual/server/right_of_way/traffic.h"
#include "cosiva/virtual/simulator/simulator.h"

namespace cosiva::virtual_side {

/// Vehicles of other makes do not listen to Ahead. One that never answered is paused (startPause) while a virtual body
/// stands in its way, and let go (stopPause) when that is gone; never one that somebody else paused.
class ThirdPartyPause {
 public:
  static constexpr double pause_within_m = 0.8;   ///< from its front
  static constexpr double let_go_beyond_m = 1.0;  ///< so that a body at the limit does not make it stutter
  static constexpr double beside_m = 0.02;        ///< of its sides
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

  /// A body that may stand in a vehicle's way.
  struct Body {
    const wire::Body* body;
    bool is_aiv;  ///< traffic keeps vehicles apart: it counts only inside the base
  };
  /// The vehicle does not feel by itself; these are near it, nearest first.
  void evaluate(VehicleIndex vehicle, const Pose2& X_MB, std::span<const Body> bodies);
  /// Nothing is near it any more, or it feels by itself.
  void let_go(VehicleIndex vehicle);
  /// The body it is paused for; empty: none.
  [[nodiscard]] const std::string& paused_for(VehicleIndex vehicle) const { return pauses_[vehicle].body; }
  /// Grows with each pause and each end of one.
  [[nodiscard]] std::uint64_t changes() const { return changes_; }

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
    InstantActionSender::ActionHandle handle{0};  ///< of the last action for it; 0: none
    std::string body;
  };
  std::vector<Pause> pauses_;
};

}  // namespace cosiva::virtual_side
