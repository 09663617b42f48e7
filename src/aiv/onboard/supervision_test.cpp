#include "cosiva/aiv/onboard/supervision.h"

#include <gtest/gtest.h>

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;

SimTime at_ms(int ms) { return SimTime{milliseconds{ms}}; }

TEST(Supervision, takes_a_broker_for_lost_from_the_beginning_and_half_a_second_after_its_last_message) {
  Supervision supervision{milliseconds{500}};
  EXPECT_TRUE(supervision.broker_lost(at_ms(0)));
  EXPECT_FALSE(supervision.broker_quiet_for(at_ms(0)));
  supervision.on_broker_message(at_ms(100));
  EXPECT_EQ(supervision.broker_quiet_for(at_ms(400)), milliseconds{300});
  EXPECT_FALSE(supervision.broker_lost(at_ms(600)));
  EXPECT_TRUE(supervision.broker_lost(at_ms(601))) << "whatever the state of the connection";
  supervision.on_broker_message(at_ms(700));
  EXPECT_FALSE(supervision.broker_lost(at_ms(700)));
}

TEST(Supervision, takes_each_board_for_lost_half_a_second_after_its_last_message) {
  Supervision supervision{milliseconds{500}};
  for (const wire::Board board : wire::all_boards) EXPECT_TRUE(supervision.board_lost(at_ms(0), board));
  for (const wire::Board board : wire::all_boards) supervision.on_board_message(at_ms(0), board);
  EXPECT_FALSE(supervision.any_board_lost(at_ms(500)));
  EXPECT_TRUE(supervision.any_board_lost(at_ms(501)));
  for (const wire::Board missing : wire::all_boards) {
    for (const wire::Board board : wire::all_boards) supervision.on_board_message(at_ms(0), board);
    supervision.forget_board(missing);
    for (const wire::Board board : wire::all_boards)
      EXPECT_EQ(supervision.board_lost(at_ms(500), board), board == missing) << to_string(board);
    EXPECT_TRUE(supervision.any_board_lost(at_ms(0)));
  }
}

TEST(Supervision, takes_a_server_for_lost_only_after_a_first_heartbeat) {
  Supervision supervision{milliseconds{500}};
  EXPECT_FALSE(supervision.server_lost(at_ms(100'000)));
  supervision.on_server_heartbeat(at_ms(0));
  EXPECT_FALSE(supervision.server_lost(at_ms(500)));
  EXPECT_TRUE(supervision.server_lost(at_ms(501)));
}

TEST(Supervision, supervises_a_server_that_has_left_until_the_vehicle_releases_it) {
  Supervision supervision{milliseconds{500}};
  supervision.on_server_heartbeat(at_ms(0));
  EXPECT_FALSE(supervision.release_server()) << "the server has not left";
  supervision.server_left();
  EXPECT_TRUE(supervision.server_lost(at_ms(501)));
  EXPECT_TRUE(supervision.release_server());
  EXPECT_FALSE(supervision.server_lost(at_ms(501)));
  EXPECT_FALSE(supervision.release_server()) << "released once";
}

TEST(Supervision, keeps_a_server_that_publishes_a_heartbeat_after_it_was_reported_to_have_left) {
  Supervision supervision{milliseconds{500}};
  supervision.on_server_heartbeat(at_ms(0));
  supervision.server_left();
  supervision.on_server_heartbeat(at_ms(100));
  EXPECT_FALSE(supervision.release_server());
  EXPECT_TRUE(supervision.server_lost(at_ms(601)));
}

TEST(Supervision, releases_no_server_of_which_it_has_received_nothing) {
  Supervision supervision{milliseconds{500}};
  supervision.server_left();
  EXPECT_FALSE(supervision.release_server());
}

TEST(Supervision, gives_another_server_no_more_time_than_the_one_before_however_often_the_owner_changes) {
  Supervision supervision{milliseconds{500}};
  supervision.on_server_heartbeat(at_ms(0));
  for (int ms = 100; ms <= 500; ms += 100) supervision.expect_server(at_ms(ms));
  EXPECT_FALSE(supervision.server_lost(at_ms(500)));
  EXPECT_TRUE(supervision.server_lost(at_ms(501)));
  supervision.on_server_heartbeat(at_ms(600));
  EXPECT_FALSE(supervision.server_lost(at_ms(600)));
}

TEST(Supervision, expects_the_first_server_within_half_a_second) {
  Supervision supervision{milliseconds{500}};
  supervision.expect_server(at_ms(1'000));
  EXPECT_FALSE(supervision.server_lost(at_ms(1'500)));
  EXPECT_TRUE(supervision.server_lost(at_ms(1'501)));
}

TEST(Supervision, takes_back_that_a_server_has_left_when_another_one_is_expected) {
  Supervision supervision{milliseconds{500}};
  supervision.on_server_heartbeat(at_ms(0));
  supervision.server_left();
  supervision.expect_server(at_ms(100));
  EXPECT_FALSE(supervision.release_server());
}

}  // namespace
}  // namespace cosiva::aiv
