#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::aiv {

/// The links that the vehicle needs in order to drive (the vehicle's promise 3): its broker, its four boards, and a
/// server from its first heartbeat on. Invariant: of a broker that is up, the time is known since when it may be lost.
class Supervision {
 public:
  explicit Supervision(SimDuration timeout) : timeout_{timeout} {}

  void broker(SimTime now, bool up);
  void on_server_heartbeat(SimTime now) { server_heartbeat_at_ = now; }
  /// The server went offline cleanly: another master may drive the vehicle, or none.
  void server_left() { server_heartbeat_at_.reset(); }
  void on_board_message(SimTime now, wire::Board board) { board_message_at_[index(board)] = now; }
  void forget_board(wire::Board board) { board_message_at_[index(board)].reset(); }

  [[nodiscard]] bool broker_lost(SimTime now) const;
  [[nodiscard]] bool server_lost(SimTime now) const {
    return server_heartbeat_at_ && now - *server_heartbeat_at_ > timeout_;
  }
  [[nodiscard]] bool board_lost(SimTime now, wire::Board board) const;
  [[nodiscard]] bool any_board_lost(SimTime now) const;

 private:
  [[nodiscard]] static std::size_t index(wire::Board board) { return static_cast<std::size_t>(board) - 1; }

  SimDuration timeout_;
  bool broker_up_{false};
  std::optional<SimTime> broker_up_at_;  ///< when it was last up; nothing: never
  std::optional<SimTime> server_heartbeat_at_;
  std::array<std::optional<SimTime>, wire::all_boards.size()> board_message_at_{};
};

}  // namespace cosiva::aiv
