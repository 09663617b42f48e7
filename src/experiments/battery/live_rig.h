#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/json_writer.h"
#include "cosiva/base/pose.h"
#include "cosiva/experiments/battery/virtual_rig.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/battery_exchange.h"
#include "cosiva/wire/own/own_messages.h"
#include "cosiva/wire/runtime/core.h"

namespace cosiva::experiments {

struct LiveRigOptions {
  ProcedureOptions procedure;
  std::vector<wire::VehicleId> vehicles;  ///< as many as the procedure has
  std::vector<std::string> batteries;     ///< names of the batteries, as many as vehicles
  /// Set where the vehicles are the plant's: the plant is commanded to insert emulated batteries, and a vehicle whose
  /// run has ended gets a service battery and drives on as traffic. Otherwise operators change the batteries, and a
  /// vehicle whose run has ended stops, or drives to `park`.
  std::optional<BatteryUnderTest> emulated;
  std::uint64_t seed{1};  ///< of emulated batteries
  std::string park;       ///< a station; empty: they stop where they are
};

/// A battery test on a running platform, over its bus: each received message yields the messages and commands to send.
/// changeBattery goes to the vehicle's own program, and batteryReady, rc and their dates come from it. Nothing else
/// confirms a battery.
/// The rig owns no link, clock or file, and its whole state can be saved after each call.
///
/// Invariant: each vehicle of the procedure has a slot and a battery.
class LiveRig {
 public:
  struct Responses {
    std::vector<wire::Publish> messages;
    std::vector<std::string> commands;           ///< to the server, as /api/v1/commands takes them, in this order
    std::vector<std::string> operator_messages;  ///< to the operator
  };
  explicit LiveRig(LiveRigOptions options);

  [[nodiscard]] static std::vector<std::string> subscriptions();
  [[nodiscard]] Responses start(SimTime now);
  /// Messages of others, and unreadable messages, are ignored.
  [[nodiscard]] Responses on_message(SimTime now, std::string_view topic, std::string_view payload);
  [[nodiscard]] Responses tick(SimTime now);
  /// Ends the test for its operator: running vehicles are stopped, and their batteries booked as lasting longer.
  [[nodiscard]] Responses give_up(SimTime now);

  [[nodiscard]] bool done() const { return given_up_ || procedure_.done(); }
  /// The status of the test, for display (wire::battery_test_topic).
  [[nodiscard]] wire::BatteryTest test(SimTime now) const;
  [[nodiscard]] const Procedure& procedure() const { return procedure_; }
  /// Whether every vehicle has sent a message.
  [[nodiscard]] bool complete() const;
  /// The vehicles that have not sent a message.
  [[nodiscard]] std::string missing() const;

  [[nodiscard]] std::string state_json() const;
  /// Continues from a saved state; no vehicle counts as lost for the time of the interruption. Fails ("battery.state").
  [[nodiscard]] Result<Responses> restore(SimTime now, std::string_view state_json);

 private:
  struct Slot {
    std::optional<Point2> at;  ///< last position
    double odometer_m{0.0};
    bool received{false};
    std::optional<std::string> wanted;  ///< battery requested and not yet ready
  };
  [[nodiscard]] std::optional<std::size_t> slot_of(const wire::VehicleId& id) const;
  void obey(const ProcedureCommands& commands, Responses& responses);
  void request(std::size_t vehicle, std::size_t battery, const std::string& reason, Responses& responses);
  void end(std::size_t vehicle, Responses& responses);
  void put_in(std::size_t vehicle, std::optional<std::size_t> battery, Responses& responses) const;
  [[nodiscard]] double cycles_of(std::size_t battery) const;  ///< of an emulated one, before the present run
  void clear_request(std::size_t vehicle, Responses& responses);
  void drive(std::size_t vehicle, const char* command, Responses& responses) const;
  void on_report(SimTime now, std::size_t vehicle, std::string_view payload, Responses& responses);
  void on_ready(SimTime now, std::size_t vehicle, std::string_view payload, Responses& responses);
  void on_position(std::size_t vehicle, std::string_view payload);

  LiveRigOptions options_;
  Procedure procedure_;
  std::vector<Slot> slots_;
  SimTime began_{};
  bool given_up_{false};
};

/// {"changeBattery":{…}} for the plant: a battery under test, or without one a service battery that does not run empty.
[[nodiscard]] std::string plant_battery_json(std::size_t vehicle, const std::string& id, const BatteryUnderTest* kind,
                                             std::uint64_t seed, double cycles);
/// {"command":…,"vehicle":…} for the server.
[[nodiscard]] std::string server_command_json(std::string_view command, const std::string& vehicle);

}  // namespace cosiva::experiments
