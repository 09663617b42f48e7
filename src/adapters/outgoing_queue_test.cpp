#include "cosiva/adapters/outgoing_queue.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace cosiva::adapters {
namespace {

using ::testing::ElementsAre;

wire::Publish telemetry(const std::string& payload) { return {"uagv/v2/CoSiVA/AIV1/state", payload, 0, false}; }
wire::Publish order(const std::string& payload) { return {"uagv/v2/CoSiVA/AIV1/order", payload, 0, false}; }

std::vector<std::string> taken(OutgoingQueue& queue) {
  std::vector<std::string> payloads;
  while (auto message = queue.pop()) payloads.push_back(message->payload);
  return payloads;
}

TEST(OutgoingQueue, gives_messages_in_their_order) {
  OutgoingQueue queue{{}};
  for (const char* payload : {"a", "b", "c"}) queue.push(telemetry(payload));
  EXPECT_EQ(queue.size(), 3U);
  EXPECT_THAT(taken(queue), ElementsAre("a", "b", "c"));
  EXPECT_TRUE(queue.empty());
  EXPECT_EQ(queue.bytes(), 0U);
}

TEST(OutgoingQueue, drops_the_oldest_telemetry_first_and_counts_it) {
  OutgoingQueue queue{{.messages_max = 3}};
  queue.push(telemetry("old"));
  queue.push(order("order 1"));
  queue.push(telemetry("older"));
  queue.push(order("order 2"));
  queue.push(telemetry("new"));
  EXPECT_THAT(taken(queue), ElementsAre("order 1", "order 2", "new"));
  EXPECT_EQ(queue.dropped().telemetry, 2U);
  EXPECT_EQ(queue.dropped().commands, 0U);
}

TEST(OutgoingQueue, counts_commands_that_have_to_be_dropped_separately) {
  OutgoingQueue queue{{.messages_max = 2}};
  for (const char* payload : {"1", "2", "3"}) queue.push(order(payload));
  EXPECT_THAT(taken(queue), ElementsAre("2", "3"));
  EXPECT_EQ(queue.dropped().commands, 1U);
  EXPECT_EQ(queue.take_unreported(), 1U);
  EXPECT_EQ(queue.take_unreported(), 0U);
  queue.push(order("4"));
  queue.push(order("5"));
  queue.push(telemetry("6"));
  EXPECT_THAT(taken(queue), ElementsAre("4", "5")) << "telemetry displaces no order";
  EXPECT_EQ(queue.dropped().telemetry, 1U);
}

TEST(OutgoingQueue, is_bounded_in_bytes_however_many_messages_are_pushed) {
  OutgoingQueue queue{{.bytes_max = 100'000}};
  for (int i = 0; i < 10'000; ++i) {
    queue.push(telemetry(std::string(2'500, 'x')));
    ASSERT_LE(queue.bytes(), 100'000U);
  }
  EXPECT_EQ(queue.size(), 39U) << "of 2 525 bytes each";
  EXPECT_EQ(queue.dropped().telemetry, 9'961U);
  queue.push(order(std::string(200'000, 'x')));
  EXPECT_EQ(queue.size(), 0U) << "a message larger than the queue";
  EXPECT_EQ(queue.dropped().commands, 1U);
}

TEST(OutgoingQueue, loses_telemetry_and_orders_of_QoS_0_with_the_connection) {
  OutgoingQueue queue{{}};
  queue.push(telemetry("state"));
  queue.push(order("order"));
  queue.push({"cosiva/v1/zone", "zone", 1, true});
  queue.drop_unacknowledged();
  EXPECT_EQ(queue.dropped().telemetry, 1U);
  EXPECT_EQ(queue.dropped().commands, 1U);
  EXPECT_EQ(queue.bytes(), 18U);
  EXPECT_THAT(taken(queue), ElementsAre("zone"));
}

TEST(OutgoingQueue, distinguishes_commands_from_telemetry) {
  EXPECT_TRUE(OutgoingQueue::is_command({"uagv/v2/A/B/instantActions", "", 0, false}));
  EXPECT_TRUE(OutgoingQueue::is_command({"uagv/v2/A/B/order", "", 0, false}));
  EXPECT_TRUE(OutgoingQueue::is_command({"uagv/v2/A/B/connection", "", 1, true}));
  EXPECT_FALSE(OutgoingQueue::is_command({"uagv/v2/A/B/visualization", "", 0, false}));
}

}  // namespace
}  // namespace cosiva::adapters
