#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <string_view>

#include "cosiva/base/time.h"
#include "cosiva/physical/boards/board_link.h"
#include "cosiva/physical/plant/obstacles.h"
#include "cosiva/physical/plant/vehicle.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::physical {

/// Publishes the ground truth for instruments: everything ten times a second (wire::ground_truth_topic), and once a
/// second the vehicles' poses as any instrument would send them, for the server's bijection monitor
/// (wire::reference_poses_topic).
///
/// Invariant: neither is published more often than once in its period.
class GroundTruthPublisher {
 public:
  void start(SimTime at);
  /// @param publishes  whether there is a broker and an interest; the periods pass in any case
  /// @param contacts   since the plant's first start
  void tick(SimTime at, bool publishes, std::span<const Vehicle> vehicles, const Obstacles& obstacles,
            std::size_t contacts, wire::Effects& effects);
  /// The response to a request for a vehicle's actual position (A33); nothing where no such vehicle is in the plant, or
  /// the request cannot be read.
  [[nodiscard]] static std::optional<wire::Publish> actual_position(SimTime at, const wire::VehicleId& vehicle,
                                                                    std::string_view request,
                                                                    std::span<const Vehicle> vehicles);

 private:
  static constexpr SimDuration reference_period{std::chrono::seconds{1}};
  Every ground_truth_{std::chrono::milliseconds{100}};
  Every reference_{reference_period};
};

}  // namespace cosiva::physical
