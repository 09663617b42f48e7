#include "cosiva/virtual/server/context/server_link.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

SimTime at_ms(int ms) { return SimTime{std::chrono::milliseconds{ms}}; }

TEST(ServerLink, sends_no_heartbeat_while_the_link_is_down) {
  ServerLink link;
  EXPECT_FALSE(link.take_heartbeat(at_ms(0)));
  link.came_up(at_ms(0));
  EXPECT_TRUE(link.take_heartbeat(at_ms(0)));
  link.went_down();
  EXPECT_FALSE(link.take_heartbeat(at_ms(1000)));
}

TEST(ServerLink, numbers_its_heartbeats_and_makes_one_in_each_period) {
  ServerLink link;
  link.came_up(at_ms(50));
  EXPECT_EQ(link.take_heartbeat(at_ms(50)), R"({"headerId":0,"timestamp":"1970-01-01T00:00:00.050Z"})");
  EXPECT_FALSE(link.take_heartbeat(at_ms(149)));
  EXPECT_EQ(link.take_heartbeat(at_ms(150)), R"({"headerId":1,"timestamp":"1970-01-01T00:00:00.150Z"})");
}

TEST(ServerLink, catches_up_by_one_heartbeat_after_a_long_pause) {
  ServerLink link;
  link.came_up(at_ms(0));
  EXPECT_TRUE(link.take_heartbeat(at_ms(0)));
  EXPECT_TRUE(link.take_heartbeat(at_ms(5000)));
  EXPECT_TRUE(link.take_heartbeat(at_ms(5000)));
  EXPECT_FALSE(link.take_heartbeat(at_ms(5050)));
}

TEST(ServerLink, is_synchronised_anew_each_time_the_link_comes_up) {
  ServerLink link;
  link.came_up(at_ms(0));
  EXPECT_FALSE(link.synchronised());
  link.set_synchronised();
  EXPECT_TRUE(link.synchronised());
  link.went_down();
  EXPECT_FALSE(link.synchronised());
  link.came_up(at_ms(700));
  EXPECT_FALSE(link.synchronised());
  EXPECT_EQ(link.up_since(), at_ms(700));
}

TEST(ServerLink, is_down_at_first_and_up_from_one_event_to_the_other) {
  ServerLink link;
  EXPECT_FALSE(link.up());
  EXPECT_FALSE(link.synchronised());
  link.came_up(at_ms(0));
  EXPECT_TRUE(link.up());
  link.went_down();
  EXPECT_FALSE(link.up());
}

TEST(ServerLink, makes_a_heartbeat_at_once_when_the_link_comes_up_again_and_counts_on) {
  ServerLink link;
  link.came_up(at_ms(0));
  EXPECT_TRUE(link.take_heartbeat(at_ms(0)));
  link.went_down();
  link.came_up(at_ms(30));
  EXPECT_EQ(link.take_heartbeat(at_ms(30)), R"({"headerId":1,"timestamp":"1970-01-01T00:00:00.030Z"})");
  EXPECT_FALSE(link.take_heartbeat(at_ms(129)));
  EXPECT_TRUE(link.take_heartbeat(at_ms(130)));
}

TEST(ServerLink, makes_its_heartbeats_in_a_fixed_grid_where_they_are_a_little_late) {
  ServerLink link;
  link.came_up(at_ms(0));
  EXPECT_TRUE(link.take_heartbeat(at_ms(0)));
  EXPECT_TRUE(link.take_heartbeat(at_ms(160)));
  EXPECT_FALSE(link.take_heartbeat(at_ms(199)));
  EXPECT_TRUE(link.take_heartbeat(at_ms(200)));
}

TEST(ServerLink, reports_once_that_messages_have_arrived_since_its_last_call) {
  ServerLink link;
  link.on_message();
  EXPECT_FALSE(link.take_message_received()) << "the link is down";
  link.came_up(at_ms(0));
  EXPECT_FALSE(link.take_message_received());
  link.on_message();
  link.on_message();
  EXPECT_TRUE(link.take_message_received());
  EXPECT_FALSE(link.take_message_received());
  link.on_message();
  link.went_down();
  EXPECT_FALSE(link.take_message_received());
}

TEST(ServerLinkDeathTest, refuses_to_be_synchronised_while_the_link_is_down) {
  ServerLink link;
  EXPECT_DEATH(link.set_synchronised(), "up_");
}

TEST(ServerLinkDeathTest, refuses_events_that_change_nothing) {
  ServerLink link;
  EXPECT_DEATH(link.went_down(), "up_");
  link.came_up(at_ms(0));
  EXPECT_DEATH(link.came_up(at_ms(1)), "!up_");
  link.set_synchronised();
  EXPECT_DEATH(link.set_synchronised(), "!synchronised_");
}

}  // namespace
}  // namespace cosiva::virtual_side
