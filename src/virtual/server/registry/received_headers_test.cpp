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
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(5)).missing, 0U) << "the first of the topic";
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(6)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(9)).missing, 2U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(9)).missing, 0U) << "the same again";
}

TEST(ReceivedHeaders, count_each_topic_by_itself) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(5)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::visualization, header(100)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(7)).missing, 1U);
  EXPECT_EQ(headers.on_header(VehicleTopic::visualization, header(101)).missing, 0U);
}

TEST(ReceivedHeaders, count_on_when_the_ids_wrap) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(std::numeric_limits<std::uint32_t>::max())).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(1)).missing, 1U) << "0 is missing";
}

TEST(ReceivedHeaders, do_not_take_a_large_step_as_lost_messages) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(0)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(999)).missing, 998U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(1999)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(1998)).missing, 0U) << "an old message";
}

TEST(ReceivedHeaders, start_again_with_a_session_while_the_version_stays) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(5, "2.0.0")).missing, 0U);
  headers.on_session();
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(8)).missing, 0U);
  EXPECT_EQ(headers.version(), "2.0.0");
}

TEST(ReceivedHeaders, keep_the_version_as_the_vehicle_writes_it) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.version(), "");
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(1, "v2")).missing, 0U);
  EXPECT_EQ(headers.version(), "v2");
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(2, "2.1.0")).missing, 0U);
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
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(0)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(2)).missing, 1U);
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(1000)).missing, 997U);
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(1999)).missing, 998U);
  EXPECT_EQ(headers.on_header(VehicleTopic::connection, header(2999)).missing, 0U) << "a step of 1000";
}

TEST(ReceivedHeaders, count_no_message_as_missing_that_arrives_late) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(10)), (ReceivedHeaders::Gap{0, false}));
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(13)), (ReceivedHeaders::Gap{2, false}));
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(11)), (ReceivedHeaders::Gap{0, true}));
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(11)), (ReceivedHeaders::Gap{0, false})) << "a copy of it";
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(14)), (ReceivedHeaders::Gap{0, false}))
      << "10 to 14 without 12: one is missing in all";
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(12)), (ReceivedHeaders::Gap{0, true}));
}

TEST(ReceivedHeaders, count_on_from_the_newest_message_after_an_old_one) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(10)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(7)), (ReceivedHeaders::Gap{0, false}));
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(11)).missing, 0U) << "8 and 9 are before the first one";
}

TEST(ReceivedHeaders, know_which_of_the_last_64_have_not_arrived) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(100)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(165)).missing, 64U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(101)), (ReceivedHeaders::Gap{0, true}));
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(166)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(102)), (ReceivedHeaders::Gap{0, true})) << "64 behind";
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(101)), (ReceivedHeaders::Gap{0, false}))
      << "65 behind: the vehicle has restarted";
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(102)), (ReceivedHeaders::Gap{0, false}));
}

TEST(ReceivedHeaders, know_nothing_of_a_session_before) {
  ReceivedHeaders headers;
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(5)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(7)).missing, 1U);
  headers.on_session();
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(7)).missing, 0U);
  EXPECT_EQ(headers.on_header(VehicleTopic::state, header(6)), (ReceivedHeaders::Gap{0, false}));
}

}  // namespace
}  // namespace cosiva::virtual_side
