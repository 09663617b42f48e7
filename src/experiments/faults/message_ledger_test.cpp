#include "cosiva/experiments/faults/message_ledger.h"

#include <gtest/gtest.h>

namespace cosiva::experiments {
namespace {

/// One vehicle that sends, and a server that receives what the test lets through.
class Ledger : public testing::Test {
 protected:
  static constexpr const char* vehicle = "CoSiVA/AIV1";
  [[nodiscard]] wire::Publish message(const std::string& name, std::uint32_t id, const std::string& rest = "") const {
    return {"uagv/v2/CoSiVA/AIV1/" + name,
            R"({"headerId":)" + std::to_string(id) + R"(,"process":)" + std::to_string(process) + rest + "}", 0, false};
  }
  void restart() {
    ledger.on_killed(vehicle);
    ++process;
  }
  wire::Publish online(std::uint32_t id) {
    const wire::Publish sent = message("connection", id, R"(,"connectionState":"ONLINE")");
    EXPECT_FALSE(ledger.on_sent(sent));
    return sent;
  }
  void send_states(std::uint32_t first, std::uint32_t last) {
    for (std::uint32_t id = first; id <= last; ++id) EXPECT_FALSE(ledger.on_sent(message("state", id)));
  }
  void receive(const wire::Publish& received) { ledger.on_received(received.topic, received.payload); }
  void receive_states(const std::vector<std::uint32_t>& ids) {
    for (const std::uint32_t id : ids) receive(message("state", id));
  }
  bool holds(int missed, int dropped = 0) {
    return !ledger.check(*JsonValue::parse(R"({"aivs":[{"id":"CoSiVA/AIV1","missed":)" + std::to_string(missed) +
                                           R"(,"dropped":)" + std::to_string(dropped) + "}]}"));
  }

  MessageLedger ledger;
  int process{1};  ///< two messages are never the same, as their time stamps differ
};

TEST_F(Ledger, requires_that_exactly_the_lost_messages_count_as_missing) {
  receive(online(0));
  send_states(0, 9);
  receive_states({0, 1, 4, 3, 3, 8});
  EXPECT_TRUE(holds(4)) << "2, 5, 6, 7; that 9 was lost cannot be known yet";
  EXPECT_FALSE(holds(3));
  EXPECT_FALSE(holds(5));
}

TEST_F(Ledger, permits_a_dropped_message_to_count_as_missing) {
  receive(online(0));
  send_states(0, 4);
  receive_states({0});
  EXPECT_TRUE(holds(0));
  receive_states({2, 3});
  EXPECT_TRUE(holds(1, 2));
  EXPECT_TRUE(holds(3, 2));
  EXPECT_FALSE(holds(4, 2));
}

TEST_F(Ledger, requires_no_count_of_what_only_a_dropped_message_shows) {
  receive(online(0));
  send_states(0, 9);
  receive_states({0});
  EXPECT_TRUE(holds(0));
  receive_states({2});
  EXPECT_TRUE(holds(0, 1)) << "2 was dropped: the server does not know of 1 yet";
  EXPECT_TRUE(holds(0, 1));
  receive_states({4});
  EXPECT_FALSE(holds(1, 1)) << "4 shows that 1 and 3 are missing";
  EXPECT_TRUE(holds(2, 1));
  EXPECT_TRUE(holds(3, 1)) << "and 2, to a server that dropped it";
}

TEST_F(Ledger, does_not_check_a_session_whose_first_message_the_server_may_have_dropped) {
  receive(online(0));
  send_states(0, 9);
  receive_states({0, 2, 3});
  EXPECT_TRUE(holds(0, 2)) << "the server has evaluated 3 only";
  receive(online(1));
  receive_states({4, 6});
  EXPECT_TRUE(holds(1, 2)) << "the server counts on from here";
  receive_states({9});
  EXPECT_TRUE(holds(3, 2));
  EXPECT_FALSE(holds(2, 2));
}

TEST_F(Ledger, does_not_check_the_count_of_a_session_that_ended_while_the_server_dropped_messages) {
  receive(online(0));
  send_states(0, 9);
  receive_states({0});
  EXPECT_TRUE(holds(0));
  receive_states({2});
  EXPECT_TRUE(holds(0, 1)) << "2 was dropped: the server does not know of 1";
  restart();
  receive(online(0));
  send_states(0, 9);
  receive_states({0});
  EXPECT_TRUE(holds(0, 1)) << "and will not";
  receive_states({2});
  EXPECT_FALSE(holds(0, 1));
  EXPECT_TRUE(holds(1, 1));
}

TEST_F(Ledger, adds_the_sessions_of_a_vehicle) {
  receive(online(0));
  send_states(0, 3);
  receive_states({0, 2});
  restart();
  const wire::Publish again = online(0);
  send_states(0, 3);
  receive(message("connection", 1, R"(,"connectionState":"CONNECTIONBROKEN")"));
  receive(again);
  receive_states({1, 3});
  EXPECT_TRUE(holds(2)) << "1 of each session; a session is counted from its first message that arrives";
}

TEST_F(Ledger, does_not_check_a_session_that_the_server_cannot_know_of) {
  receive(online(0));
  send_states(0, 20);
  receive_states({0, 20});
  EXPECT_TRUE(holds(19));
  restart();
  send_states(0, 10);
  receive_states({0});
  EXPECT_TRUE(holds(7)) << "not checked";
  receive(online(0));
  EXPECT_TRUE(holds(7)) << "the server counts on from here";
  receive_states({1, 3});
  EXPECT_FALSE(holds(7));
  EXPECT_TRUE(holds(8));
}

TEST_F(Ledger, goes_on_with_the_session_of_a_message_that_is_received_again) {
  const wire::Publish before_the_ledger = message("connection", 0, R"(,"connectionState":"ONLINE")");
  receive(before_the_ledger);
  send_states(0, 9);
  receive_states({0});
  receive(before_the_ledger);
  receive_states({9});
  EXPECT_TRUE(holds(8));
  EXPECT_FALSE(holds(0));
}

TEST_F(Ledger, counts_the_connections_and_factsheets_too) {
  receive(online(0));
  receive(message("factsheet", 0));
  receive(message("connection", 2, R"(,"connectionState":"OFFLINE")"));
  for (std::uint32_t id = 1; id <= 4; ++id) EXPECT_FALSE(ledger.on_sent(message("factsheet", id)));
  receive(message("factsheet", 4));
  EXPECT_TRUE(holds(3)) << "factsheets 1, 2 and 3; connections count from the first one after the session's";
  EXPECT_FALSE(holds(0));
  receive(message("connection", 4, R"(,"connectionState":"CONNECTIONBROKEN")"));
  EXPECT_TRUE(holds(4));
}

TEST_F(Ledger, begins_again_with_a_server_that_starts) {
  receive(online(0));
  send_states(0, 20);
  receive_states({0, 20});
  ledger.on_server_start();
  receive_states({10, 12});
  EXPECT_TRUE(holds(1));
}

TEST_F(Ledger, finds_a_vehicle_that_numbers_with_a_gap) {
  send_states(0, 4);
  const auto found = ledger.on_sent(message("state", 6));
  ASSERT_TRUE(found);
  EXPECT_EQ(found->invariant, "I3");
}

}  // namespace
}  // namespace cosiva::experiments
