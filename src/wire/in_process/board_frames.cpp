#include "cosiva/wire/in_process/board_frames.h"

#include "cosiva/base/expect.h"
#include "cosiva/wire/module_link/module_link.h"

namespace cosiva::wire {

void BoardFrames::add(Board board, std::uint8_t sequence, const BoardMessage& message) {
  if (count_ == frames_.size()) frames_.emplace_back();
  Frame& frame = frames_[count_++];
  frame.board = board;
  frame.sequence = sequence;
  frame.message = message;
  module_link::change_to_read(frame.message);
}

std::span<const BoardFrames::Frame> BoardFrames::run_of_board(std::size_t first) const {
  COSIVA_EXPECT(first < count_);
  std::size_t end = first + 1;
  while (end < count_ && frames_[end].board == frames_[first].board) ++end;
  return frames().subspan(first, end - first);
}

void BoardFrames::fold(Digest& digest) const {
  // The content shows in the digests of the cores that act upon it.
  std::uint64_t kinds = count_;
  for (const Frame& frame : frames()) kinds = kinds << 3U ^ frame.message.index() ^ frame.sequence;
  digest.add(kinds);
}

}  // namespace cosiva::wire
