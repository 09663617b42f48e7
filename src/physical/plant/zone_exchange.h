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

/// The zone's configuration between the plant and the broker. The plant publishes its own, retained, and adopts later
/// edits, or another zone while the plant runs. Invariant: a plant that publishes no zone never owes one.
class ZoneExchange {
 public:
  /// A plant whose link was established waits so long before it publishes its own zone: retained messages arrive in a
  /// few milliseconds, and the operator's edits in them outlive the plant. A retained zone with other sections is not
  /// adopted: the plant decides what is painted on the floor.
  static constexpr SimDuration listens_for = std::chrono::milliseconds{300};

  /// A zone to adopt.
  struct News {
    std::shared_ptr<const zone::TrafficZone> zone;
    bool same_geometry;  ///< only its tags, beacons, stations or priorities differ
  };

  /// @param own  the configuration to publish
  /// @param zone     the same, read
  /// @param publish  whether to publish the configuration at all
  ZoneExchange(zone::ZoneConfiguration own, std::shared_ptr<const zone::TrafficZone> zone, bool publish);

  void on_link(bool up, SimTime at);
  /// A message of a zone topic. Returns the zone where it is to be adopted; a zone that cannot be adopted is logged.
  [[nodiscard]] std::optional<News> on_message(std::string_view topic, std::string_view payload, SimTime at,
                                               wire::Effects& effects);
  /// The physical side's new zone, entered by hand: published retained, and the retained zone of another format is
  /// cleared. Fails where the zone cannot be read; then nothing changes.
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
  bool due_{false};                  ///< publishes after the waiting time
  std::vector<std::string> others_;  ///< formats in which the broker retains other zones
};

}  // namespace cosiva::physical
