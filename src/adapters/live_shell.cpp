#include "cosiva/adapters/live_shell.h"

#include <unistd.h>

#include <bit>
#include <deque>
#include <string_view>
#include <utility>

#include "cosiva/adapters/input_queue.h"
#include "cosiva/adapters/live_links.h"
#include "cosiva/adapters/log/log_limiter.h"
#include "cosiva/adapters/state_file.h"
#include "cosiva/base/expect.h"
#include "cosiva/journal/writer.h"

namespace cosiva::adapters {

namespace {

/// "2023-07-11T00:00:00.000Z aiv1 warning: text".
std::string log_line(SimTime at, const std::string& name, char level, const std::string& text) {
  const char* word = level == 'e' ? "error: " : level == 'w' ? "warning: " : "";
  return to_iso8601(at) + " " + name + " " + word + text + "\n";
}

/// A full disk loses lines of the log, and not the log: the number of lost bytes is logged when there is room again.
DiskWriter::Write loses_what_fails(DiskWriter::Write write) {
  return [write = std::move(write), lost = std::size_t{0}](std::string_view bytes) mutable -> Result<void> {
    if (lost > 0) {
      if (!write("\n" + std::to_string(lost) + " bytes of this log are lost: it could not be written\n")) {
        lost += bytes.size();
        return {};
      }
      lost = 0;
    }
    if (!write(bytes)) lost += bytes.size();
    return {};
  };
}

}  // namespace

/// A command that is durable in the store, and that the core was not given yet.
struct StoredCommand {
  std::string source;
  std::string json;
  std::shared_ptr<const wire::InProcessMessage> decoded;
  InputStore::Decided decided;
};

/// The journal of a process that records its inputs.
struct Recording {
  std::unique_ptr<JournalFile> file;
  std::optional<journal::Writer> writer;
};

struct LiveShell::Impl : std::enable_shared_from_this<LiveShell::Impl> {
  Impl(EventLoop& loop_, wire::Core& core_, LiveOptions options_, OpenPorts open_ports_)
      : loop{loop_},
        core{core_},
        options{std::move(options_)},
        open_ports{std::move(open_ports_)},
        runner{core_, [this](const wire::Input& input) { record(input); }},
        log_writer{loop_, loses_what_fails(writes_to(STDERR_FILENO)), {}},
        inputs{[this](const wire::Input& input, InputQueue::Durable durable) { handle(input, std::move(durable)); }},
        tick_timer{loop_},
        links{loop_, handlers()} {}

  void log(char level, const std::string& text) { limiter.log(clock.now(), level, text); }

  // --- inputs ------------------------------------------------------------------------------------------------------

  LinkHandlers handlers() {
    LinkHandlers made;
    made.on_broker = [this](bool up) { deliver(wire::InputKind::link, {}, up ? "up" : "down"); };
    made.on_message = [this](std::string topic, std::string payload, bool retained) {
      deliver(wire::InputKind::message, std::move(topic), std::move(payload), retained);
    };
    made.ports.on_port = [this](const std::string& port, bool up) {
      deliver(wire::InputKind::port, port, up ? "up" : "down");
    };
    made.ports.on_bytes = [this](const std::string& port, std::string_view bytes) {
      deliver(wire::InputKind::bytes, port, std::string(bytes));
    };
    made.on_log = [this](char level, const std::string& text) { log(level, text); };
    return made;
  }

  void deliver(wire::InputKind kind, std::string source, std::string payload, bool flag = false,
               std::shared_ptr<const wire::InProcessMessage> typed = {}) {
    inputs.push({clock.now(), kind, std::move(source), std::move(payload), flag, std::move(typed)});
  }

  void handle(const wire::Input& input, InputQueue::Durable durable) {
    for (const wire::Effect& effect : runner.feed(input)) std::visit([this](const auto& e) { act(e); }, effect);
    complete(std::move(durable));
    if (input.kind == wire::InputKind::tick) limiter.tick(input.at);
    give_earlier_commands();
    if (after_input) after_input();
  }

  /// The input and the state that it made the core persist are stored together.
  void complete(InputQueue::Durable durable) {
    if (!options.store) return durable ? durable() : void();
    if (durable)
      options.store->complete_now(std::move(durable));
    else
      options.store->complete();
  }

  void urgent_command(const std::string& source, std::string json,
                      std::shared_ptr<const wire::InProcessMessage> decoded, std::function<void()> durable) {
    inputs.push({clock.now(), wire::InputKind::command, source, std::move(json), false, std::move(decoded)},
                std::move(durable));
  }

  /// In the order in which they were accepted, which is that of their records.
  void give_earlier_commands() {
    std::deque<StoredCommand>& waiting = restarting.earlier_commands;
    while (!waiting.empty() && core.takes_earlier_command(waiting.front().json)) {
      StoredCommand command = std::move(waiting.front());
      waiting.pop_front();
      give(std::move(command));
    }
  }

  void give(StoredCommand command) {
    deliver(wire::InputKind::command, std::move(command.source), std::move(command.json), true,
            std::move(command.decoded));
    command.decided({});
  }

  void record(const wire::Input& input) {
    if (restarting.replays) return;
    if (recording.writer) recording.writer->append(input);
    if (options.store) options.store->append(input);
  }

  void command(const std::string& source, std::string json, std::shared_ptr<const wire::InProcessMessage> decoded,
               InputStore::Decided decided) {
    if (!decided) decided = [](const Result<void>&) {};
    if (!options.store) {
      deliver(wire::InputKind::command, source, std::move(json), false, std::move(decoded));
      return decided({});
    }
    wire::Input proposal{clock.now(), wire::InputKind::proposal, source, json, false};
    options.store->propose(std::move(proposal),
                           [weak = weak_from_this(), source, json = std::move(json), decoded = std::move(decoded),
                            decided = std::move(decided)](const Result<void>& kept) {
                             const auto self = weak.lock();
                             if (!self) return;
                             if (!kept) return decided(kept);
                             StoredCommand stored{source, json, decoded, decided};
                             if (self->restarting.earlier_commands.empty()) return self->give(std::move(stored));
                             self->restarting.earlier_commands.push_back(std::move(stored));
                           });
  }

  // --- effects -----------------------------------------------------------------------------------------------------

  void act(const wire::Publish& publish) { links.act(publish); }
  void act(const wire::SendBytes& send) { links.act(send); }
  void act(const wire::Listen& listen) {
    restarting.listens = listen.filters;
    links.act(listen);
  }
  void act(const wire::Log& line) { log(line.level, line.text); }
  void act(const wire::Persist& persist) {
    if (options.store)
      return options.store->append({clock.now(), wire::InputKind::persisted, {}, persist.bytes, false});
    if (!state_file) return;
    if (auto stored = state_file->store(persist.bytes); !stored) {
      log('e', "no state is stored from now on: " + to_string(stored.error()));
      state_file.reset();
    }
  }

  // --- starting and ending ------------------------------------------------------------------------------------------

  Result<void> open_journal() {
    if (options.record_file.empty()) return {};
    auto file =
        JournalFile::create(loop, options.record_file, [this](const Error& error) { log('e', to_string(error)); });
    if (!file) return tl::unexpected(file.error());
    recording.file = std::move(*file);
    recording.writer.emplace([this](std::string_view bytes) { recording.file->append(bytes); });
    return {};
  }

  /// Gives the core what an earlier process left: its complete state, or else what it persisted; and the commands that
  /// were accepted from its users.
  void restore() {
    InputStore::Left left;
    if (options.store) left = options.store->take_left();
    if (state_file) left.persisted = state_file->load();
    if (continue_state(left)) {
      deliver(wire::InputKind::link, {}, "down");
    } else {
      deliver(wire::InputKind::configure, options.kind, options.options);
      if (left.persisted) deliver(wire::InputKind::restore, "state", std::move(*left.persisted));
    }
    for (wire::Input& command : left.accepted)
      restarting.earlier_commands.push_back(
          {std::move(command.source), std::move(command.payload), {}, [](const Result<void>&) {}});
    give_earlier_commands();
  }

  /// The effects of the earlier inputs are not acted upon again. A journal must begin with `configure`: a core that
  /// records one does not continue.
  bool continue_state(const InputStore::Left& left) {
    if (recording.writer) return false;
    if (left.state) {
      if (const auto continued = core.continue_from(left.state->snapshot); !continued) {
        log('w', "continues with the persisted state only: " + to_string(continued.error()));
        return false;
      }
      runner.continue_history(std::bit_cast<Digest>(left.state->history));
      restarting.listens = left.state->listens;
    } else if (left.inputs.empty() || left.inputs.front().source != options.kind ||
               left.inputs.front().payload != options.options) {
      return false;
    }
    restarting.replays = true;
    for (const wire::Input& input : left.inputs) {
      for (const wire::Effect& effect : runner.feed(input))
        if (const auto* listen = std::get_if<wire::Listen>(&effect)) restarting.listens = listen->filters;
    }
    restarting.replays = false;
    if (!restarting.listens.empty()) links.act(wire::Listen{restarting.listens});
    return true;
  }

  [[nodiscard]] std::optional<journal::CoreState> complete_state() const {
    auto snapshot = core.snapshot();
    if (!snapshot) return std::nullopt;
    return journal::CoreState{std::move(*snapshot), runner.history().value(), restarting.listens};
  }

  Result<void> start() {
    if (auto opened = open_journal(); !opened) return opened;
    if (!options.state_file.empty() && !options.store) state_file.emplace(options.state_file);
    COSIVA_EXPECT(inputs.handled() == 0);
    if (options.store) options.store->set_complete_state([this] { return complete_state(); });
    restore();
    if (options.mqtt) {
      if (auto prepared = links.prepare(*options.mqtt, core, options.obeys_radio); !prepared) return prepared;
    }
    if (open_ports) {
      if (auto opened = links.open(open_ports); !opened) return opened;
    }
    links.start();
    tick_timer.every(core.tick_period(), [this] { deliver(wire::InputKind::tick, {}, {}); });
    return {};
  }

  void stop(const std::function<void(const std::string&)>& done) {
    if (inputs.closed()) return;
    inputs.close();
    tick_timer.cancel();
    // The digest covers what replay can repeat: every input and its effects. The farewell belongs to no input.
    const std::string digest = runner.digest().hex();
    const SimTime at = clock.now();
    links.end_radio();
    wire::Effects effects;
    core.farewell(at, effects);
    for (const wire::Effect& effect : effects) std::visit([this](const auto& e) { act(e); }, effect);
    if (recording.writer) {
      recording.writer->end(at, digest);
      recording.file->flush();
    }
    if (options.store) options.store->drain();
    links.stop([this, done, digest] {
      limiter.flush();
      log_writer.drain();
      done(digest);
    });
  }

  EventLoop& loop;
  wire::Core& core;
  LiveOptions options;
  OpenPorts open_ports;
  WallClock clock;
  wire::CoreRunner runner;
  DiskWriter log_writer;  ///< on stderr: the reader of the log, or its disk, must not block us
  LogLimiter limiter{[this](char level, const std::string& text) {
    log_writer.append(log_line(clock.now(), options.name, level, text));
  }};
  Recording recording;
  std::optional<StateFile> state_file;
  InputQueue inputs;
  struct Restarting {
    std::deque<StoredCommand> earlier_commands;  ///< of an earlier process, and behind them those accepted meanwhile
    std::vector<std::string> listens;            ///< of the core's last Listen
    bool replays{false};                         ///< the core is given inputs of an earlier process
  };
  Restarting restarting;
  Timer tick_timer;
  std::function<void()> after_input;
  LiveLinks links;  ///< last, so that they are destroyed first: their handlers use all of the above
};

LiveShell::LiveShell(EventLoop& loop, wire::Core& core, LiveOptions options, OpenPorts open_ports)
    : impl_{std::make_shared<Impl>(loop, core, std::move(options), std::move(open_ports))} {}

LiveShell::~LiveShell() = default;

Result<void> LiveShell::start() { return impl_->start(); }
void LiveShell::command(const std::string& source, std::string json,
                        std::shared_ptr<const wire::InProcessMessage> decoded, InputStore::Decided decided) {
  impl_->command(source, std::move(json), std::move(decoded), std::move(decided));
}
void LiveShell::urgent_command(const std::string& source, std::string json,
                               std::shared_ptr<const wire::InProcessMessage> decoded, std::function<void()> durable) {
  impl_->urgent_command(source, std::move(json), std::move(decoded), std::move(durable));
}
void LiveShell::after_input(std::function<void()> action) { impl_->after_input = std::move(action); }
void LiveShell::stop(const std::function<void(const std::string& digest)>& done) { impl_->stop(done); }
bool LiveShell::gives_earlier_commands() const {
  return !impl_->restarting.earlier_commands.empty() || !impl_->inputs.empty();
}
bool LiveShell::link_up() const { return impl_->links.up(); }
std::uint64_t LiveShell::inputs() const { return impl_->inputs.handled(); }

}  // namespace cosiva::adapters
