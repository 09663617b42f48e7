#include "cosiva/journal/store/retention.h"

namespace cosiva::journal {

std::size_t removable(const std::deque<SegmentSummary>& verified, const Keep& keep, SimTime now) {
  RecordNumber needed = 0;
  std::size_t bytes = 0;
  for (const SegmentSummary& segment : verified) {
    if (segment.checkpoint) needed = *segment.checkpoint;
    bytes += segment.bytes;
  }
  std::size_t count = 0;
  for (const SegmentSummary& segment : verified) {
    const bool old = keep.age && segment.last_at && now - *segment.last_at > *keep.age;
    if (segment.next > needed || (!old && !(keep.bytes && bytes > *keep.bytes))) break;
    bytes -= segment.bytes;
    ++count;
  }
  return count;
}

}  // namespace cosiva::journal
