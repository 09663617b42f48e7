#include "cosiva/aiv/onboard/supervision.h"

#include <algorithm>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::aiv {

Supervision::Supervision(SimDuration timeout) : timeout_{timeout} { COSIVA_EXPECT(timeout > SimDuration::zero()); }

std::optional<SimDuration> Supervision::broker_quiet_for(SimTime now) const {
  if (!broker_message_at_) return std::nullopt;
  return now - *broker_message_at_;
}

void Supervision::on_server_heartbeat(SimTime now) {
  server_heartbeat_at_ = now;
  server_left_ = false;
}

void Supervision::expect_server(SimTime now) {
  // The time of the last heartbeat stays: a vehicle that is given one owner after the other is not supervised less.
  server_heartbeat_at_ = server_heartbeat_at_.value_or(now);
  server_left_ = false;
}

void Supervision::server_left() { server_left_ = server_heartbeat_at_.has_value(); }

bool Supervision::release_server() {
  COSIVA_EXPECT(!server_left_ || server_heartbeat_at_);
  if (!server_left_) return false;
  server_heartbeat_at_.reset();
  server_left_ = false;
  return true;
}

bool Supervision::broker_lost(SimTime now) const {
  const auto quiet_for = broker_quiet_for(now);
  return !quiet_for || *quiet_for > timeout_;
}

bool Supervision::board_lost(SimTime now, wire::Board board) const {
  const auto& received = board_message_at_[index(board)];
  return !received || now - *received > timeout_;
}

bool Supervision::any_board_lost(SimTime now) const {
  return std::ranges::any_of(wire::all_boards, [&](wire::Board board) { return board_lost(now, board); });
}

void Supervision::archive(Archive& archive) {
  archive(broker_message_at_, link_check_timer_, server_heartbeat_at_, server_left_, board_message_at_);
}

}  // namespace cosiva::aiv
