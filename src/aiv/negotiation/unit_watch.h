#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "cosiva/base/time.h"
#include "cosiva/wire/messages/topics.h"
#include "cosiva/wire/own/crossing_status.h"

namespace cosiva::aiv {

/// What the crossing units report to a vehicle: which vehicles occupy or hold their crossings. A report can only keep
/// the vehicle before a crossing. A unit that has sent nothing for `unresponsive_after`, or has signed off, is ignored.
///
/// Invariant: each unit is stored once, and at most `units_max` are.
class UnitWatch {
 public:
  /// Five of a unit's periods.
  static constexpr SimDuration unresponsive_after{std::chrono::seconds{1}};
  static constexpr std::size_t units_max = 256;

  explicit UnitWatch(std::string map_id) : map_id_{std::move(map_id)} {}

  /// @param sender  by whom the message was sent, as the link has verified
  /// @return        false: the message is not used, because it is not a unit's, not of this map, or of another sender
  bool on_status(SimTime now, const wire::VehicleId& sender, std::shared_ptr<const wire::CrossingStatus> status);
  /// The vehicles that keep the crossing occupied by the report of its unit; empty without a report that counts.
  [[nodiscard]] const std::vector<wire::CrossingStatus::Vehicle>& holders(SimTime now, std::string_view crossing) const;
  [[nodiscard]] std::size_t units() const { return units_.size(); }

 private:
  struct Unit {
    std::shared_ptr<const wire::CrossingStatus> last;  ///< never null
    SimTime at{};
  };
  [[nodiscard]] static bool counts(const Unit& unit, SimTime now);

  std::string map_id_;
  std::vector<Unit> units_;
};

}  // namespace cosiva::aiv
