#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "cosiva/base/time.h"
#include "cosiva/experiments/runs/world/fault_injection.h"

namespace cosiva::experiments {

/// What a fault does. The classes F1 to F13 are those of the requirements for reliability.
enum class FaultKind : std::uint8_t {
  weather,       ///< F1: loss, duplication, reordering and delay in the whole network
  partition,     ///< F2: one process is cut off, in one direction or both
  crash,         ///< F3: a process, or the plant, dies, at once or at its n-th effect
  broker,        ///< F4: the broker dies with its queues, and is restarted
  power_cut,     ///< F5: the server's machine loses its power: unsynced writes are dropped, torn or reordered
  disk_refusal,  ///< F5: the server's disk refuses every n-th call
  bit_flip,      ///< F6: a bit of the store is inverted while the server is down, and must be detected
  clock,         ///< F7: a process restarts with another clock
  flood,         ///< F10: one AIV publishes at 100 times its rate
  person,        ///< a person steps into a vehicle's path, where the vehicle can still stop, and leaves it again
  command,       ///< F13: an operator gives a command
};
inline constexpr std::size_t fault_kinds = 11;

/// "F1 weather".
[[nodiscard]] std::string_view to_string(FaultKind kind);

/// "CoSiVA/AIV2".
[[nodiscard]] std::string vehicle_id(Process aiv);

/// One fault of a schedule.
struct Fault {
  std::uint32_t number{};  ///< in its schedule, from 1
  FaultKind kind{};
  SimDuration at{};     ///< since the start of the simulation
  SimDuration lasts{};  ///< until the end of the weather or partition, or the restart
  Process process{server_process};
  std::uint64_t n{};  ///< of `crash`: the effect, of `power_cut`: the disk's call, 0: at once; of `disk_refusal`: every
                      ///< n-th call; a draw for others
  std::uint8_t shape{};  ///< of `partition`: 0 both directions, 1 to the broker, 2 from the broker
  double loss{};
  double duplication{};
  double reordering{};
  SimDuration delay_max{};
  SimDuration clock_offset{};
  double clock_drift_ppm{};
  std::string text{};  ///< the command's JSON, or the code of the disk's error

  [[nodiscard]] SimDuration ends() const { return at + lasts; }
};

/// "#12 F3 crash at 14.2 s: server at its effect 31, back after 2.1 s".
[[nodiscard]] std::string to_string(const Fault& fault);

/// Number of faults of each kind.
using FaultCounts = std::array<std::uint64_t, fault_kinds>;

}  // namespace cosiva::experiments
