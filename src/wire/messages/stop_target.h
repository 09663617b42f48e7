#pragma once

#include <string>

#include "cosiva/wire/messages/topics.h"

namespace cosiva::wire {

/// A vehicle to which a Stop can be published without its server core: what the message has to carry, and what the core
/// has decided.
struct StopTarget {
  std::string name;  ///< "CoSiVA/AIV1"
  VehicleId id;
  std::string actions_topic;
  std::string state_topic;
  std::string version;  ///< as the vehicle writes it; empty: not known yet
  bool latched{false};  ///< the core wants the vehicle stopped, and publishes this itself until it is confirmed
  /// A CoSiVA vehicle: a message that arrives twice is performed once.
  bool is_cosiva{false};
  friend bool operator==(const StopTarget&, const StopTarget&) = default;
};

}  // namespace cosiva::wire
