#include "cosiva/adapters/loop_thread.h"

#include <gtest/gtest.h>
#include <sched.h>

#include <atomic>
#include <future>
#include <thread>
#include <utility>
#include <vector>

#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using testing::timeout;

TEST(LoopThread, handles_what_is_posted_on_its_own_thread_in_the_order_of_posting) {
  LoopThread thread;
  thread.start();
  std::promise<std::vector<int>> done;
  std::vector<int> order;
  bool on_it = false;
  for (int i = 0; i < 3; ++i) thread.loop().post([&, i] { order.push_back(i); });
  thread.loop().post([&] {
    on_it = thread.is_current();
    done.set_value(order);
  });
  auto result = done.get_future();
  ASSERT_EQ(result.wait_for(timeout), std::future_status::ready);
  EXPECT_EQ(result.get(), (std::vector{0, 1, 2}));
  EXPECT_TRUE(on_it);
  EXPECT_FALSE(thread.is_current());
}

TEST(LoopThread, goes_on_while_another_loop_is_blocked) {
  LoopThread blocked;
  LoopThread thread;
  blocked.start();
  thread.start();
  std::promise<void> release;
  std::promise<void> reached;
  std::promise<void> is_blocked;
  blocked.loop().post([&] {
    is_blocked.set_value();
    release.get_future().wait();
  });
  is_blocked.get_future().wait();
  thread.loop().post([&] { reached.set_value(); });
  EXPECT_EQ(reached.get_future().wait_for(timeout), std::future_status::ready);
  release.set_value();
}

TEST(LoopThread, handles_nothing_after_its_end) {
  std::atomic<int> handled{0};
  LoopThread thread;
  thread.start();
  thread.stop();
  thread.loop().post([&] { ++handled; });
  thread.stop();
  EXPECT_EQ(handled, 0);
}

TEST(LoopThread, ends_after_the_event_that_it_handles) {
  std::atomic<bool> finished{false};
  std::promise<void> begun;
  {
    LoopThread thread;
    thread.start();
    thread.loop().post([&] {
      begun.set_value();
      std::this_thread::sleep_for(20ms);
      finished = true;
    });
    begun.get_future().wait();
  }
  EXPECT_TRUE(finished);
}

TEST(LoopThread, can_be_started_again) {
  LoopThread thread;
  for (int i = 0; i < 2; ++i) {
    std::promise<void> reached;
    thread.start();
    thread.loop().post([&] { reached.set_value(); });
    EXPECT_EQ(reached.get_future().wait_for(timeout), std::future_status::ready);
    thread.stop();
  }
}

int policy() { return ::sched_getscheduler(0) & ~SCHED_RESET_ON_FORK; }

/// The policies of a loop's thread, and of a thread that it starts.
std::pair<int, int> policies_of(LoopThread::Priority priority) {
  LoopThread thread;
  thread.start(priority);
  std::promise<std::pair<int, int>> policies;
  thread.loop().post([&] {
    int started = -1;
    std::thread{[&] { started = policy(); }}.join();
    policies.set_value({policy(), started});
  });
  return policies.get_future().get();
}

TEST(LoopThread, runs_before_all_usual_threads_where_it_is_urgent_and_the_process_may_have_that) {
  const int before = policy();
  bool is_permitted = false;
  std::thread{[&] {
    const sched_param lowest{::sched_get_priority_min(SCHED_RR)};
    is_permitted = ::sched_setscheduler(0, SCHED_RR, &lowest) == 0;
  }}.join();
  EXPECT_EQ(policies_of(LoopThread::Priority::urgent), std::pair(is_permitted ? SCHED_RR : before, before));
  EXPECT_EQ(policies_of(LoopThread::Priority::usual), std::pair(before, before));
  EXPECT_EQ(policy(), before);
}

}  // namespace
}  // namespace cosiva::adapters
