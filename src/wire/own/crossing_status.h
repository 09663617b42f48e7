#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/pose.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"

namespace cosiva::wire {

/// Crossing unit → all, by broker and direct link: which vehicles occupy, hold or await its crossing, as far as the
/// unit has received it from them. The message grants no right: a vehicle may only wait for it. docs/protocols/v2x.md.
struct CrossingStatus {
  std::uint32_t header_id{};  ///< counts this unit's messages, also over its restarts; wraps
  SimTime timestamp{};        ///< the unit's clock; a receiver does not rely on it
  std::string map_id;
  VehicleId unit;
  std::string crossing;
  Point2 centre;      ///< of the crossing
  bool online{true};  ///< false: the unit signs off, and this is its last message
  struct Vehicle {
    VehicleId vehicle;
    std::uint32_t age_ms{};  ///< of the newest message from the vehicle, when this status was sent
    friend bool operator==(const Vehicle&, const Vehicle&) = default;
  };
  std::vector<Vehicle> holders;  ///< inside the crossing, or with a granted claim; in the order of the names
  std::vector<Vehicle> waiting;  ///< in the order in which they will presumably enter
  static constexpr std::size_t vehicles_max = 32;  ///< in one list
  friend bool operator==(const CrossingStatus&, const CrossingStatus&) = default;
};

[[nodiscard]] std::string to_json(const CrossingStatus& status);
/// Fails as intent_from_json().
[[nodiscard]] Result<CrossingStatus> crossing_status_from_json(std::string_view json);

/// To an emulated crossing unit (plant_unit_topic).
struct UnitSwitch {
  std::string crossing;
  bool on{};
  friend bool operator==(const UnitSwitch&, const UnitSwitch&) = default;
};
[[nodiscard]] std::string to_json(const UnitSwitch& command);
/// Fails as intent_from_json().
[[nodiscard]] Result<UnitSwitch> unit_switch_from_json(std::string_view json);

}  // namespace cosiva::wire
