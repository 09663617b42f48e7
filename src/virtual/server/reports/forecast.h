#pragma once

#include <memory>
#include <optional>

#include "cosiva/aiv/decision/envelope.h"
#include "cosiva/aiv/motion/speed.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"

namespace cosiva::virtual_side {

/// What a vehicle will decide next (A10, A27): the rules of its agent, applied to the situation as the server knows it.
/// The forecast of a vehicle whose rules are not known is nothing, as is that of a vehicle off its path.
///
/// Invariant: rules and crossings are those of the zone in force, or of one that differs only in what an edit changes
/// without a new map; there are none without a zone.
class Forecast {
 public:
  Forecast(const ServerContext& context, const MasterControl& master) : context_{context}, master_{master} {}

  /// The waypoint graph of the zone in force; null while there is none.
  void set_map(const WaypointGraph* map);
  /// @param twin  of the vehicle, at its last report
  [[nodiscard]] std::optional<Expectation> expectation_of(VehicleIndex vehicle, const Twin& twin) const;

 private:
  [[nodiscard]] aiv::Situation situation_of(VehicleIndex vehicle, const Twin& twin, const Expectation& near) const;

  const ServerContext& context_;
  const MasterControl& master_;
  const WaypointGraph* map_{};
  /// The zone of the rules and of the crossings: an edit replaces the map's zone by one of the same geometry.
  std::shared_ptr<const zone::TrafficZone> zone_;
  std::unique_ptr<aiv::SpeedPolicy> rules_;
  std::optional<aiv::CrossingLookAhead> crossings_;
};

}  // namespace cosiva::virtual_side
