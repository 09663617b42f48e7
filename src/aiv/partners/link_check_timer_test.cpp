#include "cosiva/aiv/partners/link_check_timer.h"

#include <gtest/gtest.h>

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;

SimTime at_ms(int ms) { return SimTime{milliseconds{ms}}; }

TEST(LinkCheckTimer, checks_a_link_that_has_been_quiet_for_200_ms_and_again_every_100_ms) {
  LinkCheckTimer timer;
  int checks = 0;
  for (int ms = 0; ms <= 500; ms += 20) checks += timer.due(at_ms(ms), milliseconds{ms}) ? 1 : 0;
  EXPECT_EQ(checks, 4) << "at 200, 300, 400 and 500 ms";
}

TEST(LinkCheckTimer, checks_no_link_on_which_heartbeats_arrive) {
  LinkCheckTimer timer;
  for (int ms = 0; ms <= 10'000; ms += 20) EXPECT_FALSE(timer.due(at_ms(ms), milliseconds{ms % 200}));
}

TEST(LinkCheckTimer, checks_no_link_that_was_never_up) {
  LinkCheckTimer timer;
  EXPECT_FALSE(timer.due(at_ms(10'000), std::nullopt));
}

TEST(LinkCheckTimer, continues_after_the_clock_was_set_back) {
  LinkCheckTimer timer;
  EXPECT_TRUE(timer.due(at_ms(100'000), milliseconds{200}));
  EXPECT_TRUE(timer.due(at_ms(1'000), milliseconds{200}));
}

}  // namespace
}  // namespace cosiva::aiv
