#pragma once

#include <string>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/virtual/server/messages/message_publisher.h"
#include "cosiva/virtual/server/registry/registry.h"

namespace cosiva::virtual_side {

/// Deploys the zone's map to third-party vehicles as VDA 5050 2.1 (§6.7) specifies: downloadMap, enableMap,
/// initPosition, one after the other, each where the factsheet lists it. CoSiVA vehicles take the configuration from
/// its topic.
///
/// Invariant: at most one action of the deployment to a vehicle is followed at a time.
class MapDeployment {
 public:
  static constexpr SimDuration timeout{std::chrono::seconds{10}};
  static constexpr SimDuration again_after{std::chrono::seconds{10}};

  MapDeployment(Registry& registry, MessagePublisher& publisher, InstantActionSender& action_sender)
      : registry_{registry}, publisher_{publisher}, action_sender_{action_sender} {}

  void resize(std::size_t vehicles) { steps_.resize(vehicles); }
  /// The zone has changed; earlier requests are not followed any more.
  void begin();
  struct Map {
    std::string id;
    std::string version;
    std::string link;  ///< empty: it cannot be downloaded
  };
  /// Takes the next step for a vehicle that reports another map than `map`.
  void step(VehicleIndex vehicle, const Map& map);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  struct Step {
    InstantActionSender::ActionHandle handle{0};  ///< 0: no action is pending
    SimTime sent_at{};
    SimTime not_before{};
  };
  [[nodiscard]] std::optional<wire::Action> next_action(VehicleIndex vehicle, const Map& map) const;
  [[nodiscard]] bool in_progress(Step& step) const;

  Registry& registry_;
  MessagePublisher& publisher_;
  InstantActionSender& action_sender_;
  std::vector<Step> steps_;
};

}  // namespace cosiva::virtual_side
