#pragma once

#include <functional>
#include <thread>

#include "cosiva/adapters/event_loop.h"

namespace cosiva::adapters {

/// An event loop on a thread of its own: for work that must not wait for the loop of the core, nor delay it. Other
/// threads reach the objects of this loop with EventLoop::post() only, and pass values that do not change any more.
///
/// Invariant: from start() to stop() the loop runs on the thread, and otherwise nowhere: before and after, its objects
/// belong to the owner of this one.
class LoopThread {
 public:
  LoopThread() = default;
  ~LoopThread() { stop(); }
  LoopThread(const LoopThread&) = delete;
  LoopThread& operator=(const LoopThread&) = delete;

  [[nodiscard]] EventLoop& loop() { return loop_; }
  /// Begins to handle the events of the loop. The thread does not run yet (checked).
  void start();
  /// Ends the thread after the event that the thread handles now; what was posted and not handled waits for the
  /// next start. Does nothing where the thread does not run. Not for the thread itself (checked).
  void stop();
  /// Whether the caller is this thread.
  [[nodiscard]] bool is_current() const { return thread_.get_id() == std::this_thread::get_id(); }

 private:
  EventLoop loop_;
  std::thread thread_;
};

}  // namespace cosiva::adapters
