#include "cosiva/adapters/loop_thread.h"

#include <future>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {

void LoopThread::start() {
  COSIVA_EXPECT(!thread_.joinable());
  std::promise<void> runs;
  // EventLoop::stop() has an effect only on a loop that runs already.
  loop_.post([&runs] { runs.set_value(); });
  thread_ = std::thread{[this] { loop_.run(); }};
  runs.get_future().wait();
}

void LoopThread::stop() {
  if (!thread_.joinable()) return;
  COSIVA_EXPECT(!is_current());
  loop_.stop();
  thread_.join();
}

}  // namespace cosiva::adapters
