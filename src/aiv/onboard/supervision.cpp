#include "cosiva/aiv/onboard/supervision.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::aiv {

void Supervision::broker(SimTime now, bool up) {
  if (broker_up_ || up) broker_up_at_ = now;
  broker_up_ = up;
  COSIVA_EXPECT(!broker_up_ || broker_up_at_);
}

bool Supervision::broker_lost(SimTime now) const {
  return !broker_up_ && (!broker_up_at_ || now - *broker_up_at_ > timeout_);
}

bool Supervision::board_lost(SimTime now, wire::Board board) const {
  const auto& received = board_message_at_[index(board)];
  return !received || now - *received > timeout_;
}

bool Supervision::any_board_lost(SimTime now) const {
  return std::ranges::any_of(wire::all_boards, [&](wire::Board board) { return board_lost(now, board); });
}

}  // namespace cosiva::aiv
