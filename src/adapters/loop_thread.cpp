#include "cosiva/adapters/loop_thread.h"

#include <sched.h>

#include <future>

#include "cosiva/base/expect.h"

namespace cosiva::adapters {
namespace {

/// The calling thread. What it starts is usual. Without the permission it works as any other.
void become_urgent() {
  sched_param lowest{};
  lowest.sched_priority = ::sched_get_priority_min(SCHED_RR);
  static_cast<void>(::sched_setscheduler(0, SCHED_RR | SCHED_RESET_ON_FORK, &lowest));
}

}  // namespace

void LoopThread::start(Priority priority) {
  COSIVA_EXPECT(!thread_.joinable());
  std::promise<void> runs;
  // EventLoop::stop() has an effect only on a loop that runs already.
  loop_.post([&runs] { runs.set_value(); });
  thread_ = std::thread{[this, priority] {
    if (priority == Priority::urgent) become_urgent();
    loop_.run();
  }};
  runs.get_future().wait();
}

void LoopThread::stop() {
  if (!thread_.joinable()) return;
  COSIVA_EXPECT(!is_current());
  loop_.stop();
  thread_.join();
}

}  // namespace cosiva::adapters
