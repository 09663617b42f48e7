#include "cosiva/app/remote/live_session.h"

#include <gtest/gtest.h>

#include <utility>

namespace cosiva::app {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

LiveSession session_without_platform() {
  // No service listens on port 1 of this machine.
  return LiveSession{
      {"cosiva-session", seconds{1}, ": is it running?", milliseconds{200}, seconds{0}, false, seconds{1}, ""},
      adapters::HttpClient::make("http://127.0.0.1:1").value()};
}

TEST(LiveSession, reports_a_broker_and_a_server_that_do_not_respond) {
  LiveSession session = session_without_platform();
  BrokerArguments broker;
  broker.address = "127.0.0.1:1";
  const auto connected = session.connect(std::move(broker), {}, [](std::string_view, std::string_view) {});
  ASSERT_FALSE(connected);
  EXPECT_EQ(connected.error().code, "mqtt.connect");
  EXPECT_EQ(connected.error().message, "no broker responds at this address: is it running?");
  EXPECT_EQ(session.address(), "127.0.0.1:1");
  const auto server = session.check_server();
  ASSERT_FALSE(server);
  EXPECT_EQ(server.error().code, "http.connect");
}

TEST(LiveSession, keeps_commands_until_the_server_accepts_them) {
  LiveSession session = session_without_platform();
  EXPECT_FALSE(session.has_commands());
  session.add_command("{}");
  session.send_commands();
  EXPECT_TRUE(session.has_commands());
}

}  // namespace
}  // namespace cosiva::app
