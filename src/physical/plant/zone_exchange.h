#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "base/time.h"
#include "wire/core.h"
#include "zone/rtm/rtm.h"

namespace cosiva::physical {

/// The zone's configuration between the plant and the broker. The plant hands its own over, retained, and takes back
/// what an operator edited of it meanwhile: other tags, beacons or priorities on the same ways.
class ZoneExchange {
 public:
  /// So long a plant whose link came up listens before it hands over its own zone: what the broker keeps arrives in a
  /// few milliseconds, and the operator's edits in it outlive the plant.
  static constexpr SimDuration listens_for = std::chrono::milliseconds{300};

  /// @param own      the configuration to hand over
  /// @param zone     the same, read
  /// @param publish  whether to hand it over at all
  ZoneExchange(zone::ZoneConfiguration own, zone::TrafficZone zone, bool publish);

  void on_link(bool up, SimTime at);
  /// A message of a zone topic. Gives the zone when its tags or beacons are to be taken over; what it cannot take it
  /// logs.
  [[nodiscard]] const zone::TrafficZone* on_message(std::string_view topic, std::string_view text,
                                                    wire::Effects& effects);
  void tick(SimTime at, wire::Effects& effects);

  [[nodiscard]] const zone::ZoneConfiguration& configuration() const { return own_; }

 private:
  zone::ZoneConfiguration own_;
  zone::TrafficZone zone_;
  bool publish_;
  std::optional<SimTime> due_;
};

}  // namespace cosiva::physical
