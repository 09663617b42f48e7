#include "cosiva/adapters/outgoing_queue.h"

#include <algorithm>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

std::size_t bytes_of(const wire::Publish& message) { return message.topic.size() + message.payload.size(); }

}  // namespace

bool OutgoingQueue::is_command(const wire::Publish& message) {
  return message.qos > 0 || message.topic.ends_with("/order") || message.topic.ends_with("/instantActions");
}

void OutgoingQueue::push(wire::Publish message) {
  bytes_ += bytes_of(message);
  waiting_.push_back(std::move(message));
  make_room();
  COSIVA_EXPECT(waiting_.size() <= limits_.messages_max && bytes_ <= limits_.bytes_max);
}

const wire::Publish& OutgoingQueue::front() const {
  COSIVA_EXPECT(!waiting_.empty());
  return waiting_.front();
}

std::optional<wire::Publish> OutgoingQueue::pop() {
  if (waiting_.empty()) return std::nullopt;
  wire::Publish message = std::move(waiting_.front());
  waiting_.pop_front();
  bytes_ -= bytes_of(message);
  return message;
}

std::uint64_t OutgoingQueue::take_unreported() {
  COSIVA_EXPECT(reported_ <= dropped_.commands);
  return dropped_.commands - std::exchange(reported_, dropped_.commands);
}

void OutgoingQueue::make_room() {
  // From the oldest on, so that one pass finds all telemetry that has to go.
  for (auto oldest = waiting_.begin();
       oldest != waiting_.end() && (waiting_.size() > limits_.messages_max || bytes_ > limits_.bytes_max);) {
    if (is_command(*oldest)) {
      ++oldest;
      continue;
    }
    const auto at = oldest - waiting_.begin();
    drop(oldest);
    oldest = waiting_.begin() + at;
  }
  while (waiting_.size() > limits_.messages_max || bytes_ > limits_.bytes_max) drop(waiting_.begin());
}

void OutgoingQueue::drop(const std::deque<wire::Publish>::iterator& message) {
  lose(*message);
  bytes_ -= bytes_of(*message);
  waiting_.erase(message);
}

void OutgoingQueue::drop_unacknowledged() {
  std::erase_if(waiting_, [this](const wire::Publish& message) {
    if (message.qos > 0) return false;
    lose(message);
    bytes_ -= bytes_of(message);
    return true;
  });
}

}  // namespace cosiva::adapters
