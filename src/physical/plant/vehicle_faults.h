#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "cosiva/base/archive_fwd.h"
#include "cosiva/base/json_value.h"
#include "cosiva/base/result.h"
#include "cosiva/base/time.h"
#include "cosiva/physical/boards/line_tracker.h"
#include "cosiva/physical/plant/pmot.h"

namespace cosiva::physical {

/// A fault of a vehicle's modules that a scenario injects (A18).
struct VehicleFault {
  enum class Kind : std::uint8_t { stuck_sensor, dead_motor, failed_reader, brown_out };
  Kind kind{Kind::stuck_sensor};
  std::optional<SimDuration> duration;  ///< nothing: until it is ended
  std::size_t sensor{7};                ///< of a row of DEMS, from right to left
  std::uint8_t reading{255};            ///< of the stuck sensor
  DeadMotor motor{DeadMotor::left};
};
[[nodiscard]] std::string_view to_string(VehicleFault::Kind kind);

/// {"fault":"stuck_sensor","for_s":5,"sensor":7,"reading":255}, "dead_motor" with "motor":"left"|"right",
/// "failed_reader", or "brown_out", which needs for_s of at most 10. Nothing: "none", which ends all faults.
[[nodiscard]] Result<std::optional<VehicleFault>> vehicle_fault_from_json(const JsonValue& json);

/// The faults in force, and their ends. Invariant: one of each kind.
class VehicleFaults {
 public:
  void begin(SimTime now, const VehicleFault& fault);
  /// Ends one of the faults whose time has come; nothing: none has ended.
  [[nodiscard]] std::optional<VehicleFault::Kind> take_ended(SimTime now);
  /// All of them end at the next take_ended().
  void end_all();
  [[nodiscard]] bool any() const { return count_ > 0; }
  [[nodiscard]] bool has(VehicleFault::Kind kind) const { return end_of(kind).has_value(); }
  void archive(Archive& archive);  ///< the state, for a restart of the emulation

 private:
  static constexpr std::size_t kinds = 4;
  [[nodiscard]] const std::optional<SimTime>& end_of(VehicleFault::Kind kind) const {
    return ends_[static_cast<std::size_t>(kind)];
  }

  std::array<std::optional<SimTime>, kinds> ends_;
  std::uint32_t count_{0};
};

}  // namespace cosiva::physical
