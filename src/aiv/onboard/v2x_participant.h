#pragma once

#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cosiva/aiv/onboard/driving_context.h"
#include "cosiva/aiv/onboard/error_log.h"
#include "cosiva/aiv/v2x/fleet_proxies.h"
#include "cosiva/base/archive_fwd.h"
#include "cosiva/wire/own/v2x.h"
#include "cosiva/wire/own/v2x_port.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::aiv {

/// The vehicle's part in V2X (docs/protocols/v2x.md): which cell it publishes in and subscribes around, when it
/// publishes its intent, and which intents of others it accepts.
///
/// Invariant: two intents are at least 100 ms apart, unless the clock was set back.
class V2xParticipant {
 public:
  struct Mode {
    bool direct{false};     ///< it sends by the direct link, too
    bool as_values{false};  ///< intents are passed on as values
    bool dense{false};      ///< near others it publishes ten times a second, so that its silence is noticed at once
  };
  /// @param enabled  false: it neither publishes nor accepts intents
  V2xParticipant(wire::VehicleId id, bool enabled) : V2xParticipant{std::move(id), enabled, Mode{}} {}
  V2xParticipant(wire::VehicleId id, bool enabled, Mode mode);

  /// True when the vehicle has entered another cell, so that filters() have changed.
  [[nodiscard]] bool update_cell(const DrivingContext& context);
  /// Topics of the cells around the vehicle; none before its pose is known.
  [[nodiscard]] std::vector<std::string> filters() const;

  void on_intent(SimTime now, const wire::Input& input, DrivingContext& context, wire::Effects& effects);
  /// A message of the direct link: an intent, claims for crossings, or a crossing unit's status.
  void on_direct(SimTime now, const wire::V2xSource& source, const wire::Input& input, DrivingContext& context,
                 wire::Effects& effects);
  void publish_claims(SimTime now, DrivingContext& context, wire::Effects& effects);
  /// What the others' intents mean for the next decision.
  [[nodiscard]] Others survey(SimTime now, DrivingContext& context) const;
  /// @param online  the vehicle has a link to the broker
  void publish_intent(SimTime now, DrivingContext& context, bool online, wire::Effects& effects);
  [[nodiscard]] const FleetProxies& proxies() const { return proxies_; }
  void on_zone_switched() { errors_.clear(); }
  void archive(Archive& archive);  ///< the state, for a snapshot

 private:
  void on_direct_intent(SimTime now, const wire::VehicleId& sender, const wire::Input& input, DrivingContext& context,
                        wire::Effects& effects);
  void on_claims(SimTime now, const wire::VehicleId& sender, const wire::Input& input, DrivingContext& context,
                 wire::Effects& effects);
  void on_status(SimTime now, const wire::VehicleId& sender, const wire::Input& input, DrivingContext& context,
                 wire::Effects& effects);
  void use(SimTime now, const wire::V2xTopic& topic, std::shared_ptr<const wire::Intent> intent,
           const wire::Input& input, DrivingContext& context, wire::Effects& effects);
  void refuse(const wire::Input& input, std::string kind, const std::string& why, wire::Effects& effects);

  wire::VehicleId id_;
  std::string name_;  ///< of the vehicle, as in the zone's priorities
  bool enabled_;
  Mode mode_;
  FleetProxies proxies_;
  std::optional<wire::Cell> cell_;
  std::string cell_map_;
  wire::Intent last_intent_;
  std::optional<SimTime> published_at_;
  bool requested_{false};  ///< a vehicle that was not known before has published
  ErrorLog errors_;
};

}  // namespace cosiva::aiv
