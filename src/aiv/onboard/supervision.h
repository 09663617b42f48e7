#pragma once

#include <array>
#include <cstddef>
#include <optional>

#include "cosiva/aiv/partners/link_check_timer.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/board.h"

namespace cosiva::aiv {

/// The partners that the vehicle needs in order to drive (the vehicle's promise 3): its broker, the boards that it has,
/// and its server from the first heartbeat on. Only messages prove that a partner is alive: a frozen process keeps its
/// connection open.
///
/// The server counts until it has left and the vehicle has stopped without an order (release_server()): no message by
/// itself ends the supervision of a vehicle that drives or has an order. A third-party master control publishes no
/// heartbeat, so that for its vehicles only broker and boards count.
///
/// Invariant: only a server that is supervised can have left.
class Supervision {
 public:
  /// @param timeout  a partner that has sent nothing for longer than this is lost; positive (checked)
  /// @param rali     the vehicle has this board
  explicit Supervision(SimDuration timeout, bool rali = true);

  /// Any message that arrives from the broker, or the broker's acceptance of the connection.
  void on_broker_message(SimTime now) { broker_message_at_ = now; }
  /// Time since the last message from the broker; nothing: none has arrived yet.
  [[nodiscard]] std::optional<SimDuration> broker_quiet_for(SimTime now) const {
    return broker_message_at_ ? std::optional{now - *broker_message_at_} : std::nullopt;
  }
  /// True once for each check of the link that is due (LinkCheckTimer).
  [[nodiscard]] bool take_link_check(SimTime now) { return link_check_timer_.due(now, broker_quiet_for(now)); }

  void on_server_heartbeat(SimTime now);
  /// The vehicle belongs to another server, whose heartbeat is expected in place of the present server's: by the same
  /// time, or within the timeout from now where no server was supervised.
  void expect_server(SimTime now);
  /// The server has ended cleanly, or the vehicle belongs to no server any more: another master control may drive the
  /// vehicle, or none. Valid until the next heartbeat.
  void server_left();
  /// The vehicle has stopped and has no order: a server that has left is supervised no longer. True: from now on.
  bool release_server();

  void on_board_message(SimTime now, wire::Board board) { board_message_at_[index(board)] = now; }
  void forget_board(wire::Board board) { board_message_at_[index(board)].reset(); }

  [[nodiscard]] bool broker_lost(SimTime now) const {
    return !broker_message_at_ || now - *broker_message_at_ > timeout_;
  }
  [[nodiscard]] bool server_lost(SimTime now) const {
    return server_heartbeat_at_ && now - *server_heartbeat_at_ > timeout_;
  }
  [[nodiscard]] bool has(wire::Board board) const { return board != wire::Board::RALI || rali_fitted_; }
  [[nodiscard]] bool board_lost(SimTime now, wire::Board board) const {
    return has(board) && is_lost(now, board_message_at_[index(board)]);
  }
  [[nodiscard]] bool any_board_lost(SimTime now) const {
    for (const wire::Board board : wire::all_boards)
      if (board_lost(now, board)) return true;
    return false;
  }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  [[nodiscard]] static std::size_t index(wire::Board board) { return static_cast<std::size_t>(board) - 1; }

  [[nodiscard]] bool is_lost(SimTime now, const std::optional<SimTime>& received) const {
    return !received || now - *received > timeout_;
  }

  SimDuration timeout_;
  bool rali_fitted_;
  std::optional<SimTime> broker_message_at_;
  LinkCheckTimer link_check_timer_;
  std::optional<SimTime> server_heartbeat_at_;  ///< or when it was first expected; nothing: no server is supervised
  bool server_left_{false};
  std::array<std::optional<SimTime>, wire::all_boards.size()> board_message_at_{};
};

}  // namespace cosiva::aiv
