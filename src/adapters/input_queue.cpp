#include "cosiva/adapters/input_queue.h"

#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {

void InputQueue::push(wire::Input input) {
  if (closed_) return;
  COSIVA_EXPECT(handling_ || waiting_.empty());
  waiting_.push_back(std::move(input));
  if (std::exchange(handling_, true)) return;
  while (!waiting_.empty()) {
    const wire::Input next = std::move(waiting_.front());
    waiting_.pop_front();
    ++handled_;
    handle_(next);
  }
  handling_ = false;
}

void InputQueue::close() {
  closed_ = true;
  waiting_.clear();
}

}  // namespace cosiva::adapters
