#include "cosiva/adapters/live_shell.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <unistd.h>

#include <array>
#include <csignal>

#include "cosiva/adapters/broker.h"
#include "cosiva/adapters/state_file.h"
#include "cosiva/adapters/test_fixture.h"
#include "cosiva/adapters/unix_ports.h"
#include "cosiva/base/digest.h"
#include "cosiva/journal/replay.h"

namespace cosiva::adapters {
namespace {

using namespace std::chrono_literals;
using ::testing::Contains;
using ::testing::HasSubstr;
using testing::Scratch;
using testing::timeout;

/// Responds to its inputs: echoes messages and bytes, persists commands, counts ticks.
class EchoCore final : public wire::Core {
 public:
  void handle(const wire::Input& input, wire::Effects& effects) override {
    received.push_back(std::to_string(static_cast<int>(input.kind)) + ":" + input.source + ":" + input.payload);
    if (input.kind != wire::InputKind::tick) state += received.back();
    last = std::max(last, input.at);
    if (input.at < last) went_back = true;
    switch (input.kind) {
      case wire::InputKind::message: effects.push_back(wire::Publish{"echo", input.payload, 0, false}); break;
      case wire::InputKind::bytes: effects.push_back(wire::SendBytes{input.source, "<" + input.payload + ">"}); break;
      case wire::InputKind::command: effects.push_back(wire::Persist{input.payload}); break;
      case wire::InputKind::tick: ++ticks; break;
      case wire::InputKind::link:
        if (input.payload == "up") effects.push_back(wire::Publish{"hello", "ONLINE", 1, true});
        break;
      default: break;
    }
  }
  [[nodiscard]] SimDuration tick_period() const override { return 20ms; }
  [[nodiscard]] std::vector<std::string> subscriptions() const override { return {"to_core"}; }
  [[nodiscard]] std::optional<wire::Will> will() const override {
    return wire::Will{{"hello", "CONNECTIONBROKEN", 1, true}};
  }
  void farewell(SimTime, wire::Effects& effects) override {
    state += "farewell";  // must not show in the digest of the run
    effects.push_back(wire::Publish{"hello", "OFFLINE", 1, true});
  }
  void fold(Digest& digest) const override { digest.add(std::string_view{state}); }

  std::vector<std::string> received;
  std::string state;
  SimTime last{};
  bool went_back{false};
  int ticks{0};
};

class Shell : public ::testing::Test {
 protected:
  LiveOptions options() {
    LiveOptions made;
    made.kind = "echo";
    made.options = "{}";
    made.name = "echo";
    return made;
  }
  std::string stop(LiveShell& shell) {
    std::string digest;
    shell.stop([&](const std::string& d) { digest = d; });
    EXPECT_TRUE(loop.run_until([&] { return !digest.empty(); }, timeout));
    return digest;
  }

  Scratch scratch;
  EventLoop loop;
};

/// A pipe that takes nothing more until it is read.
struct FullPipe {
  FullPipe() {
    std::array<int, 2> ends{};
    EXPECT_EQ(::pipe2(ends.data(), O_CLOEXEC | O_NONBLOCK), 0);
    read_end = ends[0];
    write_end = ends[1];
    const std::string much(4096, '.');
    while (::write(write_end, much.data(), much.size()) > 0) {
    }
    ::fcntl(write_end, F_SETFL, 0);
    ::fcntl(read_end, F_SETFL, 0);
  }
  ~FullPipe() {
    ::close(read_end);
    ::close(write_end);
  }
  FullPipe(const FullPipe&) = delete;
  FullPipe& operator=(const FullPipe&) = delete;
  std::string read_until(std::string_view text) const {
    std::string all;
    std::array<char, 4096> some{};
    while (all.find(text) == std::string::npos) {
      const ssize_t got = ::read(read_end, some.data(), some.size());
      if (got <= 0) break;
      all.append(some.data(), static_cast<std::size_t>(got));
    }
    return all;
  }
  int read_end{-1};
  int write_end{-1};
};

/// `fd` is `other` as long as this object exists.
class RedirectedTo {
 public:
  RedirectedTo(int fd, int other) : fd_{fd}, was_{::dup(fd)} { ::dup2(other, fd); }
  ~RedirectedTo() {
    ::dup2(was_, fd_);
    ::close(was_);
  }
  RedirectedTo(const RedirectedTo&) = delete;
  RedirectedTo& operator=(const RedirectedTo&) = delete;

 private:
  int fd_;
  int was_;
};

TEST_F(Shell, feeds_configure_first_then_state_then_ticks_in_order_of_time) {
  scratch.write("state", "persisted");
  EchoCore core;
  LiveOptions with_state_file = options();
  with_state_file.state_file = scratch / "state";
  LiveShell shell{loop, core, with_state_file};
  ASSERT_TRUE(shell.start());
  ASSERT_TRUE(loop.run_until([&] { return core.ticks >= 3; }, timeout));
  ASSERT_GE(core.received.size(), 3U);
  EXPECT_EQ(core.received[0], "1:echo:{}");
  EXPECT_EQ(core.received[1], "8:state:persisted");
  EXPECT_EQ(core.received[2], "7::");
  EXPECT_FALSE(core.went_back);
}

TEST_F(Shell, stores_the_state_that_the_core_persists) {
  EchoCore core;
  LiveOptions with_state_file = options();
  with_state_file.state_file = scratch / "state";
  LiveShell shell{loop, core, with_state_file};
  ASSERT_TRUE(shell.start());
  shell.command("test", "place=3");
  EXPECT_EQ(StateFile{scratch / "state"}.load(), "place=3") << "at once: a moment later it may be killed";
}

TEST_F(Shell, runs_a_core_over_a_real_broker_and_real_sockets_and_the_journal_replays_to_the_same_digest) {
  const auto broker = PrivateBroker::start(loop, {scratch.path(), scratch / "broker.log", {}}).value();
  EchoCore core;
  LiveOptions live = options();
  live.record_file = scratch / "run.journal";
  live.mqtt = MqttOptions{};
  live.mqtt->port = broker->port();
  LiveShell shell{loop, core, live, [&](PortHandlers handlers) {
                    return listen_unix_ports(loop, scratch.path(), {"1/PILS"}, std::move(handlers));
                  }};
  ASSERT_TRUE(shell.start());

  std::vector<std::string> received;
  MqttHandlers handlers;
  handlers.on_message = [&](std::string_view topic, std::string_view payload, bool) {
    received.push_back(std::string(topic) + "=" + std::string(payload));
  };
  MqttOptions peer_options;
  peer_options.port = broker->port();
  const auto peer = MqttClient::make(loop, peer_options, {"echo", "hello"}, std::nullopt, std::move(handlers)).value();
  peer->start();
  std::string wire_bytes;
  const auto wire = connect_unix_ports(loop, scratch.path(), {"1/PILS"},
                                       {{}, [&](const std::string&, std::string_view bytes) { wire_bytes += bytes; }})
                        .value();

  Timer talk{loop};
  talk.every(20ms, [&] {
    peer->publish({"to_core", "ping", 0, false});
    wire->send("1/PILS", "x");
  });
  const auto echoed = [&] { return std::ranges::count(received, "echo=ping") >= 3 && wire_bytes.size() >= 9; };
  ASSERT_TRUE(loop.run_until(echoed, timeout));
  shell.command("test", "note");
  talk.cancel();
  const std::string digest = stop(shell);
  EXPECT_THAT(core.state, HasSubstr("farewell"));
  EXPECT_TRUE(loop.run_until([&] { return std::ranges::count(received, "hello=OFFLINE") == 1; }, timeout));
  EXPECT_THAT(received, Contains("hello=ONLINE"));
  EXPECT_EQ(wire_bytes.substr(0, 1), "<");

  const std::string journal = read_file(scratch / "run.journal").value();
  const auto replayed = journal::replay(
      journal, [](const wire::Input&) -> Result<std::unique_ptr<wire::Core>> { return std::make_unique<EchoCore>(); });
  ASSERT_TRUE(replayed) << to_string(replayed.error());
  EXPECT_EQ(replayed->digest, digest);
  EXPECT_EQ(replayed->recorded_digest, digest);
  EXPECT_EQ(replayed->inputs, shell.inputs());
}

TEST_F(Shell, reports_to_the_core_when_its_broker_dies_and_when_it_is_back) {
  const auto broker = PrivateBroker::start(loop, {scratch.path(), scratch / "broker.log", {}}).value();
  EchoCore core;
  LiveOptions live = options();
  live.mqtt = MqttOptions{};
  live.mqtt->port = broker->port();
  LiveShell shell{loop, core, live};
  ASSERT_TRUE(shell.start());
  ASSERT_TRUE(loop.run_until([&] { return shell.link_up(); }, timeout));
  broker->child()->signal(SIGKILL);
  ASSERT_TRUE(loop.run_until([&] { return !broker->child()->running() && !shell.link_up(); }, timeout));
  ASSERT_TRUE(broker->restart());
  ASSERT_TRUE(loop.run_until([&] { return shell.link_up(); }, timeout));
  std::vector<std::string> links;
  std::ranges::copy_if(core.received, std::back_inserter(links),
                       [](const std::string& line) { return line.starts_with("3:"); });
  EXPECT_THAT(links, ::testing::ElementsAre("3::up", "3::down", "3::up"));
}

TEST_F(Shell, of_an_emulated_vehicle_loses_the_radios_messages_without_a_trace_in_core_and_journal) {
  const auto broker = PrivateBroker::start(loop, {scratch.path(), scratch / "broker.log", {}}).value();
  EchoCore core;
  LiveOptions live = options();
  live.mqtt = MqttOptions{};
  live.mqtt->port = broker->port();
  live.obeys_radio = "CoSiVA/AIV1";
  LiveShell shell{loop, core, live};
  ASSERT_TRUE(shell.start());
  int echoes = 0;
  MqttHandlers handlers;
  handlers.on_message = [&](std::string_view, std::string_view, bool) { ++echoes; };
  MqttOptions peer_options;
  peer_options.port = broker->port();
  const auto peer = MqttClient::make(loop, peer_options, {"echo"}, std::nullopt, std::move(handlers)).value();
  peer->start();
  Timer talk{loop};
  talk.every(5ms, [&] { peer->publish({"to_core", "ping", 0, false}); });
  const auto received = [&] { return std::ranges::count(core.received, "2:to_core:ping"); };
  ASSERT_TRUE(loop.run_until([&] { return echoes >= 3; }, timeout));

  // Everything is lost: no message arrives however long the test waits, and none that the core sends is delivered.
  peer->publish({"cosiva/v1/plant/radio", R"({"vehicle":"CoSiVA/AIV1","loss":1})", 1, false});
  loop.run_for(100ms);
  const auto before = received();
  const int echoes_before = echoes;
  loop.run_for(100ms);
  EXPECT_EQ(received(), before);
  EXPECT_EQ(echoes, echoes_before);

  peer->publish({"cosiva/v1/plant/radio", R"({"vehicle":"*","loss":0})", 1, false});
  EXPECT_TRUE(loop.run_until([&] { return echoes > echoes_before; }, timeout));
  EXPECT_THAT(core.received, ::testing::Not(Contains(HasSubstr("plant/radio"))));
  stop(shell);
}

TEST_F(Shell, continues_when_the_disk_of_its_journal_is_full) {
  EchoCore core;
  LiveOptions live = options();
  live.record_file = "/dev/full";
  LiveShell shell{loop, core, live};
  ASSERT_TRUE(shell.start());
  ::testing::internal::CaptureStderr();
  const int before = core.ticks;
  EXPECT_TRUE(loop.run_until([&] { return core.ticks >= before + 10; }, timeout));
  EXPECT_EQ(stop(shell).size(), 16U);
  EXPECT_THAT(::testing::internal::GetCapturedStderr(), HasSubstr("the journal stops here"));
}

TEST_F(Shell, continues_when_its_log_is_not_read) {
  FullPipe log;  // as behind a pager that waits for its user
  EchoCore core;
  LiveOptions live = options();
  live.record_file = "/dev/full";  // so that there is an error to log
  LiveShell shell{loop, core, live};
  {
    const RedirectedTo stderr_is{STDERR_FILENO, log.write_end};
    ASSERT_TRUE(shell.start());
    EXPECT_TRUE(loop.run_until([&] { return core.ticks >= 20; }, timeout));
    EXPECT_THAT(log.read_until("the journal stops here"), HasSubstr("the journal stops here"));
    stop(shell);
  }
}

TEST_F(Shell, does_not_start_with_an_unusable_journal_or_port) {
  EchoCore core;
  LiveOptions live = options();
  live.record_file = "/nonexistent/run.journal";
  LiveShell without_journal{loop, core, live};
  EXPECT_EQ(without_journal.start().error().code, "journal.open");
  LiveShell without_ports{loop, core, options(),
                          [](PortHandlers) -> Result<std::unique_ptr<Ports>> { return fail("port.listen", "no"); }};
  EXPECT_EQ(without_ports.start().error().code, "port.listen");
}

TEST_F(Shell, ends_its_journal_after_the_last_input_that_the_core_handled) {
  EchoCore core;
  LiveOptions recorded = options();
  recorded.record_file = scratch / "journal";
  LiveShell shell{loop, core, recorded};
  ASSERT_TRUE(shell.start());
  std::string digest;
  shell.after_input([&] {
    if (core.received.back() != "6:test:first") return;
    shell.command("test", "waits while the first is handled");
    shell.stop([&](const std::string& d) { digest = d; });
  });
  shell.command("test", "first");
  ASSERT_TRUE(loop.run_until([&] { return !digest.empty(); }, timeout));
  EXPECT_EQ(core.received.back(), "6:test:first");
  const auto replayed = journal::replay(read_file(scratch / "journal").value(),
                                        [](const wire::Input&) { return std::make_unique<EchoCore>(); });
  ASSERT_TRUE(replayed) << to_string(replayed.error());
  EXPECT_EQ(replayed->digest, digest);
  EXPECT_EQ(replayed->recorded_digest, digest);
}

TEST_F(Shell, receives_nothing_more_once_stopped) {
  EchoCore core;
  LiveShell shell{loop, core, options()};
  ASSERT_TRUE(shell.start());
  stop(shell);
  const std::size_t received = core.received.size();
  shell.command("test", "late");
  loop.run_for(60ms);
  EXPECT_EQ(core.received.size(), received);
}

}  // namespace
}  // namespace cosiva::adapters
