#pragma once

#include <array>
#include <cstddef>
#include <mutex>

#include "cosiva/adapters/http/live_stream.h"

namespace cosiva::adapters {

/// Frames in transit from the thread that makes them to the thread that sends them: the newest of each kind, so that
/// they need no more memory however long the second thread is busy.
///
/// Invariant: between a put() that returned true and the take() after it, further calls of put() return false.
class FrameMailbox {
 public:
  struct Item {
    LiveStreamFrame newest;  ///< without bytes: none
    LiveStreamFrame kept;    ///< the newest of those to be stored for new clients; without bytes: none
  };
  using Items = std::array<Item, LiveStream::kinds>;

  /// @return  whether a take() has to be arranged: none is arranged
  [[nodiscard]] bool put(std::size_t kind, LiveStreamFrame frame, bool keep_for_new_clients);
  /// Empties the mailbox.
  [[nodiscard]] Items take();

 private:
  std::mutex mutex_;
  Items items_;
  bool awaits_take_{false};
};

}  // namespace cosiva::adapters
