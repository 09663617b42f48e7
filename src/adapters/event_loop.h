#pragma once

#include <chrono>
#include <functional>
#include <initializer_list>
#include <memory>

namespace boost::asio {
class io_context;
}  // namespace boost::asio

namespace cosiva::adapters {

/// A Boost.Asio loop: MQTT, sockets, timers, signals and children of a part run on it, in one thread, so that no lock
/// is needed. The page and Stop have loops of their own (LoopThread). Asio's headers stay in the .cpp files.
class EventLoop {
 public:
  EventLoop();  ///< Also ignores SIGPIPE: a failed write shows that a peer has left.
  ~EventLoop();
  EventLoop(const EventLoop&) = delete;
  EventLoop& operator=(const EventLoop&) = delete;

  /// Handles events until stop().
  void run();
  void stop();
  /// Handles events until `done()` is true; false when it is not within `limit`.
  bool run_until(const std::function<bool()>& done, std::chrono::milliseconds limit);
  /// Handles events for this long.
  void run_for(std::chrono::milliseconds duration);
  /// Runs `action` from the loop, after what is due now. Any thread may post.
  void post(std::function<void()> action);
  /// Calls `action` with the signal's number each time one of these arrives, from the loop.
  void on_signals(std::initializer_list<int> signals, std::function<void(int)> action);

  [[nodiscard]] boost::asio::io_context& context();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// A timer of the loop. Setting it again replaces the earlier action; destroying it cancels the action.
///
/// Invariant: while the timer waits it has an action to call.
class Timer {
 public:
  explicit Timer(EventLoop& loop);
  ~Timer();
  Timer(Timer&&) noexcept;
  Timer& operator=(Timer&&) noexcept;

  void after(std::chrono::nanoseconds delay, std::function<void()> action);
  /// Calls `action` every `period`, the first time one period from now. Periods missed on a stalled machine are
  /// skipped, never made up for in a burst.
  void every(std::chrono::nanoseconds period, std::function<void()> action);
  void cancel();

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cosiva::adapters
