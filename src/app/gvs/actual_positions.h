#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/actual_position.h"
#include "cosiva/wire/own/gvs.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::app {

/// actualAIVposition at the GVS (A33, A34, A35): a request for a vehicle gets its pose in the first image that was
/// taken after the request. A vehicle that no image shows gets no response; the instrument repeats its request.
///
/// Invariant: a request gets at most one response; there is at most one request for a vehicle.
class ActualPositions {
 public:
  static constexpr std::size_t vehicles_max = 256;

  /// A request that cannot be read is ignored.
  void on_request(SimTime now, const wire::VehicleId& vehicle, std::string_view payload);
  /// The responses that an image allows.
  [[nodiscard]] std::vector<wire::Publish> on_detections(const wire::GvsDetections& detections);

 private:
  struct Requested {
    wire::VehicleId vehicle;
    wire::ActualPositionRequest request;
    SimTime at{};
  };
  std::map<std::string, Requested, std::less<>> requested_;  ///< by the vehicle's name
};

}  // namespace cosiva::app
