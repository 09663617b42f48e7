#include "cosiva/adapters/stop/stop_sender.h"

#include <gmock/gmock.h>

#include <atomic>
#include <chrono>
#include <csignal>
#include <future>
#include <mutex>
#include <thread>

#include "cosiva/adapters/broker.h"
#include "cosiva/adapters/loop_thread.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/wire/messages/messages.h"
#include "cosiva/wire/vda5050/decode.h"
#include "cosiva/wire/vda5050/encode.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::Scratch;
using testing::timeout;

wire::StopTarget target(const std::string& serial, bool latched = false) {
  const wire::VehicleId id{"CoSiVA", serial};
  return {to_string(id), id,  wire::vda_topic(id, "instantActions"), wire::vda_topic(id, "state"), "2.1.0",
          latched,       true};
}

/// A broker, a sender, and vehicles on a loop of the test.
class StopSenderTest : public ::testing::Test {
 protected:
  StopSenderTest() {
    auto started = PrivateBroker::start(loop, {scratch.path(), scratch / "broker.log", {}});
    EXPECT_TRUE(started) << to_string(started.error());
    broker = std::move(*started);
    MqttHandlers handlers;
    handlers.on_link = [](bool) {};
    handlers.on_message = [this](std::string_view topic, std::string_view payload, bool) {
      const auto actions = wire::vda5050::decode_instant_actions(payload);
      received.push_back(std::string(topic) + " " + (actions ? actions->actions.at(0).action_id : "?"));
    };
    vehicles =
        MqttClient::make(loop, options("vehicles"), {"uagv/v2/+/+/instantActions"}, std::nullopt, std::move(handlers))
            .value();
    vehicles->start();
    StopHandlers stop_handlers;
    stop_handlers.on_log = [this](char, const std::string& text) {
      const std::lock_guard lock{mutex};
      log.push_back(text);
    };
    sender = StopSender::open(options("stop"), std::move(stop_handlers)).value();
    EXPECT_TRUE(until([&] { return vehicles->connected() && sender->connected(); }));
    loop.run_for(50ms);  // the subscription is in force
  }
  MqttOptions options(const std::string& name) const {
    MqttOptions made;
    made.port = broker->port();
    made.client_name = name;
    return made;
  }
  bool until(const std::function<bool()>& done) { return loop.run_until(done, timeout); }
  void report(const std::string& serial, bool paused) {
    wire::State state;
    state.header = {1, SimTime{}, "2.1.0", "CoSiVA", serial};
    state.paused = paused;
    (void)vehicles->publish({"uagv/v2/CoSiVA/" + serial + "/state", wire::vda5050::encode(state), 0, false});
  }
  bool logged(const std::string& text) {
    const std::lock_guard lock{mutex};
    return std::ranges::any_of(log, [&](const std::string& line) { return line.find(text) != std::string::npos; });
  }

  Scratch scratch;
  EventLoop loop;
  std::unique_ptr<PrivateBroker> broker;
  std::vector<std::string> received;  ///< "topic actionId"
  std::unique_ptr<MqttClient> vehicles;
  std::mutex mutex;
  std::vector<std::string> log;
  std::unique_ptr<StopSender> sender;
};

TEST_F(StopSenderTest, publishes_to_the_listed_vehicles_of_these_names) {
  sender->know({target("AIV1"), target("AIV2")});
  EXPECT_TRUE(sender->send("S1", {"CoSiVA/AIV2"}));
  EXPECT_THAT(sender->unconfirmed("S1"), ElementsAre("CoSiVA/AIV2"));
  ASSERT_TRUE(until([&] { return !received.empty(); }));
  EXPECT_EQ(received.front(), "uagv/v2/CoSiVA/AIV2/instantActions S1");
}

TEST_F(StopSenderTest, returns_that_it_does_not_know_a_vehicle_and_stops_the_others) {
  sender->know({target("AIV1")});
  EXPECT_FALSE(sender->send("S1", {"CoSiVA/AIV9", "CoSiVA/AIV1"}));
  ASSERT_TRUE(until([&] { return !received.empty(); }));
  EXPECT_EQ(received.front(), "uagv/v2/CoSiVA/AIV1/instantActions S1");
  EXPECT_TRUE(sender->send("S2", {"*"}));
}

TEST_F(StopSenderTest, repeats_until_the_state_shows_paused) {
  sender->know({target("AIV1")});
  sender->send("S1", {"*"});
  ASSERT_TRUE(until([&] { return received.size() >= 3; }));
  report("AIV1", false);
  report("AIV1", true);
  ASSERT_TRUE(until([&] { return sender->unconfirmed("S1").empty(); }));
  loop.run_for(50ms);  // what was in transit
  const std::size_t before = received.size();
  loop.run_for(250ms);
  EXPECT_EQ(received.size(), before);
}

TEST_F(StopSenderTest, logs_a_vehicle_that_has_not_confirmed_within_500_ms) {
  sender->know({target("AIV1")});
  sender->send("S1", {"*"});
  loop.run_for(300ms);
  EXPECT_FALSE(logged("not confirmed"));
  EXPECT_TRUE(until([&] { return logged("Stop S1 is not confirmed by CoSiVA/AIV1"); }));
}

TEST_F(StopSenderTest, repeats_nothing_for_vehicles_that_may_drive_again) {
  sender->know({target("AIV1")});
  sender->send("S1", {"*"});
  ASSERT_TRUE(until([&] { return !received.empty(); }));
  sender->lift({"CoSiVA/AIV1"});
  ASSERT_TRUE(until([&] { return sender->unconfirmed("S1").empty(); }));
  loop.run_for(50ms);
  const std::size_t before = received.size();
  loop.run_for(250ms);
  EXPECT_EQ(received.size(), before);
}

TEST_F(StopSenderTest, publishes_what_was_stopped_without_a_connection_once_there_is_one) {
  sender->know({target("AIV1")});
  broker->child()->signal(SIGKILL);
  ASSERT_TRUE(until([&] { return !sender->connected() && !vehicles->connected(); }));
  received.clear();
  sender->send("S1", {"*"});
  ASSERT_TRUE(broker->restart());
  EXPECT_TRUE(until([&] { return !received.empty(); }));
}

TEST_F(StopSenderTest, publishes_while_the_loop_of_the_core_is_blocked) {
  sender->know({target("AIV1")});
  // The vehicle is on a thread of its own; the loop of this test plays the core's, and handles nothing.
  LoopThread vehicle;
  std::promise<std::chrono::steady_clock::time_point> arrived;
  std::atomic<bool> first{true};
  MqttHandlers handlers;
  std::promise<void> connected;
  handlers.on_link = [&](bool up) {
    if (up) connected.set_value();
  };
  handlers.on_message = [&](std::string_view, std::string_view, bool) {
    if (first.exchange(false)) arrived.set_value(std::chrono::steady_clock::now());
  };
  auto client = MqttClient::make(vehicle.loop(), options("vehicle"), {"uagv/v2/CoSiVA/AIV1/instantActions"},
                                 std::nullopt, std::move(handlers))
                    .value();
  vehicle.start();
  vehicle.loop().post([&] { client->start(); });
  ASSERT_EQ(connected.get_future().wait_for(timeout), std::future_status::ready);
  std::this_thread::sleep_for(50ms);
  sender->send("S1", {"*"});
  EXPECT_EQ(arrived.get_future().wait_for(timeout), std::future_status::ready);
  vehicle.stop();
}

TEST_F(StopSenderTest, takes_lists_and_stops_from_several_threads_at_once) {
  std::vector<std::thread> threads;
  for (int t = 0; t < 4; ++t) {
    threads.emplace_back([&, t] {
      for (int i = 0; i < 50; ++i) {
        sender->know({target("AIV1"), target("AIV2")});
        sender->send("S" + std::to_string(t) + "." + std::to_string(i), {"*"});
        (void)sender->unconfirmed("S0.0");
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
  EXPECT_TRUE(until([&] { return received.size() >= 400; }));
}

TEST_F(StopSenderTest, ends_while_stops_are_pending) {
  sender->know({target("AIV1")});
  sender->send("S1", {"*"});
  sender.reset();
  EXPECT_THAT(received, IsEmpty());
}

}  // namespace
}  // namespace cosiva::adapters
