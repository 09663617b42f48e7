#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <utility>
#include <vector>

#include "cosiva/base/random.h"
#include "cosiva/experiments/faults/fault.h"
#include "cosiva/experiments/faults/persons.h"
#include "cosiva/experiments/faults/planted.h"
#include "cosiva/experiments/faults/simulated_store.h"
#include "cosiva/experiments/runs/world/world.h"

namespace cosiva::experiments {

/// Injects the faults of a schedule into a world, and does what the platform's supervisor and clients do then: restarts
/// processes, and connects them again after 50 ms to 2 s.
///
/// Invariant: the faults that were injected are those before a point of the schedule.
class FaultInjector {
 public:
  struct Handlers {
    std::function<void(const std::string& json)> on_command;  ///< an operator gives a command
    std::function<void(Process server)> before_server_start;  ///< its store is open
  };
  /// The store of each server.
  using Stores = std::map<Process, SimulatedStore*>;
  FaultInjector(World& world, const Stores& stores, Persons& persons, std::vector<Fault> faults, std::uint32_t aivs,
                std::uint64_t seed, Planted planted, Handlers handlers);

  /// Runs the world to the next fault, by 20 ms at most, and begins and ends everything that is due then.
  void run_step();
  /// Ends all faults: no more are injected, processes restart and connect at once.
  /// @return  the longest delay of a message that is in transit
  SimDuration end_faults();
  /// A process has died.
  void on_killed(Process process);
  /// An AIV publishes a message, which a flood repeats.
  void on_published(Process aiv, const wire::Publish& message);
  /// Whether a message of the server reaches the network: every one does, unless a defect is planted.
  [[nodiscard]] bool passes(const wire::Publish& message);

  /// All processes are running and linked.
  [[nodiscard]] bool whole() const;
  [[nodiscard]] std::uint64_t server_starts() const { return server_starts_; }

 private:
  /// Begins and ends everything that is due.
  void step();
  /// When the next fault begins; nothing: none is left.
  [[nodiscard]] std::optional<SimTime> next_fault() const;
  void begin(const Fault& fault);
  void crash(const Fault& fault);
  void cut_power(const Fault& fault);
  void restart_later(const Fault& fault);
  void apply_active();
  void apply_weather();
  void apply_partition(Process process);
  void apply_refusals();
  void flood();
  void lift_pauses();
  void restart_due();
  void link_due();
  void kill(Process process);
  void start(Process process);
  void start_server(Process process);

  World& world_;
  Persons& persons_;
  const std::vector<Fault> faults_;
  Planted planted_;
  Handlers handlers_;
  Random random_;
  SimTime epoch_;
  std::size_t next_{0};
  std::vector<const Fault*> active_;  ///< with an end that has not passed
  struct ProcessFaults {
    SimDuration down_for{std::chrono::seconds{1}};
    std::optional<SimTime> restart_at{};
    std::optional<SimTime> link_at{};
    std::optional<SimTime> blocked_since{};
    bool power_cut{false};
    std::optional<std::uint64_t> bit_flip{};
    SimulatedStore* store{};  ///< null: the process is no server
    std::optional<wire::Publish> last{};
  };
  std::map<Process, ProcessFaults> processes_;
  std::uint64_t server_starts_{0};
  std::vector<std::pair<SimTime, wire::Publish>> lifts_;  ///< of Planted::lifted_pause
};

}  // namespace cosiva::experiments
