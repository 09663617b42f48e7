#pragma once

#include <cstdint>
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

  /// How soon the thread gets a processor once it has something to do, on a machine with more work than processors.
  enum class Priority : std::uint8_t {
    usual,
    /// Before all usual threads of the machine (SCHED_RR, lowest priority), where the process may have that
    /// (CAP_SYS_NICE, RLIMIT_RTPRIO); otherwise usual. For what an operator waits for, with little work at any load. A
    /// nice value would not do: Linux divides the processors between sessions before it compares nice values.
    urgent,
  };

  [[nodiscard]] EventLoop& loop() { return loop_; }
  /// Begins to handle the events of the loop. The thread does not run yet (checked).
  void start(Priority priority = Priority::usual);
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
