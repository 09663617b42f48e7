#include "cosiva/adapters/http/frame_mailbox.h"

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <thread>

namespace cosiva::adapters {
namespace {

LiveStreamFrame frame(const std::string& bytes) { return {std::make_shared<const std::string>(bytes), false}; }

TEST(FrameMailbox, holds_the_newest_frame_of_each_kind) {
  FrameMailbox mailbox;
  EXPECT_TRUE(mailbox.put(1, frame("old"), false));
  EXPECT_FALSE(mailbox.put(1, frame("new"), false));
  EXPECT_FALSE(mailbox.put(2, frame("other"), false));
  const auto items = mailbox.take();
  EXPECT_EQ(*items[1].newest.bytes, "new");
  EXPECT_EQ(*items[2].newest.bytes, "other");
  EXPECT_EQ(items[0].newest.bytes, nullptr);
  EXPECT_EQ(items[1].kept.bytes, nullptr);
}

TEST(FrameMailbox, does_not_lose_a_frame_for_new_clients_to_a_newer_one_that_is_not) {
  FrameMailbox mailbox;
  EXPECT_TRUE(mailbox.put(4, frame("key"), true));
  EXPECT_FALSE(mailbox.put(4, frame("passing"), false));
  const auto items = mailbox.take();
  EXPECT_EQ(*items[4].kept.bytes, "key");
  EXPECT_EQ(*items[4].newest.bytes, "passing");
}

TEST(FrameMailbox, requests_a_take_again_once_it_was_emptied) {
  FrameMailbox mailbox;
  EXPECT_TRUE(mailbox.put(0, frame("a"), false));
  (void)mailbox.take();
  EXPECT_EQ(mailbox.take()[0].newest.bytes, nullptr);
  EXPECT_TRUE(mailbox.put(0, frame("b"), false));
}

TEST(FrameMailbox, loses_no_last_frame_between_two_threads) {
  FrameMailbox mailbox;
  constexpr int count = 20'000;
  std::thread maker{[&] {
    for (int i = 1; i <= count; ++i) (void)mailbox.put(3, frame(std::to_string(i)), false);
  }};
  int previous = 0;
  while (previous < count) {
    const auto items = mailbox.take();
    if (!items[3].newest.bytes) continue;
    const int number = std::stoi(*items[3].newest.bytes);
    EXPECT_GT(number, previous);
    previous = number;
  }
  maker.join();
}

}  // namespace
}  // namespace cosiva::adapters
