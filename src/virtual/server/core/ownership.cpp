#include "cosiva/virtual/server/core/ownership.h"

#include <utility>

#include "cosiva/base/expect.h"
#include "cosiva/zone/circuit/path_snap.h"

namespace cosiva::virtual_side {
namespace {

/// Time that a vehicle has to be present before a server claims it: a retained owner is received first.
constexpr SimDuration claim_after{std::chrono::seconds{1}};
/// An owner that has been published and not been received back is published again after this time.
constexpr SimDuration publish_again{std::chrono::seconds{2}};
constexpr SimDuration pose_age_max{std::chrono::seconds{1}};

bool is_stopped_without_order(const wire::State& state) { return state.node_states.empty() && !state.driving; }

}  // namespace

Ownership::Ownership(ServerContext& context, MasterControl& master, VehicleLifecycle& vehicles, TwinPlacement& twins,
                     VehicleReports& reports, const ZoneSession& zones)
    : context_{context}, master_{master}, vehicles_{vehicles}, twins_{twins}, reports_{reports}, zones_{zones} {
  if (!context_.areas.several()) return;
  master_.mission_requests.set_abroad(
      [this](std::string_view to) { return context_.areas.route_to(to, zones_.map()->zone(), master_.missions); });
}

void Ownership::claim_and_hand_over() {
  if (!context_.areas.several()) return;
  claim_vehicles();
  hand_over_arrived();
}

bool Ownership::receive(const wire::Input& input) {
  if (!context_.areas.several()) return false;
  if (const auto id = wire::parse_own_topic(wire::owner_topic_prefix, input.source)) {
    on_owner(*id, input);
    return true;
  }
  if (const auto topic = wire::parse_area_topic(input.source)) {
    if (topic->area == context_.areas.own()) return !input.source.starts_with(context_.topics.zone_prefix);
    if (const auto received = context_.areas.on_area(*topic, input); !received)
      context_.publisher.log('w', "the zone of control area '" + std::string(topic->area) +
                                      "' cannot be used, so no vehicle is sent there: " + to_string(received.error()));
    return true;
  }
  std::optional<wire::VehicleId> id;
  std::string name;
  if (auto topic = wire::parse_vda_topic(input.source)) {
    id = std::move(topic->vehicle);
    name = std::move(topic->name);
  }
  for (const auto prefix :
       {wire::virtual_obstacles_ack_topic_prefix, wire::detected_obstacle_topic_prefix, wire::boards_topic_prefix})
    if (!id) id = wire::parse_own_topic(prefix, input.source);
  // Names that VDA 5050 does not permit are refused where all messages are refused.
  if (!id || !wire::valid_serial_number(id->manufacturer) || !wire::valid_serial_number(id->serial_number))
    return false;
  if (id->manufacturer == wire::virtual_manufacturer) return true;
  ControlAreas::Vehicle* vehicle = context_.areas.vehicle(*id);
  if (vehicle != nullptr) context_.areas.overhear(*vehicle, name, input);
  return !context_.areas.owns(*id);
}

void Ownership::on_owner(const wire::VehicleId& id, const wire::Input& input) {
  ControlAreas::Vehicle* vehicle = context_.areas.vehicle(id);
  if (vehicle == nullptr) return;
  std::optional<wire::Owner> now_owner;
  if (!input.payload.empty()) {
    auto owner = wire::owner_from_json(input.payload);
    if (!owner) {
      context_.publisher.log(
          'w', wire::to_string(id) + ": its owner cannot be read, so nothing changes: " + to_string(owner.error()));
      return;
    }
    now_owner = std::move(*owner);
  }
  const std::string name = wire::to_string(id);
  context_.traces.add(context_.now, now_owner ? std::string_view{now_owner->area} : std::string_view{"operator"}, name,
                      "owner", now_owner ? "owned by control area " + now_owner->area : "no owner", input.source,
                      input.payload);
  const bool was_own = context_.areas.owns(id);
  vehicle->owner = std::move(now_owner);
  vehicle->owner_received = true;
  vehicle->claimed_at.reset();
  vehicle->pose.reset();
  const bool is_own = context_.areas.owns(id);
  // A retained owner is outdated: the vehicle itself reports its position.
  if (is_own && !was_own) take_over(*vehicle, input.flag);
  if (is_own) return;
  // An entry that never proved to be a vehicle may have been removed.
  const auto index = context_.registry.find(name);
  if (index && (was_own || context_.registry[*index].membership.awaited()))
    let_go(*index, vehicle->owner ? vehicle->owner->area : std::string{});
}

void Ownership::take_over(ControlAreas::Vehicle& vehicle, bool retained) {
  const wire::Owner owner = *vehicle.owner;
  const std::string name = wire::to_string(vehicle.id);
  COSIVA_EXPECT(context_.areas.owns(vehicle.id));
  const auto index = vehicles_.begin_life(vehicle.id);
  if (!index) {
    context_.publisher.log(
        'e', name + ": belongs to this control area, but exceeds the number of vehicles that a server accepts");
    return;
  }
  AivProxy& proxy = context_.registry[*index];
  if (vehicle.connection) reports_.receive({*index, VehicleTopic::connection}, *vehicle.connection);
  if (vehicle.factsheet) reports_.receive({*index, VehicleTopic::factsheet}, *vehicle.factsheet);
  if (owner.pose && !retained) {
    proxy.position.on_handover(*owner.pose);
    reports_.on_report(*index, context_.now);
    twins_.set_present(proxy);
    twins_.put(*index, context_.now, *owner.pose, wire::Velocity{});
  }
  context_.publisher.log('i', name + ": belongs to this control area");
  context_.state_stale = true;
  if (!owner.mission) return;
  give_mission(*index, *owner.mission);
  // From here on this server persists the mission: the mission must not begin again after a restart.
  publish_owner(vehicle, {context_.areas.own(), 0, context_.now, owner.pose, std::nullopt});
}

void Ownership::give_mission(VehicleIndex vehicle, const wire::Owner::Mission& handed_on) {
  const Mission mission{handed_on.kind == "go" ? Mission::Kind::go : Mission::Kind::circulate, handed_on.name, {}};
  if (master_.missions.mission(vehicle) == Mission{} && zones_.map() && is_known(*zones_.map(), mission))
    master_.missions.give(vehicle, mission);
}

void Ownership::let_go(VehicleIndex vehicle, const std::string& area) {
  COSIVA_EXPECT(!context_.areas.owns(context_.registry[vehicle].id()));
  const std::string& name = context_.registry[vehicle].name();
  vehicles_.retire(vehicle,
                   area.empty() ? name + " has no owner any more" : name + " belongs to control area " + area + " now");
  context_.publisher.log(
      'i', name + ": released" + (area.empty() ? std::string{} : "; it belongs to control area " + area + " now"));
}

void Ownership::publish_owner(const ControlAreas::Vehicle& vehicle, wire::Owner owner) {
  owner.sequence = vehicle.owner ? vehicle.owner->sequence + 1 : 1;
  context_.publisher.publish(wire::own_topic(wire::owner_topic_prefix, vehicle.id), wire::to_json(owner), 1, true);
}

void Ownership::publish_lost_owners() {
  for (const auto& [name, vehicle] : context_.areas.vehicles()) {
    const auto index = context_.registry.find(name);
    if (index) context_.registry[*index].membership.on_handover_void();
    if (context_.areas.owns(vehicle.id) && !vehicle.owner_received)
      publish_owner(vehicle, {context_.areas.own(), 0, context_.now,
                              index ? context_.registry[*index].position.pose() : std::nullopt, std::nullopt});
  }
}

void Ownership::claim_vehicles() {
  if (!zones_.map()) return;
  for (auto& [name, vehicle] : context_.areas.vehicles()) {
    const bool waits = vehicle.claimed_at && context_.now - *vehicle.claimed_at < publish_again;
    if (vehicle.owner || !vehicle.pose || waits) continue;
    if (context_.now - vehicle.pose_since < claim_after || context_.now - vehicle.pose_at > pose_age_max) continue;
    if (context_.now - context_.link.up_since() < claim_after ||
        !zone::snap_to_path(zones_.map()->circuit(), *vehicle.pose))
      continue;
    vehicle.claimed_at = context_.now;
    publish_owner(vehicle, {context_.areas.own(), 0, context_.now, vehicle.pose, std::nullopt});
  }
}

void Ownership::hand_over_arrived() {
  for (VehicleIndex v = 0; v < context_.registry.size(); ++v) {
    AivProxy& proxy = context_.registry[v];
    const auto& handed_over = proxy.membership.handed_over();
    if (!proxy.here() || (handed_over && context_.now - handed_over->last < publish_again)) continue;
    const std::string& beyond = master_.missions.mission(v).beyond;
    if (beyond.empty() || master_.missions.state(v) != Missions::State::arrived || master_.orders.has_order(v))
      continue;
    // The other server would not know of the Stop, and this one would enforce it when the vehicle returns.
    if (master_.intentions.of(proxy.name()).stopped) continue;
    const std::string area = beyond.substr(0, beyond.find('/'));
    const bool there =
        proxy.online() && !proxy.lost(context_.now, context_.options.lost_after) && proxy.position.known();
    if (!there || !proxy.state() || !is_stopped_without_order(*proxy.state()) || !context_.areas.is_there(area))
      continue;
    ControlAreas::Vehicle* vehicle = context_.areas.vehicle(proxy.id());
    if (vehicle == nullptr) continue;
    // The vehicle belongs to this area until both servers receive the new owner, in either order. Therefore this server
    // stops showing it now: the vehicle is in no table for at most one message, and never in two.
    proxy.membership.on_handed_over(context_.now);
    publish_owner(*vehicle, {area, 0, context_.now, proxy.position.pose(),
                             wire::Owner::Mission{"go", beyond.substr(area.size() + 1)}});
  }
}

}  // namespace cosiva::virtual_side
