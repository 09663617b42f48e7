#include "cosiva/aiv/onboard/supervision.h"

#include <gtest/gtest.h>

namespace cosiva::aiv {
namespace {

using std::chrono::milliseconds;

SimTime at_ms(int ms) { return SimTime{milliseconds{ms}}; }

TEST(Supervision, takes_a_broker_for_lost_from_the_beginning_and_half_a_second_after_it_was_up) {
  Supervision supervision{milliseconds{500}};
  EXPECT_TRUE(supervision.broker_lost(at_ms(0)));
  supervision.broker(at_ms(0), false);
  EXPECT_TRUE(supervision.broker_lost(at_ms(0))) << "never up";
  supervision.broker(at_ms(100), true);
  EXPECT_FALSE(supervision.broker_lost(at_ms(100)));
  EXPECT_FALSE(supervision.broker_lost(at_ms(100'000))) << "still up";
  supervision.broker(at_ms(100'000), false);
  EXPECT_FALSE(supervision.broker_lost(at_ms(100'500)));
  EXPECT_TRUE(supervision.broker_lost(at_ms(100'501)));
}

TEST(Supervision, counts_from_the_first_of_several_reports_that_the_broker_is_down) {
  Supervision supervision{milliseconds{500}};
  supervision.broker(at_ms(0), true);
  supervision.broker(at_ms(1'000), false);
  supervision.broker(at_ms(1'400), false);
  EXPECT_FALSE(supervision.broker_lost(at_ms(1'500)));
  EXPECT_TRUE(supervision.broker_lost(at_ms(1'501)));
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
  supervision.server_left();
  EXPECT_FALSE(supervision.server_lost(at_ms(501)));
}

}  // namespace
}  // namespace cosiva::aiv
