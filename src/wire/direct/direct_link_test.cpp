#include "cosiva/wire/direct/direct_link.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cosiva::wire {
namespace {

const DirectKey key{1, 2, 3};
const DirectKey other_key{1, 2, 4};

DirectLink link_of(const std::string& serial, std::uint64_t session = 1, const DirectKey& with = key) {
  return {{"CoSiVA", serial}, with, session};
}

TEST(DirectLink, carries_messages_with_the_name_of_their_sender) {
  DirectLink one = link_of("AIV1");
  DirectLink two = link_of("AIV2");
  const auto received = two.open(*one.seal(0, "hello"));
  ASSERT_TRUE(received);
  EXPECT_EQ(received->payload, "hello");
  EXPECT_EQ(received->sender, (VehicleId{"CoSiVA", "AIV1"}));
  EXPECT_EQ(one.counters().sent, 1U);
  EXPECT_EQ(two.counters(), (DirectLink::Counters{.accepted = 1}));
}

TEST(DirectLink, counts_and_ignores_what_is_forged_replayed_malformed_or_its_own) {
  DirectLink one = link_of("AIV1");
  DirectLink two = link_of("AIV2");
  DirectLink forger = link_of("AIV1", 99, other_key);
  const std::string good = *one.seal(0, "hello");
  EXPECT_TRUE(two.open(good));
  EXPECT_FALSE(two.open(good));
  EXPECT_FALSE(two.open(*forger.seal(0, "hello")));
  EXPECT_FALSE(two.open("CV2X"));
  EXPECT_FALSE(two.open(""));
  EXPECT_FALSE(two.open(*two.seal(0, "mine")));
  EXPECT_EQ(two.counters(),
            (DirectLink::Counters{.sent = 1, .accepted = 1, .own = 1, .malformed = 2, .forged = 1, .replayed = 1}));
  EXPECT_EQ(two.counters().refused(), 4U);
  EXPECT_TRUE(two.open(*one.seal(0, "next"))) << "a forged session has no effect on the window";
}

TEST(DirectLink, continues_with_a_participant_that_was_started_again) {
  DirectLink two = link_of("AIV2");
  DirectLink before = link_of("AIV1", 1000);
  std::vector<std::string> recorded;
  for (int i = 0; i < 100; ++i) recorded.push_back(*before.seal(0, "before"));
  for (const std::string& datagram : recorded) EXPECT_TRUE(two.open(datagram));
  DirectLink after = link_of("AIV1", 2000);
  EXPECT_TRUE(two.open(*after.seal(0, "after")));
  for (const std::string& datagram : recorded) EXPECT_FALSE(two.open(datagram));
  EXPECT_TRUE(two.open(*after.seal(0, "after")));
}

TEST(DirectLink, accepts_no_more_senders_than_it_can_keep) {
  DirectLink link = link_of("AIV1");
  for (std::size_t i = 0; i < DirectLink::senders_max; ++i) {
    DirectLink sender = link_of("S" + std::to_string(i));
    ASSERT_TRUE(link.open(*sender.seal(0, "x")));
  }
  DirectLink late = link_of("late");
  EXPECT_FALSE(link.open(*late.seal(0, "x")));
  EXPECT_EQ(link.counters().crowded, 1U);
  DirectLink known = link_of("S0", 2);
  EXPECT_TRUE(link.open(*known.seal(0, "x")));
}

TEST(DirectLink, sends_no_message_that_is_too_long) {
  DirectLink link = link_of("AIV1");
  EXPECT_FALSE(link.seal(0, std::string(datagram_bytes_max, 'x')));
  EXPECT_EQ(link.counters().sent, 0U);
}

}  // namespace
}  // namespace cosiva::wire
