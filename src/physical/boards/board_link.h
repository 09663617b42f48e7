#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::physical {

/// Says when something periodic is due. One that was late does not catch up in a burst.
class Every {
 public:
  explicit Every(SimDuration period) : period_{period} {}
  void start(SimTime first) { next_ = first; }
  [[nodiscard]] bool due(SimTime now) const { return now >= next_; }
  /// True once per period.
  [[nodiscard]] bool take(SimTime now);

 private:
  SimDuration period_;
  SimTime next_{};
};

/// What all boards do alike (A18): say who they are when powered or newly connected, beat 10 times a second, number
/// their frames, and count what arrives damaged. Sans-IO: bytes in, bytes appended to `out`.
class BoardLink {
 public:
  explicit BoardLink(wire::Board board);

  /// @param session  random per power-up; the other side sees from it that odometers count from zero again
  void power_up(SimTime now, std::uint32_t session);
  /// The byte stream came or went. A board whose cable is out keeps running and says nothing.
  void connect(bool up);
  [[nodiscard]] bool connected() const { return connected_; }

  /// The messages in these bytes, until the next call. A Hello from the other side is a request: it is answered with
  /// ours at the next tick.
  [[nodiscard]] const std::vector<wire::BoardMessage>& receive(std::string_view bytes);
  void tick(SimTime now, std::string& out);
  void send(const wire::BoardMessage& message, std::string& out);

  /// Milliseconds since power-up; counts round after 49 days, as on a board.
  [[nodiscard]] std::uint32_t board_ms(SimTime now) const;
  [[nodiscard]] wire::Board board() const { return board_; }

 private:
  wire::Board board_;
  SimTime powered_at_{};
  std::uint32_t session_{};
  bool connected_{false};
  bool fresh_{false};      ///< connected since the last tick
  bool hello_due_{false};  ///< fresh, or asked for
  Every heartbeat_{std::chrono::milliseconds{100}};
  wire::module_link::Encoder encoder_;
  wire::module_link::Decoder decoder_;
  std::vector<wire::BoardMessage> received_;
};

}  // namespace cosiva::physical
