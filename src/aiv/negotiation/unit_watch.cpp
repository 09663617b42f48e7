#include "cosiva/aiv/negotiation/unit_watch.h"

#include <algorithm>
#include <cstdint>
#include <utility>

#include "cosiva/base/expect.h"

namespace cosiva::aiv {

bool UnitWatch::counts(const Unit& unit, SimTime now) {
  return unit.last->online && now >= unit.at && now - unit.at < unresponsive_after;
}

bool UnitWatch::on_status(SimTime now, const wire::VehicleId& sender,
                          std::shared_ptr<const wire::CrossingStatus> status) {
  const bool of_unit = sender.manufacturer == wire::unit_manufacturer && sender.serial_number == status->crossing;
  if (!of_unit || status->unit != sender || status->map_id != map_id_) return false;
  const auto known = std::ranges::find_if(units_, [&](const Unit& unit) { return unit.last->unit == sender; });
  if (known == units_.end()) {
    if (units_.size() < units_max) units_.push_back({std::move(status), now});
    COSIVA_EXPECT(units_.size() <= units_max);
    return true;
  }
  // Of a unit that counts, an overtaken message is not used; a restarted unit may begin anywhere.
  const bool older = static_cast<std::int32_t>(status->header_id - known->last->header_id) <= 0;
  if (older && counts(*known, now)) return true;
  *known = {std::move(status), now};
  return true;
}

const std::vector<wire::CrossingStatus::Vehicle>& UnitWatch::holders(SimTime now, std::string_view crossing) const {
  static const std::vector<wire::CrossingStatus::Vehicle> none;
  const auto known = std::ranges::find_if(units_, [&](const Unit& unit) { return unit.last->crossing == crossing; });
  return known != units_.end() && counts(*known, now) ? known->last->holders : none;
}

}  // namespace cosiva::aiv
