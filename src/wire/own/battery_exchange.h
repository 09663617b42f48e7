#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"

/// The messages of a battery test (A37): changeBattery → batteryReady → run → {rc, sendMsg} … floor. Run and stop are
/// the server's commands, rc is in the vehicle's own reports (boards_topic_prefix); the other messages are defined
/// here.
namespace cosiva::wire {

/// Test → vehicle and the person next to it, retained until the change is done: BatteryChange.
inline constexpr std::string_view battery_change_topic_prefix = "cosiva/v1/battery/change/";
/// The vehicle's own program → test: BatteryReady.
inline constexpr std::string_view battery_ready_topic_prefix = "cosiva/v1/battery/ready/";
/// Operator → vehicle: BatteryReady, as stated by the person that has fitted the battery.
inline constexpr std::string_view battery_fitted_topic_prefix = "cosiva/v1/battery/fitted/";
/// Test → any client that displays it, retained, at each change and once a second: BatteryTest. The last one, with
/// `done`, is retained until another test begins.
inline constexpr std::string_view battery_test_topic = "cosiva/v1/battery/test";

/// changeBattery: the vehicle is to be fitted with this battery.
struct BatteryChange {
  std::string battery;   ///< its name for display
  std::uint32_t run{1};  ///< of the test, from 1 on
  std::string reason;    ///< why the present battery may not run; empty: its run is over
  friend bool operator==(const BatteryChange&, const BatteryChange&) = default;
};

/// The request as the vehicle reads it, from the same message.
struct BatteryRequest {
  BatteryChange change;
  bool by_hand{false};  ///< a person fits the battery and confirms it: a full battery on board is not yet the right one
  friend bool operator==(const BatteryRequest&, const BatteryRequest&) = default;
};

/// batteryReady: the battery that was fitted.
struct BatteryReady {
  std::string battery;      ///< its own id
  std::string type;         ///< "leaf33"
  double cycles{};          ///< full ones that the battery has gone through
  double rest_s{};          ///< since the battery was charged
  double temperature_c{};   ///< of the pack
  double charge_percent{};  ///< the gauge's estimate, 0…100
  friend bool operator==(const BatteryReady&, const BatteryReady&) = default;
};

/// The phase of a test's vehicle in the exchange.
enum class BatteryPhase : std::uint8_t { changing, ready, running, paused, ended };
[[nodiscard]] std::string_view to_string(BatteryPhase phase);

/// The present state of a test.
struct BatteryTest {
  SimTime timestamp{};
  SimTime began{};
  std::uint32_t run{1};  ///< from 1 on, of `runs`
  std::uint32_t runs{1};
  double floor_percent{};               ///< where a run ends
  double ratio{};                       ///< of the discharge from full to the floor, 0…1, over this run's vehicles
  std::optional<SimTime> expected_end;  ///< of this run, at its present rate; nothing: too early to estimate
  bool done{false};
  struct Slot {
    std::string vehicle;  ///< "CoSiVA/AIV1"
    std::string battery;  ///< that is fitted or requested
    BatteryPhase phase{};
    std::string stop;     ///< what ended the run: floor, cut-off, fault, operator, lost; empty: nothing yet
    double autonomy_s{};  ///< so far, without pauses
    std::optional<double> charge_percent;
    friend bool operator==(const Slot&, const Slot&) = default;
  };
  std::vector<Slot> vehicles;
  static constexpr std::size_t vehicles_max = 256;
  friend bool operator==(const BatteryTest&, const BatteryTest&) = default;
};

[[nodiscard]] std::string to_json(const BatteryTest& test);
[[nodiscard]] std::string to_json(const BatteryChange& change);
[[nodiscard]] std::string to_json(const BatteryRequest& request);
[[nodiscard]] std::string to_json(const BatteryReady& ready);
/// Fail ("own.field", "json.…") as the readers of own_messages.h do.
[[nodiscard]] Result<BatteryChange> battery_change_from_json(std::string_view json);
[[nodiscard]] Result<BatteryRequest> battery_request_from_json(std::string_view json);
[[nodiscard]] Result<BatteryReady> battery_ready_from_json(std::string_view json);
[[nodiscard]] Result<BatteryTest> battery_test_from_json(std::string_view json);

}  // namespace cosiva::wire
