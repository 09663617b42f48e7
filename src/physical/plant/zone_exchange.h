#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/runtime/core.h"
#include "cosiva/zone/rtm/rtm.h"

namespace cosiva::physical {

/// The zone's configuration between the plant and the broker. The plant hands its own over, retained, and takes back
/// what comes of it: other tags, beacons or priorities on the same ways, or, while it runs, another zone altogether.
class ZoneExchange {
 public:
  /// So long a plant whose link came up listens before it hands over its own zone: what the broker keeps arrives in a
  /// few milliseconds, and the operator's edits in it outlive the plant. A zone with other ways does not: what is
  /// painted on the floor is the plant's to say.
  static constexpr SimDuration listens_for = std::chrono::milliseconds{300};

  /// A zone to take over.
  struct News {
    std::shared_ptr<const zone::TrafficZone> zone;
    bool same_geometry;  ///< only its tags, beacons, stations or priorities differ
  };

  /// @param own      the configuration to hand over
  /// @param zone     the same, read
  /// @param publish  whether to hand it over at all
  ZoneExchange(zone::ZoneConfiguration own, std::shared_ptr<const zone::TrafficZone> zone, bool publish);

  void on_link(bool up, SimTime at);
  /// A message of a zone topic. Gives the zone where it is to be taken over; what it cannot take it logs.
  [[nodiscard]] std::optional<News> on_message(std::string_view topic, std::string_view payload, SimTime at,
                                               wire::Effects& effects);
  /// The physical side's new zone by its own hand: published retained, and what the broker kept in another format
  /// cleared. Fails where it cannot be read; then nothing changes.
  [[nodiscard]] Result<News> switch_to(zone::ZoneConfiguration given, wire::Effects& effects);
  void tick(SimTime at, wire::Effects& effects);

  [[nodiscard]] const zone::ZoneConfiguration& configuration() const { return own_; }

 private:
  [[nodiscard]] News take(zone::ZoneConfiguration given, const zone::Rtm& rtm, wire::Effects& effects);
  void publish(wire::Effects& effects);

  zone::ZoneConfiguration own_;
  std::shared_ptr<const zone::TrafficZone> zone_;
  bool publish_;
  std::optional<SimTime> listens_until_;
  bool due_{false};                  ///< hands over when it has listened
  std::vector<std::string> others_;  ///< formats in which the broker keeps zones that are not ours
};

}  // namespace cosiva::physical
