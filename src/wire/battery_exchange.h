#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "base/result.h"
#include "wire/topics.h"

/// What a battery test says over the bus (A37): changeBattery → batteryReady → run → {rc, sendMsg} … floor. Run and
/// stop are the server's commands, rc is in the vehicle's own reports (boards_topic_prefix); what is left is said here.
namespace cosiva::wire {

/// Test → vehicle and whoever stands beside it, retained until it is done: BatteryChange.
inline constexpr std::string_view battery_change_topic_prefix = "cosiva/v1/battery/change/";
/// Vehicle, or who changed its battery, → test: BatteryReady.
inline constexpr std::string_view battery_ready_topic_prefix = "cosiva/v1/battery/ready/";

/// changeBattery: this battery is wanted in the vehicle.
struct BatteryChange {
  std::string battery;   ///< as people call it
  std::uint32_t run{1};  ///< of the test, from 1 on
  std::string reason;    ///< why the one that is there may not run; empty: it is time
  friend bool operator==(const BatteryChange&, const BatteryChange&) = default;
};

/// batteryReady: what has been put in.
struct BatteryReady {
  std::string battery;      ///< its own id
  std::string type;         ///< "leaf33"
  double cycles{};          ///< full ones that it has gone through
  double rest_s{};          ///< since it was charged
  double temperature_c{};   ///< of the pack
  double charge_percent{};  ///< as the gauge believes, 0…100
  friend bool operator==(const BatteryReady&, const BatteryReady&) = default;
};

[[nodiscard]] std::string to_json(const BatteryChange& change);
[[nodiscard]] std::string to_json(const BatteryReady& ready);
/// Fail ("own.field", "json.…") as the readers of own_messages.h do.
[[nodiscard]] Result<BatteryChange> battery_change_from_json(std::string_view json);
[[nodiscard]] Result<BatteryReady> battery_ready_from_json(std::string_view json);

}  // namespace cosiva::wire
