#include "cosiva/adapters/http/frame_mailbox.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {

bool FrameMailbox::put(std::size_t kind, LiveStreamFrame frame, bool keep_for_new_clients) {
  COSIVA_EXPECT(kind < LiveStream::kinds && frame.bytes != nullptr);
  const std::lock_guard lock{mutex_};
  if (keep_for_new_clients) items_[kind].kept = frame;
  items_[kind].newest = std::move(frame);
  return !std::exchange(awaits_take_, true);
}

FrameMailbox::Items FrameMailbox::take() {
  const std::lock_guard lock{mutex_};
  awaits_take_ = false;
  return std::exchange(items_, {});
}

}  // namespace cosiva::adapters
