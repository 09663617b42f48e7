#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "cosiva/virtual/server/context/augmented_parts.h"
#include "cosiva/virtual/server/context/instrument_parts.h"
#include "cosiva/virtual/server/context/master_control.h"
#include "cosiva/virtual/server/context/server_context.h"
#include "cosiva/virtual/server/reports/own_reports.h"
#include "cosiva/virtual/server/reports/report_checks.h"
#include "cosiva/virtual/server/reports/twin_placement.h"
#include "cosiva/virtual/server/reports/vehicle_lifecycle.h"

namespace cosiva::virtual_side {

/// The intake of the messages that vehicles publish over VDA 5050: connection, factsheet, state and visualization, and
/// their effects on the registry, the twins, the orders and the commands.
/// Invariant: a retired vehicle changes nothing but its connection, and the time of a vehicle's last report never
/// decreases.
class VehicleReports {
 public:
  VehicleReports(ServerContext& context, MasterControl& master, AugmentedParts& augmented, InstrumentParts& instruments,
                 VehicleLifecycle& vehicles, TwinPlacement& twins)
      : context_{context},
        master_{master},
        augmented_{augmented},
        instruments_{instruments},
        vehicles_{vehicles},
        twins_{twins},
        checks_{context},
        own_{context, augmented, instruments, checks_} {}

  /// False: the topic belongs to no vehicle, or to a vehicle that the server does not accept.
  bool receive(const wire::Input& input);
  void receive(Registry::Address address, const wire::Input& input);
  /// Counts a report: once per message, whatever the message carries.
  void on_report(VehicleIndex vehicle, SimTime reported_at);

 private:
  /// The proxy of the vehicle delivers its message to the server.
  void deliver(AivProxy& proxy, std::string_view kind, std::string_view summary, const wire::Input& input);
  /// Registers the vehicle where the topic is its first one.
  [[nodiscard]] std::optional<Registry::Address> address_of(const std::string& topic);
  /// Drops a message that exceeds the vehicle's rate.
  [[nodiscard]] bool floods(AivProxy& proxy);
  void on_retired(AivProxy& proxy, VehicleTopic topic, const wire::Input& input);
  void on_connection(VehicleIndex vehicle, const wire::Input& input);
  void on_factsheet(VehicleIndex vehicle, const wire::Input& input);
  void on_state(VehicleIndex vehicle, const wire::Input& input);
  void on_visualization(VehicleIndex vehicle, const wire::Input& input);
  /// When a position was measured, on the vehicle's own clock; nothing where the same or a newer position is known.
  [[nodiscard]] std::optional<SimTime> fresh_position_stamp(AivProxy& proxy, const wire::Header& header) const;
  void on_position(VehicleIndex vehicle, SimTime stamp, const wire::AgvPosition& position,
                   const std::optional<wire::Velocity>& velocity);
  /// Of a state that is not the vehicle's first one (checked).
  void record_events(VehicleIndex vehicle, const ReportedState::Change& change, SimTime reported_at);

  ServerContext& context_;
  MasterControl& master_;
  AugmentedParts& augmented_;
  InstrumentParts& instruments_;
  VehicleLifecycle& vehicles_;
  TwinPlacement& twins_;
  ReportChecks checks_;
  OwnReports own_;
};

}  // namespace cosiva::virtual_side
