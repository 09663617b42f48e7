#include "cosiva/adapters/mqtt_client.h"

#include <gmock/gmock.h>
#include <sys/stat.h>

#include <algorithm>
#include <csignal>
#include <map>
#include <optional>

#include "cosiva/adapters/broker.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/test_fixture.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using testing::Scratch;
using testing::timeout;

/// A client that records every message received.
struct Listener {
  std::vector<std::string> received;  ///< "topic=payload", retained ones with a '*' in front
  std::vector<bool> links;
  std::vector<std::string> log;
  std::unique_ptr<MqttClient> client;

  Listener(EventLoop& loop, std::uint16_t port, std::vector<std::string> filters,
           std::optional<wire::Will> will = std::nullopt) {
    MqttOptions options;
    options.port = port;
    options.client_name = "test";
    MqttHandlers handlers;
    handlers.on_link = [this](bool up) { links.push_back(up); };
    handlers.on_message = [this](std::string_view topic, std::string_view payload, bool retained) {
      received.push_back((retained ? "*" : "") + std::string(topic) + "=" + std::string(payload));
    };
    handlers.on_log = [this](char, const std::string& text) { log.push_back(text); };
    client = MqttClient::make(loop, options, std::move(filters), std::move(will), std::move(handlers)).value();
    client->start();
  }
  [[nodiscard]] bool received_all(std::size_t count) const { return received.size() >= count; }
};

class Mqtt : public ::testing::Test {
 protected:
  Mqtt() {
    auto started = PrivateBroker::start(loop, {scratch.path(), scratch / "broker.log", {}});
    EXPECT_TRUE(started) << to_string(started.error());
    broker = std::move(*started);
  }
  bool until(const std::function<bool()>& done) { return loop.run_until(done, timeout); }
  bool until_connected(const Listener& listener) {
    return until([&] { return listener.client->connected(); });
  }
  /// A subscription is in force once the client's own message arrives through it.
  bool until_listening(Listener& listener, const std::string& topic) {
    if (!until_connected(listener)) return false;
    Timer again{loop};
    again.every(50ms, [&] { listener.client->publish({topic, "probe", 0, false}); });
    const bool back = until([&] { return !listener.received.empty() && listener.received.back() == topic + "=probe"; });
    again.cancel();
    loop.run_for(50ms);
    listener.received.clear();
    return back;
  }

  Scratch scratch;
  EventLoop loop;
  std::unique_ptr<PrivateBroker> broker;
};

TEST_F(Mqtt, private_broker_listens_on_loopback_and_its_configuration_is_private) {
  struct stat metadata {};
  ASSERT_EQ(::stat((scratch / "mosquitto.conf").c_str(), &metadata), 0);
  EXPECT_EQ(metadata.st_mode & 0777U, 0600U);
  EXPECT_GT(broker->port(), 0);
  EXPECT_TRUE(broker->child()->running());
  broker.reset();
  EXPECT_NE(::stat((scratch / "mosquitto.conf").c_str(), &metadata), 0);
}

TEST_F(Mqtt, changes_filters_while_connected_and_over_a_lost_connection) {
  Listener listener{loop, broker->port(), {"own"}};
  listener.client->listen({"talk/1/+", "talk/2/+"});  // before there is a connection
  ASSERT_TRUE(until_listening(listener, "talk/2/x"));
  listener.client->listen({"talk/2/+", "talk/3/+"});
  ASSERT_TRUE(until_listening(listener, "talk/3/x"));
  for (const char* topic : {"talk/1/x", "talk/2/x", "own"}) listener.client->publish({topic, "a", 0, false});
  ASSERT_TRUE(until([&] { return listener.received_all(2); }));
  EXPECT_THAT(listener.received, ElementsAre("talk/2/x=a", "own=a")) << "the first filter is no longer subscribed";

  bool dead = false;
  broker->on_exit([&](const ChildExit&) { dead = true; });
  broker->child()->signal(SIGKILL);
  ASSERT_TRUE(until([&] { return dead && !listener.client->connected(); }));
  ASSERT_TRUE(broker->restart());
  ASSERT_TRUE(until_listening(listener, "talk/3/x"));
}

TEST_F(Mqtt, message_arrives_as_it_was_sent) {
  Listener listener{loop, broker->port(), {"a/+"}};
  ASSERT_TRUE(until_listening(listener, "a/probe"));
  Listener speaker{loop, broker->port(), {}};
  ASSERT_TRUE(until_connected(speaker));
  const std::string bytes("\0\x01\xFF{}", 5);
  EXPECT_TRUE(speaker.client->publish({"a/b", bytes, 0, false}));
  EXPECT_TRUE(speaker.client->publish({"b/b", "not subscribed", 1, false}));
  EXPECT_TRUE(speaker.client->publish({"a/c", "", 1, false}));
  ASSERT_TRUE(until([&] { return listener.received_all(2); }));
  EXPECT_THAT(listener.received, ElementsAre("a/b=" + bytes, "a/c="));
}

TEST_F(Mqtt, retained_message_reaches_a_later_subscriber_with_its_flag) {
  Listener speaker{loop, broker->port(), {}};
  ASSERT_TRUE(until_connected(speaker));
  speaker.client->publish({"zone", "lacet4", 1, true});
  bool stopped = false;
  speaker.client->stop([&] { stopped = true; });
  ASSERT_TRUE(until([&] { return stopped; }));
  Listener late{loop, broker->port(), {"zone"}};
  ASSERT_TRUE(until([&] { return late.received_all(1); }));
  EXPECT_THAT(late.received, ElementsAre("*zone=lacet4"));
}

TEST_F(Mqtt, private_broker_has_bounded_queues_and_messages) {
  const std::string configuration = read_file(scratch / "mosquitto.conf").value();
  for (const char* bounded :
       {"max_inflight_messages", "max_queued_messages", "max_queued_bytes", "memory_limit", "max_packet_size"}) {
    const std::size_t at = configuration.find(bounded);
    ASSERT_NE(at, std::string::npos) << bounded;
    EXPECT_GT(std::stoull(configuration.substr(at + std::string(bounded).size())), 0U) << bounded;
  }
}

TEST_F(Mqtt, message_larger_than_the_limit_is_not_passed_on_and_logged_once) {
  MqttOptions options;
  options.port = broker->port();
  options.received_bytes_max = 1'000;
  std::vector<std::size_t> received;
  std::vector<std::string> log;
  MqttHandlers handlers;
  handlers.on_message = [&](std::string_view, std::string_view payload, bool) { received.push_back(payload.size()); };
  handlers.on_log = [&](char, const std::string& text) { log.push_back(text); };
  const auto client = MqttClient::make(loop, options, {"a"}, std::nullopt, std::move(handlers)).value();
  client->start();
  ASSERT_TRUE(until([&] { return client->connected(); }));
  for (const std::size_t bytes : {1'000U, 1'001U, 5'000U, 3U})
    client->publish({"a", std::string(bytes, 'x'), 1, false});
  ASSERT_TRUE(until([&] { return client->counters().received == 4; }));
  EXPECT_THAT(received, ElementsAre(1'000U, 3U));
  EXPECT_EQ(client->counters().too_large, 2U);
  EXPECT_THAT(log, ElementsAre("a message of 1001 bytes on a is too large and ignored; further ones are counted"));
}

TEST_F(Mqtt, messages_to_a_broker_that_does_not_read_occupy_bounded_memory_and_orders_are_sent_first) {
  Listener listener{loop, broker->port(), {"state", "x/order"}};
  ASSERT_TRUE(until_listening(listener, "state"));
  MqttOptions options;
  options.port = broker->port();
  options.outgoing = {.bytes_max = 300'000, .messages_max = 1'000};
  std::vector<std::string> log;
  MqttHandlers handlers;
  handlers.on_log = [&](char, const std::string& text) { log.push_back(text); };
  const auto client = MqttClient::make(loop, options, {}, std::nullopt, std::move(handlers)).value();
  client->start();
  ASSERT_TRUE(until([&] { return client->connected(); }));
  broker->child()->signal(SIGSTOP);
  const std::string state(2'500, 'x');
  for (int i = 0; i < 10; ++i) client->publish({"x/order", "order " + std::to_string(i), 0, false});
  // 25 MB: more than the buffers of the sockets.
  for (int i = 0; i < 10'000; ++i) {
    client->publish({"state", state, 0, false});
    if (i == 9'000) client->publish({"x/order", "order in between", 0, false});
  }
  EXPECT_GT(client->counters().dropped.telemetry, 1'000U);
  EXPECT_EQ(client->counters().dropped.commands, 0U);
  broker->child()->signal(SIGCONT);
  ASSERT_TRUE(until(
      [&] { return std::ranges::find(listener.received, "x/order=order in between") != listener.received.end(); }));
  EXPECT_EQ(std::ranges::count_if(listener.received, [](const auto& one) { return one.starts_with("x/order="); }), 11);
  EXPECT_THAT(log, ::testing::IsEmpty());
}

TEST_F(Mqtt, orders_without_a_connection_are_counted_and_logged_once_it_is_back) {
  Listener listener{loop, broker->port(), {}};
  EXPECT_FALSE(listener.client->publish({"x/order", "1", 0, false})) << "not connected yet";
  EXPECT_FALSE(listener.client->publish({"x/state", "1", 0, false}));
  EXPECT_EQ(listener.client->counters().dropped.commands, 1U);
  EXPECT_EQ(listener.client->counters().dropped.telemetry, 1U);
  ASSERT_TRUE(until_connected(listener));
  EXPECT_THAT(listener.log, ElementsAre("broker 127.0.0.1:" + std::to_string(broker->port()) +
                                        ": 1 orders and other commands could not be sent, 1 so far"));
}

TEST_F(Mqtt, thousand_messages_at_once_arrive_in_order) {
  Listener listener{loop, broker->port(), {"flood", "flood/probe"}};
  ASSERT_TRUE(until_listening(listener, "flood/probe"));
  Listener speaker{loop, broker->port(), {}};
  ASSERT_TRUE(until_connected(speaker));
  const std::string padding(1000, '.');
  for (int i = 0; i < 1000; ++i)
    EXPECT_TRUE(speaker.client->publish({"flood", std::to_string(i) + padding, i % 2, false}));
  ASSERT_TRUE(until([&] { return listener.received_all(1000); }));
  for (std::size_t i = 0; i < 1000; ++i) ASSERT_EQ(listener.received[i], "flood=" + std::to_string(i) + padding);
}

TEST_F(Mqtt, will_is_published_when_a_client_vanishes_but_not_after_disconnect) {
  Listener listener{loop, broker->port(), {"will/#", "probe"}};
  ASSERT_TRUE(until_listening(listener, "probe"));
  auto killed = std::make_unique<Listener>(loop, broker->port(), std::vector<std::string>{},
                                           wire::Will{{"will/killed", "CONNECTIONBROKEN", 1, false}});
  Listener polite{loop, broker->port(), {}, wire::Will{{"will/polite", "CONNECTIONBROKEN", 1, false}}};
  ASSERT_TRUE(until_connected(*killed));
  ASSERT_TRUE(until_connected(polite));
  bool stopped = false;
  polite.client->publish({"will/polite", "OFFLINE", 1, false});
  polite.client->stop([&] { stopped = true; });
  ASSERT_TRUE(until([&] { return stopped && listener.received_all(1); }));
  killed.reset();
  ASSERT_TRUE(until([&] { return listener.received_all(2); }));
  EXPECT_THAT(listener.received, ElementsAre("will/polite=OFFLINE", "will/killed=CONNECTIONBROKEN"));
}

TEST_F(Mqtt, reconnects_by_itself_after_the_broker_was_killed) {
  Listener listener{loop, broker->port(), {"a", "probe"}};
  ASSERT_TRUE(until_listening(listener, "probe"));
  Listener speaker{loop, broker->port(), {}};
  ASSERT_TRUE(until_connected(speaker));

  bool dead = false;
  broker->on_exit([&](const ChildExit& exit) {
    EXPECT_EQ(exit.signal, SIGKILL);
    dead = true;
  });
  broker->child()->signal(SIGKILL);
  ASSERT_TRUE(until([&] { return dead && !listener.client->connected() && !speaker.client->connected(); }));
  EXPECT_FALSE(speaker.client->publish({"a", "into the void", 0, false}));
  loop.run_for(300ms);  // some attempts against a closed port
  ASSERT_TRUE(broker->restart());
  ASSERT_TRUE(until([&] { return listener.client->connected() && speaker.client->connected(); }));
  EXPECT_THAT(listener.links, ElementsAre(true, false, true));
  ASSERT_TRUE(until_listening(listener, "probe"));
  speaker.client->publish({"a", "again", 0, false});
  ASSERT_TRUE(until([&] { return listener.received_all(1); }));
  EXPECT_THAT(listener.received, ElementsAre("a=again"));
}

TEST_F(Mqtt, qos_1_published_without_a_connection_is_sent_on_its_return) {
  Listener listener{loop, broker->port(), {"a", "probe"}};
  Listener speaker{loop, broker->port(), {}};
  ASSERT_TRUE(until_connected(speaker));
  bool dead = false;
  broker->on_exit([&](const ChildExit&) { dead = true; });
  broker->child()->signal(SIGKILL);
  ASSERT_TRUE(until([&] { return dead && !speaker.client->connected(); }));
  speaker.client->publish({"a", "kept", 1, true});  // retained: the listener may reconnect after the publication
  ASSERT_TRUE(broker->restart());
  ASSERT_TRUE(until([&] { return listener.received_all(1); }));
  EXPECT_THAT(listener.received.front(), HasSubstr("a=kept"));
}

TEST_F(Mqtt, publishing_from_within_a_message_handler_is_permitted) {
  Listener echo{loop, broker->port(), {"probe"}};
  ASSERT_TRUE(until_listening(echo, "probe"));
  MqttOptions options;
  options.port = broker->port();
  std::unique_ptr<MqttClient> countdown;
  int left = 200;
  MqttHandlers handlers;
  handlers.on_link = [&](bool up) {
    if (up) countdown->publish({"count", "go", 0, false});
  };
  handlers.on_message = [&](std::string_view, std::string_view, bool) {
    if (--left > 0) countdown->publish({"count", std::to_string(left), left % 2, false});
  };
  countdown = MqttClient::make(loop, options, {"count"}, std::nullopt, std::move(handlers)).value();
  countdown->start();
  EXPECT_TRUE(until([&] { return left == 0; }));
}

TEST(MqttClient, logs_once_that_no_broker_responds_and_stops_at_once) {
  EventLoop loop;
  const std::uint16_t no_receiver = find_free_port().value();
  Listener listener{loop, no_receiver, {}};
  loop.run_for(500ms);
  EXPECT_EQ(listener.log.size(), 1U);
  EXPECT_THAT(listener.log.front(), HasSubstr("127.0.0.1:" + std::to_string(no_receiver)));
  EXPECT_TRUE(listener.links.empty());
  bool stopped = false;
  listener.client->stop([&] { stopped = true; });
  EXPECT_TRUE(loop.run_until([&] { return stopped; }, timeout));
}

TEST(MqttClient, reports_a_broker_that_refuses) {
  Scratch scratch;
  EventLoop loop;
  const std::uint16_t port = find_free_port().value();
  const std::string configuration = scratch.write(
      "strict.conf", "listener " + std::to_string(port) + " 127.0.0.1\nallow_anonymous false\nlog_dest stderr\n");
  ChildOptions child;
  child.argv = {"/usr/sbin/mosquitto", "-c", configuration};
  child.log_file = scratch / "strict.log";
  const auto broker = Child::start(loop, std::move(child)).value();
  Listener listener{loop, port, {}};
  const auto refused = [&] {
    return !listener.log.empty() && listener.log.back().find("refuses") != std::string::npos;
  };
  EXPECT_TRUE(loop.run_until(refused, timeout));
  EXPECT_FALSE(listener.client->connected());
}

TEST(MqttClient, names_the_options_it_cannot_use) {
  EventLoop loop;
  MqttOptions tls;
  tls.tls = MqttTls{"/nonexistent/ca.pem", {}, {}};
  const auto without_ca = MqttClient::make(loop, tls, {}, std::nullopt, {});
  ASSERT_FALSE(without_ca);
  EXPECT_EQ(without_ca.error().code, "mqtt.tls");
  EXPECT_THAT(without_ca.error().location, HasSubstr("/nonexistent/ca.pem"));

  MqttOptions user;
  user.user = "cosiva";
  user.password_file = "/nonexistent/password";
  const auto without_password = MqttClient::make(loop, user, {}, std::nullopt, {});
  ASSERT_FALSE(without_password);
  EXPECT_EQ(without_password.error().code, "mqtt.password");
}

TEST(MqttClient, gives_up_on_a_peer_that_accepts_and_sends_nothing) {
  // A listening socket whose backlog takes the connection but never responds to CONNECT.
  Scratch scratch;
  EventLoop loop;
  const std::uint16_t port = find_free_port().value();
  ChildOptions unresponsive;
  unresponsive.argv = {"python3", "-c",
                       "import socket,time; s=socket.create_server(('127.0.0.1'," + std::to_string(port) +
                           ")); print('ready',flush=True); time.sleep(600)"};
  bool ready = false;
  unresponsive.on_line = [&](const std::string&) { ready = true; };
  const auto peer = Child::start(loop, std::move(unresponsive)).value();
  ASSERT_TRUE(loop.run_until([&] { return ready; }, timeout));
  Listener listener{loop, port, {}};
  EXPECT_TRUE(loop.run_until([&] { return !listener.log.empty(); }, timeout));
  EXPECT_THAT(listener.log.front(), HasSubstr("no response in time"));
}

/// An authority, a broker and a client with certificates from it, made by the openssl command.
class Tls : public ::testing::Test {
 protected:
  void SetUp() override {
    openssl(
        "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=ca -keyout ca.key -out ca.pem");
    openssl(
        "req -x509 -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -days 2 -subj /CN=other -keyout o.key -out "
        "other.pem");
    scratch.write("san", "subjectAltName=IP:127.0.0.1\n");
    for (const std::string name : {"broker", "client"}) {
      openssl("req -newkey ec -pkeyopt ec_paramgen_curve:P-256 -nodes -subj /CN=" + name + " -keyout " + name +
              ".key -out " + name + ".csr");
      openssl("x509 -req -in " + name + ".csr -CA ca.pem -CAkey ca.key -CAcreateserial -days 2 -extfile san -out " +
              name + ".pem");
    }
    port = find_free_port().value();
    scratch.write("tls.conf",
                  "listener " + std::to_string(port) +
                      " 127.0.0.1\nallow_anonymous true\nrequire_certificate true\nlog_dest stderr\nuser root\n"
                      "cafile " +
                      scratch / "ca.pem" + "\ncertfile " + scratch / "broker.pem" + "\nkeyfile " +
                      scratch / "broker.key\n");
    start_broker();
  }
  void openssl(const std::string& arguments) {
    ChildOptions options;
    options.argv = {"sh", "-c", "cd " + scratch.path() + " && openssl " + arguments};
    options.log_file = scratch / "openssl.log";
    std::optional<ChildExit> exit;
    options.on_exit = [&](const ChildExit& e) { exit = e; };
    const auto child = Child::start(loop, std::move(options)).value();
    ASSERT_TRUE(loop.run_until([&] { return exit.has_value(); }, timeout));
    ASSERT_EQ(exit->status, 0) << arguments;
  }
  void start_broker() {
    ChildOptions options;
    options.argv = {"/usr/sbin/mosquitto", "-c", scratch / "tls.conf"};
    options.log_file = scratch / "tls.log";
    broker = Child::start(loop, std::move(options)).value();
  }
  [[nodiscard]] MqttOptions options(const std::string& authority) const {
    MqttOptions made;
    made.port = port;
    made.tls = MqttTls{scratch / authority, scratch / "client.pem", scratch / "client.key"};
    return made;
  }

  Scratch scratch;
  EventLoop loop;
  std::uint16_t port{0};
  std::unique_ptr<Child> broker;
};

TEST_F(Tls, carries_messages_and_reconnects_after_the_broker_was_killed) {
  std::vector<std::string> received;
  MqttHandlers handlers;
  handlers.on_message = [&](std::string_view, std::string_view payload, bool) { received.emplace_back(payload); };
  const auto client = MqttClient::make(loop, options("ca.pem"), {"a"}, std::nullopt, std::move(handlers)).value();
  client->start();
  const std::string big(20'000, 'x');  // more than one TLS record
  Timer talk{loop};
  talk.every(50ms, [&] { client->publish({"a", big, 0, false}); });
  ASSERT_TRUE(loop.run_until([&] { return received.size() >= 3; }, timeout));
  EXPECT_EQ(received.front(), big);
  broker.reset();
  ASSERT_TRUE(loop.run_until([&] { return !client->connected(); }, timeout));
  loop.run_for(300ms);
  received.clear();
  start_broker();
  EXPECT_TRUE(loop.run_until([&] { return received.size() >= 3; }, timeout));
}

TEST_F(Tls, does_not_connect_to_a_broker_unknown_to_its_authority) {
  std::vector<std::string> log;
  MqttHandlers handlers;
  handlers.on_log = [&](char, const std::string& text) { log.push_back(text); };
  const auto client = MqttClient::make(loop, options("other.pem"), {}, std::nullopt, std::move(handlers)).value();
  client->start();
  EXPECT_TRUE(loop.run_until([&] { return !log.empty(); }, timeout));
  loop.run_for(300ms);
  EXPECT_FALSE(client->connected());
  EXPECT_EQ(client->counters().connections, 0U);
}

TEST(BrokerAddress, is_read_in_its_usual_forms) {
  EXPECT_EQ(parse_broker_address("10.0.0.7:8883").value().host, "10.0.0.7");
  EXPECT_EQ(parse_broker_address("10.0.0.7:8883").value().port, 8883);
  EXPECT_EQ(parse_broker_address("broker.example").value().port, 1883);
  EXPECT_EQ(parse_broker_address("[::1]:1884").value().host, "::1");
  EXPECT_EQ(parse_broker_address("[::1]:1884").value().port, 1884);
}

TEST(BrokerAddress, that_is_invalid_is_refused) {
  for (const char* bad : {"", ":1883", "host:", "host:0", "host:65536", "host:12x", "::1", "[::1", "[::1]x", "a b:1"}) {
    const auto parsed = parse_broker_address(bad);
    ASSERT_FALSE(parsed) << bad;
    EXPECT_EQ(parsed.error().code, "broker.address");
  }
}

TEST(PrivateBroker, that_cannot_be_run_is_an_error) {
  Scratch scratch;
  EventLoop loop;
  const auto missing = PrivateBroker::start(loop, {scratch.path(), {}, "/nonexistent/mosquitto"});
  ASSERT_FALSE(missing);
  EXPECT_EQ(missing.error().code, "child.start");
  const auto ends_at_once = PrivateBroker::start(loop, {scratch.path(), {}, "/bin/false"});
  ASSERT_FALSE(ends_at_once);
  EXPECT_EQ(ends_at_once.error().code, "broker.start");
}

}  // namespace
}  // namespace cosiva::adapters
