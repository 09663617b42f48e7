#include "cosiva/wire/direct/replay_window.h"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <limits>
#include <set>

namespace cosiva::wire {
namespace {

TEST(ReplayWindow, accepts_each_number_once) {
  ReplayWindow window;
  EXPECT_TRUE(window.accept(1, 1));
  EXPECT_FALSE(window.accept(1, 1));
  EXPECT_TRUE(window.accept(1, 2));
  EXPECT_FALSE(window.accept(1, 1));
  EXPECT_FALSE(window.accept(1, 0)) << "no datagram has this number";
}

TEST(ReplayWindow, accepts_a_number_that_63_others_have_overtaken_and_no_older_one) {
  ReplayWindow window;
  EXPECT_TRUE(window.accept(1, 100));
  EXPECT_TRUE(window.accept(1, 100 - 63));
  EXPECT_FALSE(window.accept(1, 100 - 64));
  EXPECT_FALSE(window.accept(1, 100 - 63));
}

TEST(ReplayWindow, continues_with_a_restarted_sender_and_refuses_its_earlier_session) {
  ReplayWindow window;
  EXPECT_TRUE(window.accept(10, 5000));
  EXPECT_TRUE(window.accept(11, 1)) << "started again";
  EXPECT_FALSE(window.accept(10, 5001)) << "recorded from the session before";
  EXPECT_FALSE(window.accept(11, 1));
  EXPECT_TRUE(window.accept(11, 2));
}

TEST(ReplayWindow, continues_over_any_gap) {
  ReplayWindow window;
  constexpr auto last = std::numeric_limits<std::uint64_t>::max();
  EXPECT_TRUE(window.accept(1, 1));
  EXPECT_TRUE(window.accept(1, last - 1));
  EXPECT_FALSE(window.accept(1, 1));
  EXPECT_TRUE(window.accept(1, last));
  EXPECT_FALSE(window.accept(1, last));
}

TEST(ReplayWindow, is_as_a_set_of_all_accepted_numbers_that_are_near_the_highest) {
  EXPECT_TRUE(rc::check("window", [] {
    ReplayWindow window;
    std::set<std::uint64_t> accepted;
    std::uint64_t highest = 0;
    for (const int step : *rc::gen::container<std::vector<int>>(200, rc::gen::inRange(-80, 81))) {
      const auto number = static_cast<std::int64_t>(highest) + step;
      if (number < 1) continue;
      const auto sequence = static_cast<std::uint64_t>(number);
      const bool fresh = sequence + ReplayWindow::width > highest && accepted.insert(sequence).second;
      RC_ASSERT(window.accept(1, sequence) == fresh);
      if (fresh) highest = std::max(highest, sequence);
    }
  }));
}

}  // namespace
}  // namespace cosiva::wire
