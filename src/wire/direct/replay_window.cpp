#include "cosiva/wire/direct/replay_window.h"

#include "cosiva/base/expect.h"

namespace cosiva::wire {

bool ReplayWindow::accept(std::uint64_t session, std::uint64_t sequence) {
  if (sequence == 0 || session < session_) return false;
  if (session > session_) {
    session_ = session;
    highest_ = 0;
    accepted_ = 0;
  }
  if (sequence > highest_) {
    const std::uint64_t step = sequence - highest_;
    accepted_ = step < width ? accepted_ << step : 0;
    accepted_ |= 1U;
    highest_ = sequence;
    return true;
  }
  const std::uint64_t behind = highest_ - sequence;
  if (behind >= width) return false;
  const std::uint64_t bit = std::uint64_t{1} << behind;
  if ((accepted_ & bit) != 0) return false;
  accepted_ |= bit;
  COSIVA_EXPECT((accepted_ & 1U) != 0);
  return true;
}

}  // namespace cosiva::wire
