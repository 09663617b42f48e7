#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <optional>

#include "cosiva/wire/runtime/core.h"

namespace cosiva::adapters {

/// Messages that wait for a connection, or for a broker that reads slowly. When there are too many, the oldest
/// telemetry (QoS 0) is dropped first: newer telemetry replaces it. Orders, instant actions and messages of QoS 1 are
/// dropped only where nothing else is left, and are counted separately.
///
/// Invariant: at most messages_max messages of together at most bytes_max bytes wait, in the order of their push.
class OutgoingQueue {
 public:
  struct Limits {
    std::size_t bytes_max{std::size_t{8} << 20U};  ///< of topics and payloads
    std::size_t messages_max{20'000};
  };
  struct Dropped {
    std::uint64_t telemetry{0};
    std::uint64_t commands{0};  ///< orders, instant actions and messages of QoS 1
  };

  explicit OutgoingQueue(Limits limits) : limits_{limits} {}

  void push(wire::Publish message);
  /// The oldest message, which pop() takes; the queue is not empty (checked).
  [[nodiscard]] const wire::Publish& front() const;
  /// The oldest message; nothing where the queue is empty.
  [[nodiscard]] std::optional<wire::Publish> pop();
  /// Counts a message that cannot be queued: it has QoS 0, and there is no connection.
  void lose(const wire::Publish& message) { ++(is_command(message) ? dropped_.commands : dropped_.telemetry); }
  /// The number of commands that were dropped since the last call.
  [[nodiscard]] std::uint64_t take_unreported();
  /// The connection is lost: what was not sent with QoS 0 is lost with it, as the standard specifies.
  void drop_unacknowledged();

  [[nodiscard]] bool empty() const { return waiting_.empty(); }
  [[nodiscard]] std::size_t size() const { return waiting_.size(); }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  [[nodiscard]] const Dropped& dropped() const { return dropped_; }

  /// An order, an instant action or a message of QoS 1 or 2.
  [[nodiscard]] static bool is_command(const wire::Publish& message);

 private:
  void make_room();
  void drop(const std::deque<wire::Publish>::iterator& message);

  Limits limits_;
  std::deque<wire::Publish> waiting_;
  std::size_t bytes_{0};
  Dropped dropped_;
  std::uint64_t reported_{0};  ///< of the dropped commands
};

}  // namespace cosiva::adapters
