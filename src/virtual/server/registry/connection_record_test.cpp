#include "cosiva/virtual/server/registry/connection_record.h"

#include <gtest/gtest.h>

namespace cosiva::virtual_side {
namespace {

using namespace std::chrono_literals;
using wire::ConnectionState;

TEST(ConnectionRecord, counts_a_vehicle_that_never_reported_its_connection_as_online) {
  const ConnectionRecord connection;
  EXPECT_FALSE(connection.state());
  EXPECT_TRUE(connection.online());
  EXPECT_EQ(connection.shown(), ConnectionState::online);
}

TEST(ConnectionRecord, begins_a_session_with_the_first_online_and_after_each_loss) {
  ConnectionRecord connection;
  EXPECT_TRUE(connection.on_connection(ConnectionState::online, virtual_epoch));
  EXPECT_FALSE(connection.on_connection(ConnectionState::online, virtual_epoch + 1s)) << "the same session";
  EXPECT_FALSE(connection.on_connection(ConnectionState::connection_broken, virtual_epoch + 2s));
  EXPECT_FALSE(connection.online());
  EXPECT_TRUE(connection.on_connection(ConnectionState::online, virtual_epoch + 3s));
  connection.on_offline(virtual_epoch + 4s);
  EXPECT_EQ(connection.state(), ConnectionState::offline);
  EXPECT_TRUE(connection.on_connection(ConnectionState::online, virtual_epoch + 5s));
}

TEST(ConnectionRecord, begins_a_session_with_each_online_message_even_where_no_loss_was_published) {
  ConnectionRecord connection;
  const SimTime first = virtual_epoch;
  const SimTime second = virtual_epoch + 30s;
  EXPECT_TRUE(connection.on_connection(ConnectionState::online, virtual_epoch, first));
  EXPECT_FALSE(connection.on_connection(ConnectionState::online, virtual_epoch + 1s, first)) << "retained";
  EXPECT_TRUE(connection.on_connection(ConnectionState::online, virtual_epoch + 31s, second))
      << "the broker has died, with its last wills";
  EXPECT_FALSE(connection.on_connection(ConnectionState::connection_broken, virtual_epoch + 40s, first));
  EXPECT_TRUE(connection.on_report(virtual_epoch + 43s));
  EXPECT_FALSE(connection.on_connection(ConnectionState::online, virtual_epoch + 44s, second)) << "retained";
}

TEST(ConnectionRecord, takes_a_vehicle_as_online_that_reports_longer_than_two_seconds_after_its_will) {
  ConnectionRecord connection;
  connection.on_connection(ConnectionState::connection_broken, virtual_epoch);
  EXPECT_FALSE(connection.on_report(virtual_epoch + 2s)) << "may have been in transit";
  EXPECT_FALSE(connection.online());
  EXPECT_TRUE(connection.on_report(virtual_epoch + 2001ms));
  EXPECT_TRUE(connection.online());
  EXPECT_FALSE(connection.on_report(virtual_epoch + 10s)) << "nothing changes";
}

TEST(ConnectionRecord, is_not_changed_by_reports_of_a_vehicle_without_a_connection_message) {
  ConnectionRecord connection;
  EXPECT_FALSE(connection.on_report(virtual_epoch + 10s));
  EXPECT_FALSE(connection.state());
}

TEST(ConnectionRecord, refuses_a_change_before_the_last_one) {
  ConnectionRecord connection;
  connection.on_offline(virtual_epoch + 1s);
  EXPECT_DEATH(connection.on_offline(virtual_epoch), "now >= changed_at_");
}

TEST(ConnectionRecord, is_as_reported_last_even_at_one_time) {
  ConnectionRecord connection;
  EXPECT_TRUE(connection.on_connection(ConnectionState::online, virtual_epoch));
  EXPECT_FALSE(connection.on_connection(ConnectionState::offline, virtual_epoch));
  EXPECT_EQ(connection.shown(), ConnectionState::offline);
  EXPECT_FALSE(connection.online());
}

TEST(ConnectionRecord, begins_no_session_with_a_loss_of_a_vehicle_that_was_never_online) {
  ConnectionRecord connection;
  EXPECT_FALSE(connection.on_connection(ConnectionState::connection_broken, virtual_epoch));
  EXPECT_FALSE(connection.on_connection(ConnectionState::offline, virtual_epoch + 1s));
}

TEST(ConnectionRecord, counts_the_two_seconds_from_the_last_change) {
  ConnectionRecord connection;
  connection.on_connection(ConnectionState::connection_broken, virtual_epoch);
  connection.on_offline(virtual_epoch + 1500ms);
  EXPECT_FALSE(connection.on_report(virtual_epoch + 3500ms));
  EXPECT_TRUE(connection.on_report(virtual_epoch + 3501ms));
  EXPECT_EQ(connection.state(), ConnectionState::online);
}

}  // namespace
}  // namespace cosiva::virtual_side
