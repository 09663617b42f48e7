#include "cosiva/virtual/server/registry/sender_watch.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;

/// One or two programs that send their states ten times a second.
class Senders : public testing::Test {
 protected:
  void send(std::uint32_t id, SimDuration clock_off = {}) {
    watch.on_message(VehicleTopic::state, {id, now + clock_off, "2.1.0", "Acme", "1"}, now);
    now += 50ms;
  }
  [[nodiscard]] bool several() const { return watch.several_since(now).has_value(); }

  SenderWatch watch;
  SimTime now{1000s};
};

TEST_F(Senders, that_number_without_regard_to_each_other_are_two) {
  const SimTime second = now + 150ms;
  send(500);
  send(3);
  EXPECT_FALSE(several()) << "a restart";
  send(501);
  send(4);
  EXPECT_TRUE(several());
  EXPECT_LE(*watch.several_since(now), second);
}

TEST_F(Senders, are_two_where_their_numbers_are_close_or_their_clocks_differ) {
  for (const std::uint32_t id : {10U, 3U, 11U, 4U}) send(id);
  EXPECT_TRUE(several());
  watch = {};
  for (std::uint32_t i = 0; i < 4; ++i) {
    send(700 + i, 3600s);
    send(3 + i);
  }
  EXPECT_TRUE(several());
}

TEST_F(Senders, are_one_that_is_restarted_or_whose_messages_overtake_each_other) {
  for (const std::uint32_t id : {500U, 0U, 1U, 2U}) send(id);
  EXPECT_FALSE(several());
  watch.on_session();
  for (std::uint32_t i = 10; i < 60; i += 3) {
    send(i + 1);
    send(i, -100ms);
    send(i + 2);
  }
  EXPECT_FALSE(several());
}

TEST_F(Senders, are_one_again_after_five_seconds_without_the_other) {
  for (const std::uint32_t id : {500U, 3U, 501U, 4U}) send(id);
  for (std::uint32_t id = 5; id < 100; ++id) send(id);
  EXPECT_TRUE(several());
  for (std::uint32_t id = 100; id < 108; ++id) send(id);
  EXPECT_FALSE(several());
}

TEST_F(Senders, of_wrapped_numbers_are_one) {
  for (const std::uint32_t id : {4294967294U, 4294967295U, 0U, 1U}) send(id);
  EXPECT_FALSE(several());
}

}  // namespace
}  // namespace cosiva::virtual_side
