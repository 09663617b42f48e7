#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/wire/messages/topics.h"

namespace cosiva::virtual_side {

/// The names of a vehicle, fixed from its registration on.
///
/// Invariant: name, topics and `augmented` are those of the id, and the display number is positive.
class Identity {
 public:
  /// @param number  for display, positive (checked)
  Identity(wire::VehicleId id, std::uint32_t number, std::string_view interface_name);

  [[nodiscard]] const wire::VehicleId& id() const { return id_; }
  [[nodiscard]] const std::string& name() const { return name_; }  ///< "manufacturer/serial"
  [[nodiscard]] std::uint32_t number() const { return number_; }
  [[nodiscard]] const std::string& order_topic() const { return order_topic_; }
  [[nodiscard]] const std::string& actions_topic() const { return actions_topic_; }
  /// Added only virtually (A3): the bijection leaves the vehicle out.
  [[nodiscard]] bool augmented() const { return augmented_; }

 private:
  wire::VehicleId id_;
  std::string name_;
  std::uint32_t number_;
  std::string order_topic_;
  std::string actions_topic_;
  bool augmented_;
};

}  // namespace cosiva::virtual_side
