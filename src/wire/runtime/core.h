#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/digest.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"

namespace cosiva::wire {

/// A message as values instead of text, between cores of one process (in_process messages,
/// wire/in_process/typed_message.h). This interface covers only what the digest needs; sender and receiver agree on the
/// rest.
class InProcessMessage {
 public:
  virtual ~InProcessMessage() = default;
  /// The kind of message and its number; its content shows in the digests of the cores that act upon it.
  virtual void fold(Digest& digest) const = 0;

 protected:
  InProcessMessage() = default;
  InProcessMessage(const InProcessMessage&) = default;
  InProcessMessage& operator=(const InProcessMessage&) = default;
  InProcessMessage(InProcessMessage&&) = default;
  InProcessMessage& operator=(InProcessMessage&&) = default;
};

/// Stores null only; a message as values makes the archive fail, because this interface does not know its kind.
void archive_value(Archive& archive, std::shared_ptr<const InProcessMessage>& message);

/// Every kind of input of a core. One record type for all cores: the journal stores it, the network delivers it, replay
/// feeds it again. The journal stores these numbers; never reuse one.
enum class InputKind : std::uint8_t {
  configure = 1,  ///< first input of every core: source = what ("aiv", "plant", "server"), payload = its options (JSON)
  message = 2,    ///< from the broker: source = topic, payload = bytes, flag = retained
  link = 3,       ///< the broker connection: payload "up" or "down"
  bytes = 4,      ///< from a byte stream: source = port name, payload = the bytes received
  port = 5,       ///< a byte stream opened or closed: source = port name, payload "up" or "down"
  command = 6,    ///< from a person or program on this machine: source = the sender, payload = JSON
  tick = 7,       ///< the core's own timer, every tick_period()
  restore = 8,    ///< what Persist stored before the last stop; payload = bytes, only right after configure
  proposal = 9,   ///< a command in a store that the core is given once this record is durable, as `command` with flag
  persisted = 10,  ///< in a store: the state that the core has persisted, with which `restore` continues
  snapshot = 11,   ///< in a store: the complete state of the core (journal/store/core_state.h)
};

struct Input {
  SimTime at;
  InputKind kind;
  std::string source;
  std::string payload;
  bool flag{false};
  /// The content as values: of a message or of frames, whose payload is empty then, or of a decoded command, next to
  /// its text.
  std::shared_ptr<const InProcessMessage> typed{};
  friend bool operator==(const Input&, const Input&) = default;
};

struct Publish {
  std::string topic;
  std::string payload;
  int qos{0};
  bool retained{false};
  /// The content, where it is passed on as values (in_process/typed_message.h); the payload is empty then.
  std::shared_ptr<const InProcessMessage> typed{};
  friend bool operator==(const Publish&, const Publish&) = default;
};
/// Bytes to a stream, such as a frame to a board.
struct SendBytes {
  std::string port;
  std::string bytes;
  /// Frames to or from boards, where they are passed on as values (in_process/board_frames.h); `bytes` is empty then.
  std::shared_ptr<const InProcessMessage> typed{};
  friend bool operator==(const SendBytes&, const SendBytes&) = default;
};
/// Store these few bytes over a crash of the process; each replaces the last.
struct Persist {
  std::string bytes;
  friend bool operator==(const Persist&, const Persist&) = default;
};
/// A line for the log: level 'i', 'w' or 'e'. Not part of the digest.
struct Log {
  char level;
  std::string text;
  friend bool operator==(const Log&, const Log&) = default;
};
/// Receive these topics from now on, in addition to subscriptions(); each replaces the last. None are received before
/// the first. A lost connection changes nothing.
struct Listen {
  std::vector<std::string> filters;
  friend bool operator==(const Listen&, const Listen&) = default;
};
using Effect = std::variant<Publish, SendBytes, Persist, Log, Listen>;
using Effects = std::vector<Effect>;

struct Will {
  Publish message;
};

/// One deciding part of the platform: the on-board program, the plant, or the server with its simulator. A core takes
/// inputs with their time and returns effects; it owns no socket, thread, file or clock. Live processes, the
/// virtual-time world, the fault tests and replay all drive this interface.
class Core {
 public:
  virtual ~Core() = default;
  virtual void handle(const Input& input, Effects& effects) = 0;
  [[nodiscard]] virtual SimDuration tick_period() const = 0;
  [[nodiscard]] virtual std::vector<std::string> subscriptions() const = 0;  ///< MQTT topic filters, constant
  [[nodiscard]] virtual std::optional<Will> will() const { return std::nullopt; }
  /// Whether this core can carry out a command that an earlier process accepted and was not given: a core may have to
  /// learn first what the command is about.
  [[nodiscard]] virtual bool takes_earlier_command(std::string_view /*json*/) const { return true; }
  /// Last messages before a clean end (VDA 5050: OFFLINE before DISCONNECT).
  virtual void farewell(SimTime /*now*/, Effects& /*effects*/) {}
  /// Folds the core's state at the end into the run's digest.
  virtual void fold(Digest& digest) const = 0;

  /// The complete state between two inputs: another core with the same options that continues from it gives the same
  /// effects to the same further inputs, and has the same digest. Fails ("snapshot.unsupported") where the core has no
  /// snapshots, or something in its present state cannot be stored.
  [[nodiscard]] virtual Result<std::string> snapshot() const;
  /// Takes the state of snapshot(), instead of `configure` and `restore`: only before the first input. Fails with a
  /// "snapshot." code where the bytes are damaged, of another format, or of a core with other options; the core is then
  /// unused, as it was.
  [[nodiscard]] virtual Result<void> continue_from(std::string_view snapshot);
};

/// Feeds a core: first records the input, then lets the core act, then folds its effects (the journal's rule).
class CoreRunner {
 public:
  using Recorder = std::function<void(const Input&)>;
  explicit CoreRunner(Core& core, Recorder recorder = {}) : core_{core}, recorder_{std::move(recorder)} {}

  /// The effects stay valid until the next call. A recorder needs texts: no input may be passed to it as values
  /// without its text (checked).
  const Effects& feed(const Input& input);
  /// Digest of all inputs' times and all effects so far, and the core's state now.
  [[nodiscard]] Digest digest() const;
  /// The same of the inputs and effects only: with a snapshot of the core, what its successor continues from.
  [[nodiscard]] Digest history() const { return digest_; }
  void continue_history(Digest history) { digest_ = history; }
  [[nodiscard]] Core& core() { return core_; }

 private:
  Core& core_;
  Recorder recorder_;
  Effects effects_;
  Digest digest_;
};

/// MQTT's rule: '+' one level, '#' the rest.
[[nodiscard]] bool topic_matches(std::string_view filter, std::string_view topic);

}  // namespace cosiva::wire
