#pragma once

#include <string>
#include <utility>

#include "cosiva/wire/own/v2x.h"

namespace cosiva::aiv {

/// The topic of a vehicle's intents, which depends on where the vehicle is. Most intents are published from the cell of
/// the one before: the text is composed only where the map or the cell has changed.
///
/// Invariant: the text is that of the last map and cell.
class IntentTopic {
 public:
  explicit IntentTopic(wire::VehicleId vehicle) : vehicle_{std::move(vehicle)} {}

  /// Valid until the next call.
  [[nodiscard]] const std::string& at(const std::string& map_id, wire::Cell cell);

 private:
  wire::VehicleId vehicle_;
  std::string map_id_;
  wire::Cell cell_;
  std::string text_;  ///< empty before the first call
};

}  // namespace cosiva::aiv
