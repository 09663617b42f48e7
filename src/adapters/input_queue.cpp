#include "cosiva/adapters/input_queue.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {

void InputQueue::push(wire::Input input, Durable durable) {
  if (closed_) return;
  COSIVA_EXPECT(handling_ || waiting_.empty());
  waiting_.push_back({std::move(input), std::move(durable)});
  if (std::exchange(handling_, true)) return;
  while (!waiting_.empty()) {
    Waiting next = std::move(waiting_.front());
    waiting_.pop_front();
    ++handled_;
    handle_(next.input, std::move(next.durable));
  }
  handling_ = false;
}

void InputQueue::close() {
  closed_ = true;
  waiting_.clear();
}

}  // namespace cosiva::adapters
