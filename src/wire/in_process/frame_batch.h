#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "cosiva/wire/in_process/board_frames.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::wire {

/// Collects the frames that a sender has for one vehicle's other side and lets them leave together, as one effect.
/// Lists that their receivers have released are used again, so that a run allocates none after its first moments.
///
/// Invariant: a list that a receiver still holds is never changed.
class FrameBatch {
 public:
  explicit FrameBatch(std::uint32_t vehicle) : vehicle_{vehicle} {}

  void add(Board board, std::uint8_t sequence, const BoardMessage& message) {
    if (!filling_) begin();
    filling_->add(board, sequence, message);
  }
  /// Sends what was added since the last call, if anything.
  /// @param port  of any of the vehicle's boards: identifies the vehicle
  void flush(const std::string& port, Effects& effects) {
    if (filling_) send(port, effects);
  }

 private:
  /// Makes the list to be filled next: one that is free, or a new one.
  void begin();
  /// Sends the list that is being filled.
  void send(const std::string& port, Effects& effects);

  std::uint32_t vehicle_;
  std::vector<std::shared_ptr<BoardFrames>> lists_;
  std::shared_ptr<BoardFrames> filling_;  ///< null: nothing was added
};

}  // namespace cosiva::wire
