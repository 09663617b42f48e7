#include "cosiva/wire/in_process/board_frames.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::wire {

void BoardFrames::add(Board board, std::uint8_t sequence, BoardMessage message) {
  frames_.push_back({board, sequence, module_link::as_read(std::move(message))});
}

std::span<const BoardFrames::Frame> BoardFrames::run_of_board(std::size_t first) const {
  COSIVA_EXPECT(first < frames_.size());
  std::size_t end = first + 1;
  while (end < frames_.size() && frames_[end].board == frames_[first].board) ++end;
  return frames().subspan(first, end - first);
}

void BoardFrames::fold(Digest& digest) const {
  // The content shows in the digests of the cores that act upon it.
  std::uint64_t kinds = frames_.size();
  for (const Frame& frame : frames_) kinds = kinds << 3U ^ frame.message.index() ^ frame.sequence;
  digest.add(kinds);
}

}  // namespace cosiva::wire
