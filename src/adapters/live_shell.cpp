#include "cosiva/adapters/live_shell.h"

#include <unistd.h>

#include <deque>
#include <utility>

#include "cosiva/adapters/lossy_radio.h"
#include "cosiva/adapters/state_file.h"
#include "cosiva/base/expect.h"
#include "cosiva/journal/writer.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::adapters {

namespace {

/// "2023-07-11T00:00:00.000Z aiv1 warning: text".
std::string log_line(SimTime at, const std::string& name, char level, const std::string& text) {
  const char* word = level == 'e' ? "error: " : level == 'w' ? "warning: " : "";
  return to_iso8601(at) + " " + name + " " + word + text + "\n";
}

}  // namespace

struct LiveShell::Impl : std::enable_shared_from_this<LiveShell::Impl> {
  Impl(EventLoop& loop_, wire::Core& core_, LiveOptions options_, OpenPorts open_ports_)
      : loop{loop_},
        core{core_},
        options{std::move(options_)},
        open_ports{std::move(open_ports_)},
        runner{core_, [this](const wire::Input& input) { record(input); }},
        log_writer{loop_, writes_to(STDERR_FILENO), {}},
        tick_timer{loop_} {}

  void log(char level, const std::string& text) { log_writer.append(log_line(clock.now(), options.name, level, text)); }

  // --- inputs
  // ---------------------------------------------------------------------------------------------------------

  void record(const wire::Input& input) {
    if (writer) writer->append(input);
  }

  /// Performing an effect may produce the next input at once (a publish that finds the connection broken): that input
  /// waits its turn, because the runner's effects are valid only until the next feed.
  void deliver(wire::InputKind kind, std::string source, std::string payload, bool flag = false,
               std::shared_ptr<const wire::InProcessMessage> typed = {}) {
    if (stopped) return;
    waiting.push_back({clock.now(), kind, std::move(source), std::move(payload), flag, std::move(typed)});
    if (std::exchange(feeding, true)) return;
    while (!waiting.empty()) {
      const wire::Input input = std::move(waiting.front());
      waiting.pop_front();
      ++inputs;
      for (const wire::Effect& effect : runner.feed(input)) std::visit([this](const auto& e) { act(e); }, effect);
      if (after_input) after_input();
    }
    feeding = false;
  }

  void receive_message(std::string topic, std::string payload, bool retained) {
    if (!radio) return deliver(wire::InputKind::message, std::move(topic), std::move(payload), retained);
    if (radio->take(topic, payload)) return;
    const int qos = qos_of_received(topic);
    radio->receive(qos, [this, topic = std::move(topic), payload = std::move(payload), retained] {
      deliver(wire::InputKind::message, topic, payload, retained);
    });
  }

  // --- effects
  // --------------------------------------------------------------------------------------------------------

  void act(const wire::Publish& publish) {
    if (!mqtt) return;
    if (!radio) {
      mqtt->publish(publish);
    } else {
      radio->send(publish.qos, [this, publish] { mqtt->publish(publish); });
    }
  }
  void act(const wire::SendBytes& send) {
    if (ports) ports->send(send.port, send.bytes);
  }
  void act(const wire::Listen& listen) {
    if (mqtt) mqtt->listen(listen.filters);
  }
  void act(const wire::Persist& persist) {
    if (!state_file) return;
    if (auto stored = state_file->store(persist.bytes); !stored) {
      log('e', "no state is stored from now on: " + to_string(stored.error()));
      state_file.reset();
    }
  }
  void act(const wire::Log& line) { log(line.level, line.text); }

  // --- starting and ending ------------------------------------------------------------------------------------------

  Result<void> open_journal() {
    if (options.record_file.empty()) return {};
    auto file =
        JournalFile::create(loop, options.record_file, [this](const Error& error) { log('e', to_string(error)); });
    if (!file) return tl::unexpected(file.error());
    journal = std::move(*file);
    writer.emplace([this](std::string_view bytes) { journal->append(bytes); });
    return {};
  }

  Result<void> connect() {
    if (!options.mqtt) return {};
    MqttHandlers handlers;
    handlers.on_link = [this](bool up) { deliver(wire::InputKind::link, {}, up ? "up" : "down"); };
    handlers.on_message = [this](std::string_view topic, std::string_view payload, bool retained) {
      receive_message(std::string(topic), std::string(payload), retained);
    };
    handlers.on_log = [this](char level, const std::string& text) { log(level, text); };
    auto filters = core.subscriptions();
    if (!options.obeys_radio.empty()) {
      radio.emplace(loop, options.obeys_radio);
      filters.emplace_back(wire::plant_radio_topic);
    }
    auto made = MqttClient::make(loop, *options.mqtt, std::move(filters), core.will(), std::move(handlers));
    if (!made) return tl::unexpected(made.error());
    mqtt = std::move(*made);
    return {};
  }

  Result<void> start() {
    if (auto opened = open_journal(); !opened) return opened;
    if (!options.state_file.empty()) state_file.emplace(options.state_file);
    COSIVA_EXPECT(inputs == 0);
    deliver(wire::InputKind::configure, options.kind, options.options);
    if (state_file) {
      if (auto bytes = state_file->load()) deliver(wire::InputKind::restore, "state", std::move(*bytes));
    }
    if (auto prepared = connect(); !prepared) return prepared;
    if (open_ports) {
      PortHandlers handlers;
      handlers.on_port = [this](const std::string& port, bool up) {
        deliver(wire::InputKind::port, port, up ? "up" : "down");
      };
      handlers.on_bytes = [this](const std::string& port, std::string_view bytes) {
        deliver(wire::InputKind::bytes, port, std::string(bytes));
      };
      auto opened = open_ports(std::move(handlers));
      if (!opened) return tl::unexpected(opened.error());
      ports = std::move(*opened);
    }
    if (mqtt) mqtt->start();
    tick_timer.every(core.tick_period(), [this] { deliver(wire::InputKind::tick, {}, {}); });
    return {};
  }

  void stop(std::function<void(const std::string&)> done) {
    if (stopped) return;
    stopped = true;
    tick_timer.cancel();
    // The digest covers what replay can repeat: every input and its effects. The farewell belongs to no input.
    const std::string digest = runner.digest().hex();
    const SimTime at = clock.now();
    if (radio) radio->end();
    wire::Effects effects;
    core.farewell(at, effects);
    for (const wire::Effect& effect : effects) std::visit([this](const auto& e) { act(e); }, effect);
    if (writer) {
      writer->end(at, digest);
      journal->flush();
    }
    const auto finish = [this, done = std::move(done), digest] {
      log_writer.drain();
      done(digest);
    };
    if (mqtt) {
      mqtt->stop(finish);
    } else {
      loop.post(finish);
    }
  }

  EventLoop& loop;
  wire::Core& core;
  LiveOptions options;
  OpenPorts open_ports;
  WallClock clock;
  wire::CoreRunner runner;
  DiskWriter log_writer;  ///< on stderr: the reader of the log, or its disk, must not block us
  std::unique_ptr<JournalFile> journal;
  std::optional<journal::Writer> writer;
  std::optional<StateFile> state_file;
  std::optional<LossyRadio> radio;
  Timer tick_timer;
  std::deque<wire::Input> waiting;
  std::function<void()> after_input;
  std::uint64_t inputs{0};
  bool feeding{false};
  bool stopped{false};
  // Last, so that they are destroyed first: their handlers use all of the above.
  std::unique_ptr<Ports> ports;
  std::unique_ptr<MqttClient> mqtt;
};

LiveShell::LiveShell(EventLoop& loop, wire::Core& core, LiveOptions options, OpenPorts open_ports)
    : impl_{std::make_shared<Impl>(loop, core, std::move(options), std::move(open_ports))} {}

LiveShell::~LiveShell() = default;

Result<void> LiveShell::start() { return impl_->start(); }
void LiveShell::command(const std::string& source, std::string json,
                        std::shared_ptr<const wire::InProcessMessage> decoded) {
  impl_->deliver(wire::InputKind::command, source, std::move(json), false, std::move(decoded));
}
void LiveShell::after_input(std::function<void()> action) { impl_->after_input = std::move(action); }
void LiveShell::stop(std::function<void(const std::string& digest)> done) { impl_->stop(std::move(done)); }
bool LiveShell::link_up() const { return impl_->mqtt && impl_->mqtt->connected(); }
std::uint64_t LiveShell::inputs() const { return impl_->inputs; }

}  // namespace cosiva::adapters
