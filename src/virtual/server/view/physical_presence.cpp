#include "cosiva/virtual/server/view/physical_presence.h"

#include <algorithm>

#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {

void PhysicalPresence::tick(SimTime now) const {
  for (const AivProxy& proxy : registry_) {
    if (proxy.augmented() || proxy.retired() || !proxy.twin_link.present()) continue;
    if (const auto absent = absence(proxy, now))
      monitor_.set_physical(proxy.twin_link.entity(), false, absent->reason, absent->since);
    else
      monitor_.set_physical(proxy.twin_link.entity(), true, proxy.twin() ? "" : "it reports no position");
  }
}

Result<Departure> PhysicalPresence::departure(const RetireCommand& command, SimTime now) const {
  const auto vehicle = registry_.find(command.vehicle);
  if (!vehicle || !(registry_[*vehicle].here() || registry_[*vehicle].membership.awaited()))
    return fail("vehicle.unknown",
                "no vehicle '" + command.vehicle.substr(0, 80) + "' is known; name it as manufacturer/serial number",
                "vehicle");
  const AivProxy& proxy = registry_[*vehicle];
  if (proxy.augmented())
    return fail("vehicle.virtual", proxy.name() + " exists only virtually; remove it instead", "vehicle");
  if (!proxy.twin_link.present() || absence(proxy, now)) return Departure{*vehicle};
  return fail("vehicle.present",
              proxy.name() + " reports; switch it off and take it away first, or exclude it from traffic", "vehicle");
}

std::optional<VehicleIndex> PhysicalPresence::departed(SimTime now) const {
  for (VehicleIndex v = 0; v < registry_.size(); ++v) {
    const AivProxy& proxy = registry_[v];
    if (proxy.augmented() || !proxy.here() || !proxy.twin_link.present()) continue;
    const auto absent = absence(proxy, now);
    const auto undetected_since = gvs_.undetected_since(v);
    // The marker of a vehicle that reports may be covered: only what the camera has not detected since counts.
    if (absent && undetected_since && now - std::max(absent->since, *undetected_since) >= undetected_for) return v;
  }
  return std::nullopt;
}

std::optional<Absence> PhysicalPresence::absence(const AivProxy& proxy, SimTime now) const {
  COSIVA_EXPECT(proxy.twin_link.present());
  switch (proxy.connection.shown()) {
    case wire::ConnectionState::offline: return Absence{proxy.connection.changed_at(), "it has signed off (OFFLINE)"};
    case wire::ConnectionState::connection_broken:
      return Absence{proxy.connection.changed_at(), "its connection has ended (CONNECTIONBROKEN)"};
    case wire::ConnectionState::online: break;
  }
  if (!proxy.lost(now, silence_min_)) return std::nullopt;
  return Absence{proxy.reports.last(), "it no longer reports, although it is ONLINE"};
}

}  // namespace cosiva::virtual_side
