#pragma once

#include <memory>
#include <utility>

#include "cosiva/physical/plant/tag_reader.h"
#include "cosiva/zone/layout/circuit_factory.h"
#include "cosiva/zone/layout/traffic_zone.h"

namespace cosiva::physical {

/// What is painted and laid on the floor: a zone's sections, tags and beacons. After a switch of zones each vehicle
/// remains on the old floor until it is stopped, so that two floors exist for a moment.
struct Floor {
  /// @param from     the configuration that `on` was read from
  /// @param reach_m  radius of the antennas' field
  Floor(zone::ZoneConfiguration from, std::shared_ptr<const zone::TrafficZone> on, double reach_m)
      : configuration{std::move(from)},
        zone{std::move(on)},
        tags{*zone, reach_m},
        loop_length_m{length_of_loop_m(zone->circuit)} {}

  /// Length of the loop that all sections form together, or 0 where they do not form one.
  [[nodiscard]] static double length_of_loop_m(const zone::Circuit& circuit);

  zone::ZoneConfiguration configuration;
  std::shared_ptr<const zone::TrafficZone> zone;  ///< its sections hold; its tags may have been edited since
  TagMap tags;                                    ///< as they are now
  double loop_length_m;
};

}  // namespace cosiva::physical
