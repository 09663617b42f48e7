#pragma once

#include <optional>
#include <string_view>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/virtual/server/commands/values/operator_command.h"
#include "cosiva/virtual/server/registry/registry.h"
#include "cosiva/virtual/server/view/ground_truth_comparator.h"
#include "cosiva/virtual/simulator/bijection.h"

namespace cosiva::virtual_side {

/// Why a vehicle is not present on the physical side, and since when.
struct Absence {
  SimTime since;
  std::string_view reason;
};

/// A vehicle of which an operator states that it has left, and that has.
struct Departure {
  VehicleIndex vehicle;
};

/// Decides which vehicles are present on the physical side (A1, A25): those that report. A vehicle that has signed off,
/// whose connection has ended, or that no longer reports is absent: its twin remains on the map and an obstacle, and is
/// an orphan in the bijection monitor. No time ends that: the vehicle's next report does, or its departure, which an
/// operator states or the camera over the zone shows.
///
/// Invariant: only a vehicle that was present before can be absent.
class PhysicalPresence {
 public:
  /// @param silence_min  the shortest silence after which a vehicle is absent; three usual gaps between its reports
  ///                     where these are longer
  PhysicalPresence(const Registry& registry, BijectionMonitor& monitor, const GroundTruthComparator& gvs,
                   SimDuration silence_min)
      : registry_{registry}, monitor_{monitor}, gvs_{gvs}, silence_min_{silence_min} {}

  /// A camera that detects no vehicle at the position of an absent one for so long shows that the vehicle has left.
  static constexpr SimDuration undetected_for{std::chrono::seconds{5}};

  /// To be called once per tick.
  void tick(SimTime now) const;
  /// Nothing: the vehicle is present.
  [[nodiscard]] std::optional<Absence> absence(const AivProxy& proxy, SimTime now) const;
  /// Fails ("vehicle.unknown", "vehicle.virtual", "vehicle.present") for a vehicle that has no twin or is not absent.
  [[nodiscard]] Result<Departure> departure(const RetireCommand& command, SimTime now) const;
  /// An absent vehicle with a twin at whose position the camera detects no vehicle; nothing: there is none.
  [[nodiscard]] std::optional<VehicleIndex> departed(SimTime now) const;

 private:
  const Registry& registry_;
  BijectionMonitor& monitor_;
  const GroundTruthComparator& gvs_;
  SimDuration silence_min_;
};

}  // namespace cosiva::virtual_side
