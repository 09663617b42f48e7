#pragma once

#include <memory>
#include <optional>

#include "cosiva/aiv/decision/agent.h"
#include "cosiva/aiv/negotiation/crossing_negotiation.h"
#include "cosiva/aiv/onboard/onboard_core.h"
#include "cosiva/aiv/perception/perceived_world.h"
#include "cosiva/aiv/perception/sighting.h"
#include "cosiva/aiv/v2x/base_watch.h"
#include "cosiva/aiv/v2x/neighbours.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::aiv {

/// The zone in force and everything that refers to this zone. The parts are built together, and a zone switch replaces
/// all of them as one.
///
/// Invariant: all parts refer to zone(), whose circuit, speed profiles and vehicle shape never change.
class DrivingContext {
 public:
  /// @param zone     copied: fiducials of the copy may be edited
  /// @param options  of the vehicle: speed rules (which can be used), cycle and identity
  DrivingContext(const zone::TrafficZone& zone, const OnboardOptions& options);
  /// After a zone switch: the agent takes over from the agent `before`, which has stopped.
  DrivingContext(const zone::TrafficZone& zone, const OnboardOptions& options, const Agent& before);
  DrivingContext(const DrivingContext&) = delete;
  DrivingContext& operator=(const DrivingContext&) = delete;
  ~DrivingContext() = default;

  [[nodiscard]] const zone::TrafficZone& zone() const { return *zone_; }
  /// For users that outlive the context.
  [[nodiscard]] std::shared_ptr<const zone::TrafficZone> shared_zone() const { return zone_; }
  [[nodiscard]] Agent& agent() { return agent_; }
  [[nodiscard]] const Agent& agent() const { return agent_; }
  [[nodiscard]] VehicleState& vehicle() { return agent_.vehicle(); }
  [[nodiscard]] const VehicleState& vehicle() const { return agent_.vehicle(); }
  [[nodiscard]] PerceivedWorld& virtual_bodies() { return virtual_bodies_; }
  [[nodiscard]] const PerceivedWorld& virtual_bodies() const { return virtual_bodies_; }
  [[nodiscard]] Neighbours& neighbours() { return neighbours_; }
  [[nodiscard]] const Neighbours& neighbours() const { return neighbours_; }
  /// Of a vehicle that may finish its base after the loss of a link; null: it may not.
  [[nodiscard]] BaseWatch* base_watch() { return base_watch_ ? &*base_watch_ : nullptr; }
  /// Of a vehicle that agrees on crossings with the others; null: the server decides.
  [[nodiscard]] CrossingNegotiation* negotiation() { return negotiation_ ? &*negotiation_ : nullptr; }
  [[nodiscard]] const CrossingFinder& crossings() const { return crossings_; }
  [[nodiscard]] Sighting& sighting() { return sighting_; }
  [[nodiscard]] const Sighting& sighting() const { return sighting_; }

  /// Takes tags, beacons, stations and priorities over from an edited configuration of the same circuit
  /// (zone::same_geometry). They are in force at once, also while the vehicle drives.
  void adopt_fiducials(const zone::TrafficZone& edited);
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  std::shared_ptr<zone::TrafficZone> zone_;
  Agent agent_;
  PerceivedWorld virtual_bodies_;
  Neighbours neighbours_;
  std::optional<BaseWatch> base_watch_;
  std::optional<CrossingNegotiation> negotiation_;
  CrossingFinder crossings_;
  Sighting sighting_;
};

}  // namespace cosiva::aiv
