#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <typeinfo>
#include <vector>

#include "cosiva/base/digest.h"
#include "cosiva/wire/messages/board.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::wire {

/// The frames that one vehicle's boards send together to its on-board program, or it to them, as values: the content
/// of one SendBytes and one Input instead of the bytes of up to four streams. Messages and sequence numbers are those
/// that the other side would read from the frames, so that both sides count and decide alike.
///
/// Invariant: every message is as module_link reads it (module_link::change_to_read).
class BoardFrames final : public InProcessMessage {
 public:
  struct Frame {
    Board board;
    std::uint8_t sequence;
    BoardMessage message;
  };

  explicit BoardFrames(std::uint32_t vehicle) : vehicle_{vehicle} {}

  void add(Board board, std::uint8_t sequence, const BoardMessage& message);
  /// Empties the list and keeps its memory, that of the messages too.
  void clear() { count_ = 0; }
  [[nodiscard]] std::uint32_t vehicle() const { return vehicle_; }
  /// In the order in which they were sent.
  [[nodiscard]] std::span<const Frame> frames() const { return std::span{frames_}.first(count_); }
  /// The frames from `first` on that are of the same board as that one: what one piece of a stream would hold.
  /// @param first  less than frames().size() (checked)
  [[nodiscard]] std::span<const Frame> run_of_board(std::size_t first) const;

  void fold(Digest& digest) const override;

 private:
  std::uint32_t vehicle_;
  std::vector<Frame> frames_;  ///< the list, and behind it what an earlier one left
  std::size_t count_{0};
};

/// The frames, if such are passed on; null otherwise. The class is final, so one comparison does.
[[nodiscard]] inline const BoardFrames* frames_of(const InProcessMessage* message) {
  return message != nullptr && typeid(*message) == typeid(BoardFrames) ? static_cast<const BoardFrames*>(message)
                                                                       : nullptr;
}

}  // namespace cosiva::wire
