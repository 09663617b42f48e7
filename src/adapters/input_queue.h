#pragma once

#include <cstdint>
#include <deque>
#include <functional>

#include "cosiva/wire/runtime/core.h"

namespace cosiva::adapters {

/// The inputs of one core, one at a time. Performing an effect may produce the next input at once (a publish that finds
/// the connection broken): that input waits its turn, because a runner's effects are valid only until the next input.
///
/// Invariant: while no input is handled, none waits; none waits once the queue is closed.
class InputQueue {
 public:
  /// Called when an input is durable, where its sender wants to know; else empty.
  using Durable = std::function<void()>;
  using Handle = std::function<void(const wire::Input&, Durable)>;
  explicit InputQueue(Handle handle) : handle_{std::move(handle)} {}

  /// Handles the input, now or after those that wait. Once closed, the input is dropped.
  void push(wire::Input input, Durable durable = {});
  /// Drops what waits and all that follows.
  void close();
  [[nodiscard]] bool closed() const { return closed_; }
  /// Whether no input waits for its turn.
  [[nodiscard]] bool empty() const { return waiting_.empty(); }
  /// The number of inputs handled.
  [[nodiscard]] std::uint64_t handled() const { return handled_; }

 private:
  struct Waiting {
    wire::Input input;
    Durable durable;
  };

  Handle handle_;
  std::deque<Waiting> waiting_;
  std::uint64_t handled_{0};
  bool handling_{false};
  bool closed_{false};
};

}  // namespace cosiva::adapters
