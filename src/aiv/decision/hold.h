#pragma once

#include <cstdint>
#include <string_view>

#include "cosiva/base/archive_fwd.h"

namespace cosiva::aiv {

/// A reason for which a vehicle stops although its order would let it go. Several may be in force at once.
enum class Hold : std::uint8_t {
  paused = 1U << 0U,        ///< startPause
  broker_lost = 1U << 1U,   ///< no message arrives from outside
  server_lost = 1U << 2U,   ///< a server whose heartbeat the vehicle has received sends none any more
  board_lost = 1U << 3U,    ///< the vehicle cannot sense or act
  board_faulty = 1U << 4U,  ///< a board that drives the vehicle reports that it is broken
  line_lost = 1U << 5U,     ///< no line under the sensors
  zone_change = 1U << 6U,   ///< another zone comes into force as soon as the vehicle has stopped
  action = 1U << 7U,        ///< an action of the order runs during which the vehicle must not drive
};
[[nodiscard]] std::string_view to_string(Hold hold);

/// The holds that are in force.
class HoldSet {
 public:
  void set(Hold hold, bool on) {
    const auto bit = static_cast<std::uint8_t>(hold);
    bits_ = static_cast<std::uint8_t>(on ? bits_ | bit : bits_ & ~bit);
  }
  [[nodiscard]] bool has(Hold hold) const { return (bits_ & static_cast<std::uint8_t>(hold)) != 0; }
  [[nodiscard]] bool any() const { return bits_ != 0; }
  [[nodiscard]] std::uint8_t bits() const { return bits_; }  ///< a bit for each hold
  void archive(Archive& archive);                            ///< the state, for a snapshot

 private:
  std::uint8_t bits_{0};
};

}  // namespace cosiva::aiv
