#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/wire/runtime/network.h"

namespace cosiva::experiments {

/// A process of a world: 0 is the server, N is the on-board program of AIV N, the last number is the plant, from
/// first_unit on there are the crossing units, and from first_other_server on the servers of other control areas.
using Process = std::uint32_t;
inline constexpr Process server_process = 0;
inline constexpr Process first_unit = 0xfffe'0000;
inline constexpr Process first_other_server = 0xffff'0000;
inline constexpr Process plant_process = 0xffff'ffff;

[[nodiscard]] constexpr bool is_server(Process process) {
  return process == server_process || (process >= first_other_server && process != plant_process);
}
[[nodiscard]] constexpr bool is_aiv(Process process) { return process != server_process && process < first_unit; }
[[nodiscard]] constexpr bool is_unit(Process process) { return process >= first_unit && process < first_other_server; }

/// Faults of the processes, connections, broker and clocks of a world, and what its processes receive and do.
class FaultInjection {
 public:
  virtual ~FaultInjection() = default;

  [[nodiscard]] virtual bool running(Process process) const = 0;
  /// Whether the process has a connection to the broker.
  [[nodiscard]] virtual bool linked(Process process) const = 0;
  /// The process dies instead of carrying out its n-th effect from now on, 1 being the next one; 0: it does not die.
  virtual void kill_at_effect(Process process, std::uint64_t n) = 0;

  /// The connection fails: the broker publishes the last will, and the process is informed. A process without a
  /// connection discards messages of QoS 0, and sends the others once it is linked again.
  virtual void break_link(Process process) = 0;
  /// Links a running process again, where the broker is running and the process is not linked.
  virtual void restore_link(Process process) = 0;
  /// A partition between the process and the broker (wire::Network::set_blocked); a link made later has none.
  virtual void block(Process process, wire::Network::Blocked blocked) = 0;
  virtual void set_network(wire::NetworkFaults faults) = 0;
  /// The broker dies, with its queues and retained messages; processes that start get no link until it is restarted.
  virtual void stop_broker() = 0;
  virtual void start_broker() = 0;
  [[nodiscard]] virtual bool broker_running() const = 0;

  /// The clock of a process from its next start on: ahead of virtual time by `offset`, and fast by `drift_ppm`.
  virtual void set_clock(Process process, SimDuration offset, double drift_ppm) = 0;
  /// Publishes a message from an unknown sender on the same broker.
  virtual void publish_from_outside(const wire::Publish& message) = 0;
  /// Publishes a message as if this process had done so, where it is linked.
  virtual void publish_from(Process process, const wire::Publish& message) = 0;
  /// The process dies, or starts again; a process that has died has no effect. While the plant does not run, the byte
  /// streams of all boards are closed.
  virtual void kill(Process process) = 0;
  virtual void start(Process process) = 0;
  /// Closes the byte streams of an AIV's boards, or opens them again, for both ends; a start of either end opens them.
  virtual void set_boards(Process aiv, bool open) = 0;
  /// Gives an operator's command to a server as its HTTP interface does: a Stop at once, another command once the
  /// server's store has it. `decided` is called when the interface would report success (202), or with the reason why
  /// not; never where the process dies before.
  virtual void command(Process server, std::string json, std::function<void(const Result<void>&)> decided) = 0;

  /// Each may be empty.
  struct Observer {
    std::function<void(Process)> on_killed;
    /// Before the core handles the input; not of the plant.
    std::function<void(Process, const wire::Input&)> on_input;
    /// When the effect is carried out; not of the plant.
    std::function<void(Process, const wire::Effect&)> on_effect;
    /// Whether a message of this process reaches the network; empty: every one does.
    std::function<bool(Process, const wire::Publish&)> passes;
  };
  virtual void observe(Observer observer) = 0;

 protected:
  FaultInjection() = default;
  FaultInjection(const FaultInjection&) = default;
  FaultInjection& operator=(const FaultInjection&) = default;
};

}  // namespace cosiva::experiments
