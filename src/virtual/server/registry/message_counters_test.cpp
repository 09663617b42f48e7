#include "cosiva/virtual/server/registry/message_counters.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

TEST(MessageCounters, count_each_kind_by_itself) {
  MessageCounters counters;
  for (int i = 0; i < 3; ++i) counters.on_message();
  counters.on_missed(2);
  counters.on_missed(5);
  counters.on_refused();
  counters.on_outdated();
  counters.on_outdated();
  EXPECT_EQ(counters.messages(), 3U);
  EXPECT_EQ(counters.missed(), 7U);
  EXPECT_EQ(counters.refused(), 1U);
  EXPECT_EQ(counters.outdated(), 2U);
}

TEST(MessageCounters, count_dropped_messages_among_the_received_ones) {
  MessageCounters counters;
  counters.on_message();
  counters.on_dropped();
  EXPECT_EQ(counters.dropped(), 1U);
  EXPECT_DEATH(counters.on_dropped(), "dropped_");
}

TEST(MessageCounters, count_a_refused_v2x_message_although_it_is_not_one_of_the_messages) {
  MessageCounters counters;
  counters.on_v2x_refused();
  EXPECT_EQ(counters.messages(), 0U);
  EXPECT_EQ(counters.refused(), 1U);
}

TEST(MessageCounters, count_no_message_as_missing_that_arrives_late) {
  MessageCounters counters;
  counters.on_message();
  counters.on_missed(3);
  counters.on_message();
  counters.on_late();
  EXPECT_EQ(counters.missed(), 2U);
  counters.on_late();
  counters.on_late();
  EXPECT_DEATH(counters.on_late(), "missed_ >= 1");
}

TEST(MessageCounters, refuse_to_count_more_than_the_messages_themselves) {
  MessageCounters counters;
  EXPECT_DEATH(counters.on_refused(), "refused_ <= messages_");
  EXPECT_DEATH(counters.on_outdated(), "outdated_ <= messages_");
  EXPECT_DEATH(counters.on_missed(1), "missed_ <= messages_");
  counters.on_message();
  EXPECT_DEATH(counters.on_missed(999), "missed < missed_per_message_max");
}

TEST(MessageCounters, permit_each_message_to_be_refused_and_outdated) {
  MessageCounters counters;
  counters.on_message();
  counters.on_refused();
  counters.on_outdated();
  counters.on_missed(998);
  EXPECT_EQ(counters.refused(), 1U);
  EXPECT_EQ(counters.outdated(), 1U);
  EXPECT_EQ(counters.missed(), 998U);
  EXPECT_DEATH(counters.on_refused(), "refused_ <= messages_");
  EXPECT_DEATH(counters.on_outdated(), "outdated_ <= messages_");
  EXPECT_DEATH(counters.on_missed(2), "missed_ <= messages_") << "998 and 2 are more than 999 for one message";
}

TEST(MessageCounters, add_refused_v2x_messages_to_the_refused_ones) {
  MessageCounters counters;
  counters.on_message();
  counters.on_refused();
  counters.on_v2x_refused();
  counters.on_v2x_refused();
  EXPECT_EQ(counters.refused(), 3U);
  EXPECT_EQ(counters.messages(), 1U);
}

}  // namespace
}  // namespace cosiva::virtual_side
