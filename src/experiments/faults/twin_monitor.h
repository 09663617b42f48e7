#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "cosiva/base/json_value.h"
#include "cosiva/base/time.h"
#include "cosiva/experiments/faults/planted.h"
#include "cosiva/experiments/faults/violation.h"
#include "cosiva/experiments/runs/world/world.h"

namespace cosiva::experiments {

/// I4, I7 and I9 in what the server shows: each vehicle has one twin, no twin is shown as younger than the last report
/// that the server received, and what the server and the network store is bounded.
///
/// Invariant: the time of a vehicle's last report never goes back.
class TwinMonitor {
 public:
  static constexpr std::size_t in_transit_max = 100'000;
  static constexpr std::size_t shown_commands_max = 200;

  TwinMonitor(const World& world, std::uint32_t aivs, Planted planted)
      : world_{world}, aivs_{aivs}, planted_{planted} {}

  /// The server receives a message.
  void on_received(SimTime now, const std::string& topic);
  /// The server starts: its twins are new.
  void on_server_start() { received_.clear(); }
  /// Checks the present snapshot.
  [[nodiscard]] Finding check() const;
  /// What the server counts of each vehicle (ServerCore::summary_json), for MessageLedger.
  [[nodiscard]] JsonValue summary() const;
  /// The zone is switched: a vehicle whose program dies while it brakes for that, and starts again in the other zone,
  /// cannot know where it came to a stop.
  void on_zone_switched() { switched_ = true; }
  /// Whether all vehicles are shown, with a report not older than `age_max`; otherwise the reason.
  [[nodiscard]] std::string not_fresh(SimDuration age_max) const;
  /// Vehicles ("CoSiVA/AIV1") that only a person can help: those too far from every path, where a zone switch may leave
  /// them, and those that were dead when the zone was switched, and do not know where they are.
  [[nodiscard]] std::set<std::string> off_circuit() const;
  /// What the server shows of each vehicle that does not drive, for the report of a violation.
  [[nodiscard]] std::string situation() const;

 private:
  [[nodiscard]] JsonValue snapshot() const;
  [[nodiscard]] Finding check_vehicle(const JsonValue& aiv) const;
  [[nodiscard]] double shown_age_ms(const JsonValue& aiv) const;

  const World& world_;
  std::uint32_t aivs_;
  Planted planted_;
  bool switched_{false};
  std::map<std::string, SimTime> received_;  ///< the last report of each vehicle, "CoSiVA/AIV1"
};

}  // namespace cosiva::experiments
