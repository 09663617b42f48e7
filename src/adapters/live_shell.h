#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "cosiva/adapters/clock.h"
#include "cosiva/adapters/event_loop.h"
#include "cosiva/adapters/files.h"
#include "cosiva/adapters/input_store.h"
#include "cosiva/adapters/mqtt_client.h"
#include "cosiva/adapters/ports.h"
#include "cosiva/base/result.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::adapters {

struct LiveOptions {
  std::string kind;     ///< "server", "plant" or "aiv": the source of the configure input, which replay uses
  std::string options;  ///< its payload: the core's options as JSON
  std::string name;     ///< before each line of the log: "aiv1"
  std::optional<MqttOptions> mqtt;
  std::string record_file;  ///< empty: no journal
  std::string state_file;   ///< empty: state that the core wants to persist is dropped, unless there is a store
  /// Keeps all inputs and the persisted state, in place of a state file; null: no store.
  std::shared_ptr<InputStore> store;
  /// "CoSiVA/AIV2" for an *emulated* vehicle's program: it loses messages as described at wire::plant_radio_topic; its
  /// core is not informed, and the journal holds the messages that got through. Empty for everything physical.
  std::string obeys_radio;
};

/// Runs one core live: feeds it messages, bytes, ticks and commands with the wall clock's time, and performs its
/// effects. Every input of the core passes through one function, so the journal is complete. Journal and log, on
/// stderr, never delay the core; its state is persisted before its next effects are performed.
///
/// Invariant: the core's first input is its configuration, and the core handles one input at a time.
class LiveShell {
 public:
  LiveShell(EventLoop& loop, wire::Core& core, LiveOptions options, OpenPorts open_ports = {});
  ~LiveShell();

  /// Configures the core, restores its state, opens ports and connection, starts its ticks. Fails when the journal, the
  /// ports or the connection's options cannot be used.
  [[nodiscard]] Result<void> start();
  /// A command, which the core is given once its store has it for good, and at once where there is no store.
  /// @param decoded  the same command where the sender has decoded it; null: the core decodes it
  /// @param decided  called when the core has been given the command, or with the reason why it was not; may be empty
  void command(const std::string& source, std::string json, std::shared_ptr<const wire::InProcessMessage> decoded = {},
               InputStore::Decided decided = {});
  /// A command that the core is given at once, whatever the store does: a Stop.
  /// @param durable  called when the store has it for good, and at once where there is no store; may be empty
  void urgent_command(const std::string& source, std::string json,
                      std::shared_ptr<const wire::InProcessMessage> decoded, std::function<void()> durable);
  /// Called after each input the core has handled.
  void after_input(std::function<void()> action);
  /// Ends: no further input, the digest of the run, the core's farewell, the journal's end. Then `done(digest)`.
  void stop(const std::function<void(const std::string& digest)>& done);

  [[nodiscard]] bool link_up() const;
  /// Whether the core has still to be given commands that an earlier process accepted.
  [[nodiscard]] bool gives_earlier_commands() const;
  [[nodiscard]] std::uint64_t inputs() const;

 private:
  struct Impl;
  std::shared_ptr<Impl> impl_;
};

}  // namespace cosiva::adapters
