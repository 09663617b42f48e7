// Several halls on one broker: claiming a vehicle that is nobody's, taking one over, handing it on and letting it go.
#include <utility>

#include "cosiva/virtual/server/core/inside.h"
#include "cosiva/zone/circuit/anchor.h"

namespace cosiva::virtual_side {
namespace {

/// A retained owner is heard first; so long a vehicle has to be there before anybody claims it.
constexpr SimDuration claim_after{std::chrono::seconds{1}};
/// What we said of a vehicle and have not heard come back is said again.
constexpr SimDuration say_again{std::chrono::seconds{2}};
constexpr SimDuration pose_age_max{std::chrono::seconds{1}};

bool stands_without_order(const wire::State& state) { return state.node_states.empty() && !state.driving; }

}  // namespace

bool ServerCore::Inside::is_for_halls(const wire::Input& input) {
  if (!areas.several()) return false;
  if (const auto id = wire::parse_own_topic(wire::owner_topic_prefix, input.source)) {
    on_owner(*id, input);
    return true;
  }
  if (const auto topic = wire::parse_hall_topic(input.source)) {
    if (topic->hall == areas.own()) return !input.source.starts_with(topics.zone_prefix);
    if (const auto heard = areas.on_hall(*topic, input); !heard)
      publisher.log('w', "the zone of hall '" + std::string(topic->hall) +
                             "' cannot be used, so no vehicle is sent there: " + to_string(heard.error()));
    return true;
  }
  std::optional<wire::VehicleId> id;
  std::string name;
  if (auto topic = wire::parse_vda_topic(input.source)) {
    id = std::move(topic->vehicle);
    name = std::move(topic->name);
  }
  for (const auto prefix : {wire::felt_topic_prefix, wire::seen_topic_prefix, wire::boards_topic_prefix})
    if (!id) id = wire::parse_own_topic(prefix, input.source);
  // Names that VDA 5050 does not allow are refused where all messages are.
  if (!id || !wire::valid_serial_number(id->manufacturer) || !wire::valid_serial_number(id->serial_number))
    return false;
  if (id->manufacturer == wire::virtual_manufacturer) return true;
  Halls::Vehicle* vehicle = areas.vehicle(*id);
  if (vehicle != nullptr) areas.overhear(*vehicle, name, input);
  return !areas.is_ours(*id);
}

void ServerCore::Inside::on_owner(const wire::VehicleId& id, const wire::Input& input) {
  Halls::Vehicle* vehicle = areas.vehicle(id);
  if (vehicle == nullptr) return;
  std::optional<wire::Owner> said;
  if (!input.payload.empty()) {
    auto owner = wire::owner_from_json(input.payload);
    if (!owner) {
      publisher.log(
          'w', wire::to_string(id) + ": who owns it cannot be read, so nothing changes: " + to_string(owner.error()));
      return;
    }
    said = std::move(*owner);
  }
  const std::string name = wire::to_string(id);
  traces.add(now, said ? std::string_view{said->hall} : std::string_view{"operator"}, name, "owner",
             said ? "it is hall " + said->hall + "'s" : "it is nobody's", input.source, input.payload);
  const bool was_ours = areas.is_ours(id);
  vehicle->owner = std::move(said);
  vehicle->owner_heard = true;
  vehicle->claimed_at.reset();
  vehicle->pose.reset();
  const bool ours = areas.is_ours(id);
  // What a broker kept is of the past: where it stands, it says itself.
  if (ours && !was_ours) take_over(*vehicle, input.flag);
  if (was_ours && !ours) let_go(*registry.find(name), vehicle->owner ? vehicle->owner->hall : std::string{});
}

void ServerCore::Inside::take_over(Halls::Vehicle& vehicle, bool kept) {
  const wire::Owner owner = *vehicle.owner;
  const std::string name = wire::to_string(vehicle.id);
  const auto index = vehicles.begin_life(vehicle.id);
  if (!index) {
    publisher.log('e', name + ": is this hall's, but it is one more than the vehicles a server takes");
    return;
  }
  AivProxy& proxy = registry[*index];
  if (vehicle.connection) reports.receive({*index, VehicleTopic::connection}, *vehicle.connection);
  if (vehicle.factsheet) reports.receive({*index, VehicleTopic::factsheet}, *vehicle.factsheet);
  if (owner.pose && !kept) {
    proxy.position_known = true;
    proxy.reported = owner.pose;
    reports.on_report(*index, now);
    twins.set_present(proxy);
    twins.place(*index, now, *owner.pose, wire::Velocity{});
  }
  publisher.log('i', name + ": is this hall's");
  state_stale = true;
  if (!owner.mission) return;
  const Mission mission{
      owner.mission->kind == "go" ? Mission::Kind::go : Mission::Kind::circulate, owner.mission->name, {}};
  if (missions.mission(*index) == Mission{} && zones.map() && missions.known(mission)) missions.give(*index, mission);
  // Said once, it is ours to remember: who starts again must not begin it again.
  say_owner(vehicle, {areas.own(), 0, now, owner.pose, std::nullopt});
}

void ServerCore::Inside::let_go(VehicleIndex vehicle, const std::string& hall) {
  const std::string& name = registry[vehicle].name;
  vehicles.retire(vehicle, hall.empty() ? name + " is nobody's any more" : name + " is hall " + hall + "'s now");
  publisher.log('i', name + ": let go" + (hall.empty() ? std::string{} : "; it is hall " + hall + "'s now"));
}

void ServerCore::Inside::say_owner(const Halls::Vehicle& vehicle, wire::Owner owner) {
  owner.sequence = vehicle.owner ? vehicle.owner->sequence + 1 : 1;
  publisher.publish(wire::own_topic(wire::owner_topic_prefix, vehicle.id), wire::to_json(owner), 1, true);
}

void ServerCore::Inside::say_lost_owners() {
  // A broker that was started anew may have forgotten whose they are.
  for (const auto& [name, vehicle] : areas.vehicles()) {
    const auto index = registry.find(name);
    if (index) registry[*index].handed_over.reset();
    if (areas.is_ours(vehicle.id) && !vehicle.owner_heard)
      say_owner(vehicle, {areas.own(), 0, now, index ? registry[*index].reported : std::nullopt, std::nullopt});
  }
}

void ServerCore::Inside::claim_vehicles() {
  if (!zones.map()) return;
  for (auto& [name, vehicle] : areas.vehicles()) {
    const bool waits = vehicle.claimed_at && now - *vehicle.claimed_at < say_again;
    if (vehicle.owner || !vehicle.pose || waits) continue;
    if (now - vehicle.pose_since < claim_after || now - vehicle.pose_at > pose_age_max) continue;
    if (now - link.up_since() < claim_after || !zone::anchor_of(zones.map()->circuit(), *vehicle.pose)) continue;
    vehicle.claimed_at = now;
    say_owner(vehicle, {areas.own(), 0, now, vehicle.pose, std::nullopt});
  }
}

void ServerCore::Inside::hand_over_arrived() {
  for (VehicleIndex v = 0; v < registry.size(); ++v) {
    AivProxy& proxy = registry[v];
    if (!proxy.here() || (proxy.handed_over && now - proxy.handed_over->last < say_again)) continue;
    const std::string& beyond = missions.mission(v).beyond;
    if (beyond.empty() || missions.state(v) != Missions::State::arrived || orders.has_order(v)) continue;
    const std::string hall = beyond.substr(0, beyond.find('/'));
    const bool there = proxy.online() && !proxy.lost(now, options.lost_after) && proxy.position_known;
    if (!there || !proxy.state || !stands_without_order(*proxy.state) || !areas.is_there(hall)) continue;
    Halls::Vehicle* vehicle = areas.vehicle(proxy.id);
    if (vehicle == nullptr) continue;
    // It stays ours until we hear this ourselves, as the other server does; which of us hears it first nobody knows, so
    // we stop showing it now: it is in no table for one message at most, and never in two.
    proxy.handed_over = {proxy.handed_over ? proxy.handed_over->first : now, now};
    say_owner(*vehicle, {hall, 0, now, proxy.reported, wire::Owner::Mission{"go", beyond.substr(hall.size() + 1)}});
  }
}

}  // namespace cosiva::virtual_side
