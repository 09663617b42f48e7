#include "cosiva/adapters/event_loop.h"

#include <gtest/gtest.h>

#include <csignal>
#include <thread>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using testing::timeout;

TEST(Timer, set_again_drops_the_earlier_action) {
  EventLoop loop;
  Timer timer{loop};
  int first = 0;
  int second = 0;
  timer.after(1ms, [&] { ++first; });
  timer.after(1ms, [&] { ++second; });
  EXPECT_TRUE(loop.run_until([&] { return second == 1; }, timeout));
  loop.run_for(20ms);
  EXPECT_EQ(first, 0);
  EXPECT_EQ(second, 1);
}

TEST(Timer, destroyed_never_fires) {
  EventLoop loop;
  int fired = 0;
  {
    Timer{loop}.after(1ms, [&] { ++fired; });
  }
  loop.run_for(20ms);
  EXPECT_EQ(fired, 0);
}

TEST(Timer, repeats_until_it_is_cancelled_from_its_own_action) {
  EventLoop loop;
  Timer timer{loop};
  int heartbeats = 0;
  timer.every(1ms, [&] {
    if (++heartbeats == 5) timer.cancel();
  });
  EXPECT_TRUE(loop.run_until([&] { return heartbeats == 5; }, timeout));
  loop.run_for(20ms);
  EXPECT_EQ(heartbeats, 5);
}

TEST(Timer, skips_the_periods_a_stalled_loop_missed) {
  EventLoop loop;
  Timer timer{loop};
  int heartbeats = 0;
  timer.every(20ms, [&] {
    if (++heartbeats == 1) std::this_thread::sleep_for(210ms);  // ten periods
  });
  EXPECT_TRUE(loop.run_until([&] { return heartbeats == 1; }, timeout));
  const auto stalled = std::chrono::steady_clock::now();
  EXPECT_TRUE(loop.run_until([&] { return heartbeats == 3; }, timeout));
  // A burst of made-up periods would be over at once; two regular ones need at least one whole period.
  EXPECT_GE(std::chrono::steady_clock::now() - stalled, 20ms);
}

TEST(EventLoop, hands_over_signals_one_by_one) {
  EventLoop loop;
  int detected = 0;
  loop.on_signals({SIGUSR1}, [&](int signal) { detected += signal == SIGUSR1 ? 1 : 0; });
  ::raise(SIGUSR1);
  EXPECT_TRUE(loop.run_until([&] { return detected == 1; }, timeout));
  ::raise(SIGUSR1);
  EXPECT_TRUE(loop.run_until([&] { return detected == 2; }, timeout));
}

TEST(WallClock, gives_utc_and_never_goes_back) {
  const WallClock clock;
  const auto wall = std::chrono::system_clock::now().time_since_epoch();
  SimTime last = clock.now();
  EXPECT_LT(std::chrono::abs(last.time_since_epoch() - wall), 10s);
  for (int i = 0; i < 10'000; ++i) {
    const SimTime now = clock.now();
    EXPECT_GE(now, last);
    last = now;
  }
}

}  // namespace
}  // namespace cosiva::adapters
