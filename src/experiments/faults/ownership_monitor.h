#pragma once

#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>

#include "cosiva/base/time.h"
#include "cosiva/experiments/faults/violation.h"
#include "cosiva/experiments/runs/world/fault_injection.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::experiments {

/// I4 with several control areas: one vehicle has one owner. A server sends orders and actions to vehicles only whose
/// last owner, as the server received it, is its own control area, nothing to a vehicle that it has handed over, and
/// nothing to one that another server commands.
///
/// Invariant: a server that is not running knows no owners.
class OwnershipMonitor {
 public:
  /// Two servers may both command a vehicle for so long, where the broker has lost the owners and one of them claims a
  /// vehicle of the other: the broker ends a connection that a partition has cut off after 7.5 s, and the new owner's
  /// message takes up to 2 s.
  static constexpr SimDuration both_max = std::chrono::seconds{10};

  explicit OwnershipMonitor(std::map<Process, std::string> areas) : areas_{std::move(areas)} {}

  /// The server receives a message.
  void on_received(Process server, const wire::Input& message);
  /// A message leaves the server.
  [[nodiscard]] Finding on_published(Process server, const wire::Publish& message);
  /// The server's connection to the broker is new: a hand-over that it published before may not have arrived.
  void on_link(Process server) { handed_over_[server].clear(); }
  void on_killed(Process server);
  /// The vehicles that each running server commands now.
  [[nodiscard]] Finding step(SimTime now, const std::map<Process, std::set<std::string>>& commanded);
  /// The longest time for which two servers commanded one vehicle.
  [[nodiscard]] SimDuration both_longest() const { return both_longest_; }
  /// How often a server has received that a vehicle has become another control area's.
  [[nodiscard]] std::uint64_t released() const { return released_; }

 private:
  std::map<Process, std::string> areas_;
  std::map<Process, std::map<std::string, std::string>> owners_;       ///< as received last; by vehicle
  std::map<Process, std::map<std::string, std::string>> handed_over_;  ///< published, and not received back yet
  std::map<std::string, SimTime> both_since_;
  SimDuration both_longest_{};
  std::uint64_t released_{};
};

}  // namespace cosiva::experiments
