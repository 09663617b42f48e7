#pragma once

#include <vector>

#include "cosiva/base/time.h"
#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/view/frames.h"

namespace cosiva::virtual_side {

/// The data that the HMI's animation reads 30 times a second: no text, and no memory besides the list itself.
class PositionView {
 public:
  PositionView(const ServerContext& context, const AugmentedParts& augmented)
      : context_{context}, augmented_{augmented} {}

  /// All objects that move or may move, sorted by handle, at the time of the last input, extrapolated to `now`.
  void positions(SimTime now, std::vector<PositionRecord>& out) const;

 private:
  [[nodiscard]] PositionRecord record_of_vehicle(VehicleIndex vehicle, SimTime at) const;

  const ServerContext& context_;
  const AugmentedParts& augmented_;
};

}  // namespace cosiva::virtual_side
