#include "cosiva/virtual/server/reports/vehicle_lifecycle.h"

#include <utility>

#include "cosiva/base/archive.h"
#include "cosiva/base/expect.h"

namespace cosiva::virtual_side {
namespace {

constexpr SimDuration expiry_period{std::chrono::seconds{1}};

}  // namespace

std::optional<VehicleIndex> VehicleLifecycle::register_vehicle(const wire::VehicleId& id) {
  Registry& registry = context_.registry;
  if (registry.full())
    if (const auto unused = registry.removable()) remove(*unused);
  const auto index = registry.add(id, context_.now);
  if (!index) return std::nullopt;
  COSIVA_EXPECT(*index < registry.size());
  master_.traffic.resize(registry.size());
  master_.orders.resize(registry.size());
  master_.missions.resize(registry.size());
  master_.maps.resize(registry.size());
  master_.persisted_missions.registered(*index);
  augmented_.virtual_obstacles.resize(registry.size());
  augmented_.pauses.resize(registry.size());
  AivProxy& proxy = registry[*index];
  apply_priority(*index);
  // A virtual AIV that this process did not add is left over from an earlier process: retired. The monitor counts the
  // other vehicles.
  if (proxy.augmented())
    proxy.membership.on_retired();
  else
    proxy.twin_link.on_monitored(entity_for(proxy.name()));
  if (std::erase(restored_pauses_, proxy.name()) > 0) {
    proxy.settings.on_body_in_path();
    augmented_.virtual_obstacles.wake();
  }
  apply_stop(proxy);
  context_.publisher.log('i',
                         proxy.name() + ": registered with display number " + std::to_string(proxy.identity.number()));
  return index;
}

void VehicleLifecycle::register_awaited(const wire::VehicleId& id) {
  auto vehicle = context_.registry.find(wire::to_string(id));
  if (!vehicle) vehicle = register_vehicle(id);
  if (vehicle) context_.registry[*vehicle].membership.on_awaited();
}

BijectionMonitor::Entity VehicleLifecycle::entity_for(const std::string& name) {
  std::optional<BijectionMonitor::Entity> spare;
  if (!spare_entities_.empty()) {
    spare = spare_entities_.back();
    spare_entities_.pop_back();
  }
  return context_.simulator.monitor().entity(name, spare);
}

std::optional<VehicleIndex> VehicleLifecycle::begin_life(const wire::VehicleId& id) {
  auto vehicle = context_.registry.find(wire::to_string(id));
  const bool is_known = vehicle && !context_.registry[*vehicle].membership.awaited();
  if (is_known)
    context_.registry[*vehicle].on_returned(context_.now);
  else if (!vehicle)
    vehicle = register_vehicle(id);
  if (!vehicle) return std::nullopt;
  AivProxy& proxy = context_.registry[*vehicle];
  proxy.membership.on_accepted();
  apply_stop(proxy);
  // A virtual AIV starts without the mission of the state file even at its first registration, unlike a physical
  // vehicle: recorded runs depend on that.
  if (is_known || proxy.augmented()) renew_mission(*vehicle);
  apply_priority(*vehicle);
  if (proxy.twin()) {
    context_.simulator.reappear(*proxy.twin(), context_.options.lost_after, step_recorder(context_));
    if (!proxy.augmented()) context_.simulator.monitor().set_virtual(proxy.twin_link.entity(), true);
  }
  augmented_.virtual_obstacles.new_session(*vehicle);
  return vehicle;
}

void VehicleLifecycle::retire(VehicleIndex vehicle, const std::string& reason) {
  COSIVA_EXPECT(vehicle < context_.registry.size());
  AivProxy& proxy = context_.registry[vehicle];
  proxy.on_retired(context_.now);
  master_.traffic.forget(vehicle);
  master_.orders.forget(vehicle);
  // The mission of a virtual AIV is retained until the AIV is added again (begin_life): the digest of a run contains
  // the missions of all vehicles, retired ones included, and a mission dropped here would change the digests of
  // recorded runs. The monitor counts no virtual AIV, and the summary of a run lists it as present.
  if (!proxy.augmented()) {
    context_.simulator.monitor().set_physical(proxy.twin_link.entity(), false);
    context_.simulator.monitor().set_virtual(proxy.twin_link.entity(), false);
    master_.missions.forget(vehicle);
  }
  master_.actions.forget(vehicle);
  master_.commands.forget(vehicle, reason);
  augmented_.virtual_obstacles.new_session(vehicle);
  context_.state_stale = true;
  COSIVA_EXPECT(!master_.orders.has_order(vehicle));
}

void VehicleLifecycle::depart(VehicleIndex vehicle, std::string_view by, std::string_view reason) {
  AivProxy& proxy = context_.registry[vehicle];
  COSIVA_EXPECT((proxy.here() || proxy.membership.awaited()) && !proxy.augmented());
  context_.traces.add(context_.now, by, "AIV_Server", "retire", proxy.name() + ": " + std::string(reason));
  if (proxy.twin()) context_.simulator.disappear(*proxy.twin(), step_recorder(context_));
  retire(vehicle, proxy.name() + " has left the zone");
  proxy.membership.on_departed();
  context_.publisher.log('i', proxy.name() + ": has left the zone; " + std::string(reason));
}

void VehicleLifecycle::remove_expired() {
  const SimDuration after = context_.options.entries_expire_after;
  if (after == SimDuration::zero() || context_.now - expiry_checked_at_ < expiry_period) return;
  expiry_checked_at_ = context_.now;
  const Registry& registry = context_.registry;
  for (VehicleIndex v = 0; v < registry.size(); ++v) {
    if (registry.vacant(v) || !registry[v].unconfirmed()) continue;
    if (context_.now - registry[v].membership.last_received() < after) continue;
    context_.publisher.log('i', registry[v].name() + ": removed, as it never proved to be a vehicle");
    remove(v);
  }
}

void VehicleLifecycle::remove(VehicleIndex vehicle) {
  AivProxy& proxy = context_.registry[vehicle];
  COSIVA_EXPECT(proxy.unconfirmed());
  master_.persisted_missions.removed(vehicle);
  retire(vehicle, proxy.name() + " never proved to be a vehicle");
  spare_entities_.push_back(proxy.twin_link.entity());
  context_.registry.remove(vehicle);
}

void VehicleLifecycle::apply_priorities() {
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) apply_priority(v);
}

void VehicleLifecycle::apply_priority(VehicleIndex vehicle) {
  if (!context_.simulator.zone()) return;
  AivProxy& proxy = context_.registry[vehicle];
  proxy.settings.set_priority(context_.simulator.zone()->priority_of(proxy.name()));
  master_.traffic.set_priority(vehicle, proxy.settings.priority());
}

void VehicleLifecycle::apply_stop(AivProxy& proxy) const {
  if (master_.intentions.of(proxy.name()).stopped) proxy.settings.on_stop();
}

void VehicleLifecycle::renew_mission(VehicleIndex vehicle) {
  master_.missions.forget(vehicle);
  master_.persisted_missions.registered(vehicle);
}

void VehicleLifecycle::archive(Archive& archive) { archive(restored_pauses_, expiry_checked_at_, spare_entities_); }

}  // namespace cosiva::virtual_side
