#include "cosiva/virtual/server/registry/received_headers.h"

#include <gtest/gtest.h>

#include <limits>

namespace cosiva::virtual_side {
namespace {

wire::Header header(std::uint32_t id, std::string version = {}) {
  wire::Header made;
  made.header_id = id;
  made.version = std::move(version);
  return made;
}

TEST(ReceivedHeaders, show_the_messages_that_are_missing_between_two) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(5)), 0U) << "the first of the topic";
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(6)), 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(9)), 2U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(9)), 0U) << "the same again";
}

TEST(ReceivedHeaders, count_each_topic_by_itself) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(5)), 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::visualization, header(100)), 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(7)), 1U);
  EXPECT_EQ(headers.on_header(VehicleTopic::visualization, header(101)), 0U);
}

TEST(ReceivedHeaders, count_on_when_the_ids_wrap) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(std::numeric_limits<std::uint32_t>::max())), 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(1)), 1U) << "0 is missing";
}

TEST(ReceivedHeaders, do_not_take_a_large_step_as_lost_messages) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(0)), 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(999)), 998U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(1999)), 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(1998)), 0U) << "an old message";
}

TEST(ReceivedHeaders, start_again_with_a_session_while_the_version_stays) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(5, "2.0.0")), 0U);
  headers.on_session();
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(8)), 0U);
  EXPECT_EQ(headers.version(), "2.0.0");
}

TEST(ReceivedHeaders, keep_the_version_as_the_vehicle_writes_it) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.version(), "");
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(1, "v2")), 0U);
  EXPECT_EQ(headers.version(), "v2");
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(2, "2.1.0")), 0U);
  EXPECT_EQ(headers.version(), "2.1.0");
}

TEST(ReceivedHeaders, read_every_version_two_and_no_other) {
  for (const char* version : {"2", "2.0", "2.0.0", "2.1.0", "v2", "V2.1"})
    EXPECT_TRUE(ReceivedHeaders::readable(version)) << version;
  for (const char* version : {"", "v", "1.1.0", "3.0.0", "20.0", "2x", "two", "-2.0"})
    EXPECT_FALSE(ReceivedHeaders::readable(version)) << version;
  ReceivedHeaders headers;
  EXPECT_DEATH(static_cast<void>(headers.on_header(VehicleTopic::state, header(1, "3.0.0"))), "readable");
}

TEST(ReceivedHeaders, count_up_to_998_missing_messages) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(0)), 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(2)), 1U);
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(1000)), 997U);
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(1999)), 998U);
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(2999)), 0U) << "a step of 1000";
}

TEST(ReceivedHeaders, count_on_from_an_old_message) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(10)), 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(7)), 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(11)), 3U);
}

}  // namespace
}  // namespace cosiva::virtual_side
